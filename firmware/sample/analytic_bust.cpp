#include "firmware/sample/analytic_bust.hpp"

#include <algorithm>
#include <cmath>

namespace plumbline::firmware {
namespace {

// Scales the result down, because ellipsoids, tapered capsules and displaced shells give values that grow a little faster
// than the distance. Smaller is safer but takes more steps.
constexpr double kSafety = 0.6;

// A part whose bounding sphere is farther away than this is skipped: no blend reaches that far.
constexpr double kFar = 2.5;  // mm

double absolute(double a) { return a < 0 ? -a : a; }

double smooth_min(double a, double b, double k) {
  const double h = std::max(k - absolute(a - b), 0.0);
  return std::min(a, b) - h * h / (4.0 * k);
}
double smooth_max(double a, double b, double k) { return -smooth_min(-a, -b, k); }

/// 0 below `low`, 1 above `high`, a cubic between.
double ramp(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

/// A smooth wave of period 1, values 0 to 1, 1 at the integers: two parabolas a period in place of a cosine.
double wave(double phase) {
  const auto whole = static_cast<double>(static_cast<long long>(phase + (phase < 0 ? -0.5 : 0.5)));
  const double t = 2.0 * absolute(phase - whole);  // 0 at the crest, 1 in the trough
  return t < 0.5 ? 1.0 - 2.0 * t * t : 2.0 * (1.0 - t) * (1.0 - t);
}

/// A substitute for the angle of (x, y): -2 to 2, monotonous, 0 on the positive x axis.
double diamond_angle(double x, double y) {
  const double sum = absolute(x) + absolute(y);
  if (sum == 0.0) return 0.0;
  if (x >= 0) return y / sum;
  return y >= 0 ? 2.0 - y / sum : -2.0 - y / sum;
}

/// Maps both halves to x > 0 without a crease where they meet: |x|, rounded within `round` of 0.
Vec3d mirrored(const Vec3d& p, double round) { return {std::sqrt(p.x() * p.x() + round * round), p.y(), p.z()}; }

double sphere(const Vec3d& p, const Vec3d& centre, double radius) { return (p - centre).norm() - radius; }

// Always inlined, so that the compiler computes the reciprocals of constant radii and lengths: a scan evaluates the
// distance some ten million times.
[[gnu::always_inline]] inline double ellipsoid(const Vec3d& p, const Vec3d& centre, const Vec3d& radii) {
  const Vec3d inverse{1.0 / radii.x(), 1.0 / radii.y(), 1.0 / radii.z()};
  const Vec3d q = (p - centre).cwiseProduct(inverse);
  const double k0 = q.norm();
  const double k1 = q.cwiseProduct(inverse).norm();
  if (k1 == 0.0) return -radii.minCoeff();
  return k0 * (k0 - 1.0) / k1;
}

/// Capsule from `a` to `b` whose radius changes linearly.
[[gnu::always_inline]] inline double capsule(const Vec3d& p, const Vec3d& a, const Vec3d& b, double radius_a,
                                             double radius_b) {
  const Vec3d ab = b - a;
  const double inverse = 1.0 / ab.squaredNorm();
  const double t = std::clamp((p - a).dot(ab) * inverse, 0.0, 1.0);
  return (p - a - t * ab).norm() - (radius_a + t * (radius_b - radius_a));
}

/// Upright cylinder on the axis (0, y), its edges rounded by `round`.
double cylinder(const Vec3d& p, double y, double radius, double low, double high, double round) {
  const double across = std::sqrt(p.x() * p.x() + (p.y() - y) * (p.y() - y)) - radius + round;
  const double along = absolute(p.z() - 0.5 * (low + high)) - 0.5 * (high - low) + round;
  const double ax = std::max(across, 0.0), az = std::max(along, 0.0);
  return std::sqrt(ax * ax + az * az) + std::min(std::max(across, along), 0.0) - round;
}

/// Ring about the upright axis through (0, y).
double ring(const Vec3d& p, double y, double z, double radius, double thickness) {
  const double across = std::sqrt(p.x() * p.x() + (p.y() - y) * (p.y() - y)) - radius;
  return std::sqrt(across * across + (p.z() - z) * (p.z() - z)) - thickness;
}

constexpr double kStrandDepth = 0.45;  // mm

/// Strands on the surface where `mass` is 0, which reach kStrandDepth above it.
double hair(const Vec3d& p, double mass) {
  if (mass > 1.5) return mass - kStrandDepth;
  // Strands are meridians about an axis that runs from the forehead to the knot, and sway a little on their way.
  const double sway = wave(p.y() * 0.16 + 0.02 * p.z()) - 0.5;
  const double angle = diamond_angle(p.z() - 46.0, p.x());
  const double strands = wave(angle * 12.0 + 0.5 + 0.5 * sway);
  // The grooves are steeper than the rest. Both terms bound the distance, so their maximum does.
  return std::max(mass - kStrandDepth, 0.45 * (mass - kStrandDepth * strands));
}

/// The knot behind, its strands turned in a spiral.
double knot(const Vec3d& p) {
  constexpr double kDepth = 0.4;  // mm
  const Vec3d q = p - Vec3d{0, 12.0, 47.0};
  const double mass = ellipsoid(q, {0, 0, 0}, {4.2, 3.6, 4.0});
  if (mass > 1.5) return mass - kDepth;
  const double radius = std::sqrt(q.x() * q.x() + q.z() * q.z());
  const double swirl = ramp(0.2, 1.6, radius) * wave(diamond_angle(q.z(), q.x()) * 2.0 + 0.45 * radius);
  return std::max(mass - kDepth, 0.6 * (mass - kDepth * swirl));
}

/// Brows, eyes, nose and mouth on a face at distance `d`.
double features(const Vec3d& p, double d) {
  // Eyes: a socket, a brow above it, a ball with lids and a drilled pupil.
  d = smooth_max(d, -ellipsoid(p, {3.0, -10.2, 46.5}, {2.6, 2.2, 1.6}), 1.8);
  d = smooth_min(d, capsule(p, {1.7, -8.5, 48.5}, {3.5, -8.1, 48.9}, 0.3, 0.35), 1.3);
  d = smooth_min(d, capsule(p, {3.5, -8.1, 48.9}, {5.5, -5.0, 47.3}, 0.35, 0.05), 1.3);
  {
    const Vec3d eye{3.05, -6.75, 46.35};
    const double across = p.x() - 2.95;
    const double ball = sphere(p, eye, 1.62);
    const double lid = sphere(p, eye, 1.88);
    const double upper = 47.05 - p.z() - 0.16 * across * across;  // above 0 under the upper lid's edge
    const double lower = p.z() - 45.65 - 0.07 * across * across;  // above 0 over the lower lid's edge
    d = smooth_min(d, ball, 0.3);
    d = smooth_min(d, smooth_max(lid, upper, 0.2), 0.4);
    d = smooth_min(d, smooth_max(lid, lower, 0.2), 0.4);
    d = smooth_max(d, -sphere(p, {2.95, -8.45, 46.45}, 0.36), 0.15);
  }

  // Nose.
  d = smooth_min(d, capsule(p, {0, -8.75, 47.8}, {0, -10.85, 43.3}, 0.55, 0.75), 1.2);
  d = smooth_min(d, sphere(p, {0, -10.95, 43.05}, 0.85), 0.7);
  d = smooth_min(d, ellipsoid(p, {1.05, -9.7, 42.6}, {0.65, 1.0, 0.65}), 0.6);
  d = smooth_max(d, -ellipsoid(p, {0.6, -10.3, 41.9}, {0.35, 0.6, 0.4}), 0.35);

  // Mouth.
  d = smooth_min(d, capsule(p, {0.45, -9.6, 40.0}, {2.05, -8.45, 39.6}, 0.5, 0.15), 0.5);
  d = smooth_min(d, capsule(p, {0, -9.3, 38.85}, {1.35, -8.75, 39.15}, 0.68, 0.35), 0.5);
  d = smooth_max(d, -capsule(p, {0, -10.25, 39.5}, {2.1, -8.75, 39.45}, 0.16, 0.08), 0.3);
  d = smooth_max(d, -capsule(p, {0, -9.95, 41.5}, {0, -10.1, 40.7}, 0.3, 0.35), 0.5);  // philtrum
  return d;
}

/// Leaning back, and hollowed.
double ear_shell(const Vec3d& p) {
  const Vec3d q{p.x() - 7.2 - 0.25 * (p.y() - 1.5), p.y() - 1.6 - 0.25 * (p.z() - 45.0), p.z() - 45.0};
  const double outer = ellipsoid(q, {0, 0, 0}, {0.95, 1.75, 2.9});
  const double shell = smooth_max(outer, -ellipsoid(q, {1.0, -0.2, 0.45}, {0.8, 1.1, 1.8}), 0.3);
  return smooth_min(shell, ellipsoid(q, {0.3, 0.45, -0.1}, {0.45, 0.35, 1.2}), 0.35);
}

/// The head in its own coordinates, before it is turned on the neck.
double head(const Vec3d& both) {
  const Vec3d p = mirrored(both, 0.25);
  // Skull and face.
  double d = ellipsoid(p, {0, 1.4, 48.6}, {7.7, 9.9, 9.2});
  d = smooth_min(d, ellipsoid(p, {0, -2.8, 43.8}, {6.3, 6.6, 8.2}), 2.5);
  d = smooth_min(d, capsule(p, {1.6, -6.4, 37.6}, {5.0, 0.0, 41.2}, 1.7, 1.9), 2.8);  // jaw
  d = smooth_min(d, ellipsoid(p, {0, -6.2, 40.2}, {2.9, 3.0, 3.3}), 2.2);             // muzzle
  d = smooth_min(d, ellipsoid(p, {0, -7.75, 36.7}, {1.9, 1.8, 1.5}), 1.6);            // chin
  d = smooth_min(d, ellipsoid(p, {4.3, -5.7, 44.0}, {1.9, 1.9, 1.7}), 2.4);           // cheekbone

  const double face = sphere(p, {1.8, -8.6, 44.2}, 6.5);
  d = face > kFar ? std::min(d, face) : features(p, d);
  const double ear = sphere(p, {7.7, 1.6, 45.0}, 3.2);
  d = ear > kFar ? std::min(d, ear) : smooth_min(d, ear_shell(p), 0.5);

  // Hair: a cap over the skull, cut back from the face, a band over it, a knot behind.
  {
    const double cap = ellipsoid(p, {0, 1.9, 48.9}, {8.5, 10.6, 9.9});
    const double nape = ellipsoid(p, {0, 4.4, 43.0}, {5.6, 5.6, 5.5});
    const double mass = smooth_min(cap, nape, 3.0);
    const double shell = hair(p, mass);
    // Hair is behind the ear below, above the ear at the temple, above the forehead in front.
    const double behind = 2.6 - p.y() + 0.15 * (45.0 - p.z());                       // < 0 behind the ear
    const double over = 52.6 - p.z() - 0.62 * (p.y() + 8.0) + 0.02 * p.x() * p.x();  // < 0 above the hairline
    const double region = 0.8 * smooth_min(behind, over, 2.5);
    d = smooth_min(d, smooth_max(shell, region, 0.7), 0.25);

    // The band lies on the hair, tilted from above the forehead to below the knot.
    const double tilted = 0.90 * (p.z() - 52.2) + 0.44 * (p.y() - 1.0);
    const double band = smooth_max(absolute(mass - 0.15) - 0.4, absolute(tilted) - 0.75, 0.3);
    d = smooth_min(d, band, 0.15);
  }
  return smooth_min(d, knot(p), 0.4);
}

double neck(const Vec3d& p) {
  const double d = capsule(p, {0, 2.6, 26.0}, {0, 1.2, 40.0}, 5.6, 4.7);
  return smooth_min(d, capsule(mirrored(p, 0.8), {1.5, -4.6, 28.4}, {5.8, 2.6, 40.5}, 0.8, 1.1), 1.6);
}

double torso(const Vec3d& p) {
  const Vec3d m = mirrored(p, 1.5);
  double d = ellipsoid(p, {0, 1.0, 20.5}, {14.0, 8.0, 11.0});
  d = smooth_min(d, capsule(m, {5.0, 1.8, 28.2}, {14.6, 1.8, 23.8}, 4.2, 5.0), 4.0);
  d = smooth_min(d, ellipsoid(m, {5.4, -3.2, 20.0}, {4.6, 4.4, 4.6}), 3.0);
  d = smooth_min(d, neck(p), 3.0);

  // The garment: a layer over the body, its neckline low in front, its folds rings about the neck that deepen downwards
  // and end at the shoulders.
  constexpr double kThickness = 0.35, kFoldDepth = 0.75;  // mm
  if (d > 5.0) {
    d -= kThickness + kFoldDepth;
  } else {
    const double drop = std::max(31.5 - p.z(), 0.0);  // the neck above stays bare
    const double reach = std::sqrt(p.x() * p.x() + 1.45 * drop * drop + 0.15 * (p.y() - 1.0) * (p.y() - 1.0));
    const double depth = kFoldDepth * ramp(7.0, 12.0, reach) * (1.0 - 0.85 * ramp(12.0, 18.0, absolute(p.x())));
    const double folds = wave(0.36 * (reach - 7.6) + 0.3 * wave(0.05 * p.x() + 0.15));
    const double cloth = 0.8 * (d - kThickness - depth * folds);
    d = smooth_min(d, smooth_max(cloth, 8.0 - reach, 0.6), 0.2);
  }
  return smooth_max(d, 11.5 - p.z(), 2.0);
}

double plinth(const Vec3d& p) {
  double d = cylinder(p, 1.0, 15.0, -2.0, 3.0, 0.7);
  d = std::min(d, cylinder(p, 1.0, 12.6, 0.0, 4.6, 0.5));
  d = smooth_min(d, cylinder(p, 1.0, 6.6, 0.0, 15.0, 0.5), 3.0);
  d = smooth_min(d, ring(p, 1.0, 9.0, 6.9, 0.9), 0.6);
  return d;
}

}  // namespace

double bust_distance(const Vec3d& p) {
  // Above 24 mm the plinth's top at 15 mm is out of reach of every blend.
  double d = p.z() > 24.0 ? p.z() - 15.0 : plinth(p);
  const double body = sphere(p, {0, 1.6, 25.0}, 21.5);
  d = smooth_min(d, body > kFar ? body : torso(p), 1.2);
  const double skull = sphere(p, {0, 2.0, 47.5}, 15.0);
  if (skull > kFar) {
    d = smooth_min(d, skull, 1.5);
  } else {
    // The head is turned to its right by 13.7 degrees: t = 0.12 in the rational form of cosine and sine.
    constexpr double kT = 0.12, kCos = (1 - kT * kT) / (1 + kT * kT), kSin = 2 * kT / (1 + kT * kT);
    const double y = p.y() - 1.5;
    d = smooth_min(d, head({kCos * p.x() - kSin * y, 1.5 + kSin * p.x() + kCos * y, p.z()}), 1.5);
  }
  return kSafety * std::max(d, -p.z());
}

bool bust_inside(const Vec3d& p) { return bust_distance(p) < 0.0; }

Box3d bust_bounds() {
  Box3d box;
  box.extend(Vec3d{-22, -16, 0});
  box.extend(Vec3d{22, 18, 61});
  return box;
}

}  // namespace plumbline::firmware
