#pragma once
/// A bust defined by a formula: its scans need no download and no licence, and its true surface is known everywhere.

#include "slicer/core/numbers/vec.hpp"

namespace plumbline::firmware {

/// Signed bound of the distance from `p` to the bust: negative inside, zero on its surface, positive outside.
///
/// A union of ellipsoids and capsules, blended by the polynomial smooth minimum
///   smin(a, b) = min(a, b) - h^2 / (4 k),  h = max(k - |a - b|, 0)            (Quilez 2013, quadratic form)
/// and cut flat at the underside, z = 0. Outside, the value never exceeds the true distance, so a step of that length along
/// any ray does not pass the surface. It is a bound, not the distance itself.
///
/// Uses only + - * / and sqrt, so it gives the same bits on every machine.
///
/// @param p  bust coordinates, mm: z up from the underside, the face looks towards -y and a little towards -x
/// @returns mm
double bust_distance(const Vec3d& p);

/// True inside the solid; points of the surface itself are outside.
bool bust_inside(const Vec3d& p);

/// A box round the whole bust, mm. Its low z is 0, the underside.
Box3d bust_bounds();

}  // namespace plumbline::firmware
