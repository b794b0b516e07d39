#pragma once
/// The project's own sculpture: a bust that is a formula. A scan of it costs no download, carries no licence, and its
/// true surface is known everywhere.

#include "slicer/core/vec.hpp"

namespace plumbline {

/// Signed bound of the distance from `p` to the bust: negative inside, zero on its surface, positive outside.
///
/// A union of ellipsoids and capsules, blended by the polynomial smooth minimum
///   smin(a, b) = min(a, b) - h^2 / (4 k),  h = max(k - |a - b|, 0)            (Quilez 2013, quadratic form)
/// and cut flat at the underside, z = 0. Outside, the value is never above the true distance, so that a step of that
/// length along any ray does not pass the surface; this makes it a bound and not the distance itself.
///
/// Made of + - * / and sqrt alone: the same bits on every machine.
///
/// @param p  bust coordinates, mm: z up from the underside, the face looks towards -y and a little towards -x
/// @returns mm
double bust_distance(const Vec3d& p);

/// True inside the solid; points of the surface itself are outside.
bool bust_inside(const Vec3d& p);

/// A box round the whole bust, mm. Its low z is 0, the underside.
Box3d bust_bounds();

}  // namespace plumbline
