#include "slicer/surface/bores/round_bores.hpp"

#include <bit>
#include <cmath>

#include "slicer/core/frame.hpp"
#include "slicer/surface/bores/cylinder.hpp"

namespace plumbline {
namespace {

constexpr float kToleranceEpsilons = 0.1F;
constexpr float kToleranceNoise = 2.5F;  ///< times the standard deviation of a point from its sheet
constexpr float kMostTolerance = 0.4F;   ///< of the radius: more tells no cylinder
constexpr std::array<float, 7> kCoarse = {0.25F, 0.25F, 0.18F, 0.18F, 0.12F, 0.12F, 0.12F};  ///< of the width
constexpr float kMostRadius = 1;      ///< of the width, of the first cylinder
constexpr float kLeastRadius = 0.3F;  ///< of the width
constexpr float kMostChange = 2;      ///< times the radius, on the way along the bore
constexpr float kStep = 0.5F;         ///< of the radius
constexpr float kLeastStep = 0.125F;  ///< of the radius: so near to a mouth it stops
constexpr float kLongest = 16;        ///< radii
constexpr float kUnseen = 2;          ///< times epsilon
constexpr float kMargin = 0.2F;       ///< of the radius: what is so near to an end does not tell the last fit anything
constexpr float kRound = 1.5F;        ///< radii: what is farther from the axis is not looked at
constexpr float kWithin = 0.6F;       ///< radii: what is nearer to the axis stands in the bore
constexpr std::uint32_t kBottom = 4;  ///< points of the surface within a step of a bore are its bottom
constexpr float kAcross = 0.7F;       ///< least inner product of a face's normal with the axis
constexpr float kFacing = 0.3F;       ///< least inner product of a wall's normal with the way to the axis
constexpr int kWall = 7, kBare = 5;   ///< of eight directions
constexpr int kMouth = 4;             ///< of eight directions
constexpr std::uint32_t kSurer = 3;   ///< points of its wall for each of another
constexpr float kApart = 0.3F;        ///< of the width: nothing starts so near to where nothing started
constexpr float kSwept = 1.3F;        ///< radii: what is nearer to the axis belongs to the bore

/// A turn by the angle that has this tangent of its half. No sine is asked for: they differ from one C library to another.
class Turn {
 public:
  explicit Turn(float half)
      : step_cosine_((1 - half * half) / (1 + half * half)), step_sine_(2 * half / (1 + half * half)) {}
  float cosine() const { return cosine_; }
  float sine() const { return sine_; }
  void go_on() {
    const float cosine = cosine_ * step_cosine_ - sine_ * step_sine_;
    const float sine = sine_ * step_cosine_ + cosine_ * step_sine_;
    past_half_ |= sine < 0;
    full_ = past_half_ && sine >= 0;
    cosine_ = cosine;
    sine_ = sine;
  }
  bool full() const { return full_; }

 private:
  float step_cosine_, step_sine_;
  float cosine_ = 1, sine_ = 0;
  bool past_half_ = false, full_ = false;
};
constexpr float kTwelfth = 0.13165250F;  ///< tan(7.5 degrees)

/// What there is round a stretch of a cylinder.
struct Section {
  std::uint32_t wall = 0;    ///< a bit for each of eight directions that has some
  std::uint32_t mouth = 0;   ///< and for those that have a face round it
  std::uint32_t on = 0;      ///< points of its wall
  std::uint32_t beside = 0;  ///< of other walls that face its axis
  std::uint32_t within = 0;
};

struct Stretch {
  float from = 0, to = 0;
  float length() const { return to - from; }
};

struct Bore {
  Cylinder cylinder;
  Stretch walled;
};

std::uint32_t octant(float t, float s) {
  return (t > 0 ? 1U : 0U) | (s > 0 ? 2U : 0U) | (std::abs(t) > std::abs(s) ? 4U : 0U);
}

class RoundBores {
 public:
  explicit RoundBores(BoreSurface& surface)
      : surface_(surface),
        tolerance_(std::max(kToleranceEpsilons * surface.epsilon(), kToleranceNoise * surface.noise())) {}

  std::optional<Bore> from(const BoreEnd& end) const {
    const Vec3f n = surface_.normal(end.point);
    const float width = end.width;
    const Frame frame(n);
    Turn turn(kTwelfth);
    for (int k = 0; k < 12; ++k, turn.go_on()) {
      Cylinder c{surface_.position(end.point) + n * (0.5F * width), frame.at(turn.cosine(), turn.sine()), 0.5F * width};
      if (std::popcount(section(c, {-0.5F * width, 0.5F * width}, 0.25F * width, 0).wall) < kWall) continue;
      const bool fits = std::all_of(kCoarse.begin(), kCoarse.end(), [&](float tolerance) {
        return fit(c, {-width, width}, std::max(tolerance * width, tolerance_), true) &&
               c.radius < kMostRadius * width && c.radius > kLeastRadius * width;
      });
      if (!fits) continue;
      if (auto bore = follow(c)) return bore;
    }
    return std::nullopt;
  }

  bool contains(const Bore& bore, const Vec3f& x) const {
    const Cylinder& c = bore.cylinder;
    const OnCylinder seen = seen_from(c, x);
    return seen.distance < kSwept * c.radius && seen.along > bore.walled.from - c.radius &&
           seen.along < bore.walled.to + c.radius;
  }

  void settle(const Bore& bore) {
    const Cylinder& c = bore.cylinder;
    for_stretch(c, bore.walled, kSwept * c.radius, [&](std::uint32_t i, const OnCylinder& seen) {
      // Beyond the wall is the inside of the object, or of a thin wall its other side.
      const bool other_side = seen.distance > c.radius && surface_.normal(i).dot(seen.outwards) > 0;
      if (is_wall(i, c, seen, tolerance_)) {
        surface_.turn(i, -seen.outwards);
      } else if (surface_.hardly_seen(i) && !other_side) {
        surface_.drop(i);
      }
    });
    const float spacing = BoreSurface::kSpacing * surface_.epsilon();
    const Frame frame(c.axis);
    const auto rings = static_cast<int>(bore.walled.length() / spacing) + 1;
    for (int k = 0; k <= rings; ++k) {
      const float share = static_cast<float>(k) / static_cast<float>(rings);
      const Vec3f middle = c.on_axis(bore.walled.from + bore.walled.length() * share);
      for (Turn turn(0.5F * spacing / c.radius); !turn.full() && !surface_.full(); turn.go_on()) {
        const Vec3f outwards = frame.at(turn.cosine(), turn.sine());
        const Vec3f x = middle + outwards * c.radius;
        if (!surface_.has_wall(x, -outwards)) surface_.add(x, -outwards);
      }
    }
  }

 private:
  /// Calls visit(i, seen) for the points of the scan at most so far from the axis.
  template <class Visit>
  void for_stretch(const Cylinder& c, const Stretch& stretch, float reach, Visit visit) const {
    Box3f box;
    box.extend(c.on_axis(stretch.from));
    box.extend(c.on_axis(stretch.to));
    const Vec3f margin = Vec3f::Constant(reach);
    surface_.visit_box(box.low - margin, box.high + margin, [&](std::uint32_t i) {
      const OnCylinder seen = seen_from(c, surface_.position(i));
      if (seen.along >= stretch.from && seen.along < stretch.to && seen.distance <= reach) visit(i, seen);
    });
  }

  /// Whether it lies on the cylinder and is not seen well to be something else: a face, or the outside of a thin wall.
  bool is_wall(std::uint32_t i, const Cylinder& c, const OnCylinder& seen, float tolerance) const {
    if (std::abs(seen.distance - c.radius) >= tolerance) return false;
    if (surface_.hardly_seen(i)) return true;
    const Vec3f n = surface_.normal(i);
    return std::abs(n.dot(c.axis)) <= kAcross && n.dot(seen.outwards) <= 0;
  }

  /// @param by_share  what was seen seldom counts for more: it lies deep in the bore, and tells the axis
  bool fit(Cylinder& c, const Stretch& stretch, float tolerance, bool by_share) const {
    CylinderFit fit(c);
    for_stretch(c, stretch, c.radius + tolerance, [&](std::uint32_t i, const OnCylinder& seen) {
      if (!is_wall(i, c, seen, tolerance)) return;
      const float off = (seen.distance - c.radius) / tolerance;
      const float near = 1 - off * off;
      const float share = by_share ? surface_.share(i) : 1;
      fit.add(seen, near * near * share * share);
    });
    return fit.improve(c) && c.radius > 0.25F * surface_.epsilon();
  }

  /// @param way  1 or -1: a mouth's face looks this way along the axis; 0: none is looked for
  Section section(const Cylinder& c, const Stretch& stretch, float tolerance, float way) const {
    Section s;
    const Frame frame(c.axis);
    for_stretch(c, stretch, kRound * c.radius, [&](std::uint32_t i, const OnCylinder& seen) {
      const std::uint32_t direction = 1U << octant(seen.outwards.dot(frame.t), seen.outwards.dot(frame.s));
      if (is_wall(i, c, seen, tolerance)) {
        s.wall |= direction;
        ++s.on;
        return;
      }
      if (!surface_.is_surface(i)) return;
      const Vec3f n = surface_.normal(i);
      if (seen.distance < kWithin * c.radius) {
        ++s.within;
      } else if (seen.distance > c.radius && !surface_.hardly_seen(i) && n.dot(c.axis) * way > kAcross) {
        s.mouth |= direction;
      } else if (n.dot(seen.outwards) < -kFacing) {
        ++s.beside;
      }
    });
    return s;
  }

  /// One of the two ways along a bore.
  struct Way {
    float sign;
    float step;
    float reached = 0;
    float walled = 0;  ///< the last place with wall all round
    bool open = true;
  };

  std::optional<Bore> follow(Cylinder c) const {
    const float first_radius = c.radius;
    const auto fit_all = [&](const Stretch& stretch) {
      return fit(c, stretch, tolerance_, true) && fit(c, stretch, tolerance_, true) &&
             c.radius < kMostChange * first_radius && first_radius < kMostChange * c.radius;
    };
    if (tolerance_ > kMostTolerance * c.radius) return std::nullopt;
    std::array<Way, 2> ways{{{-1, kStep * c.radius}, {1, kStep * c.radius}}};
    std::uint32_t on = 0;
    std::uint32_t beside = 0;
    while (ways[0].open || ways[1].open) {
      for (Way& way : ways) {
        if (!way.open) continue;
        const float next = way.reached + way.sign * way.step;
        const Section s = section(c, {std::min(way.reached, next), std::max(way.reached, next)}, tolerance_, way.sign);
        if (s.within >= kBottom || std::popcount(s.mouth) >= kMouth) {
          way.step *= 0.5F;
          way.open = way.step >= kLeastStep * c.radius;
          continue;
        }
        way.reached = next;
        on += s.on;
        beside += s.beside;
        if (std::popcount(s.wall) >= kWall) way.walled = next;
        const Stretch stretch{ways[0].reached, ways[1].reached};
        if (s.on > 0 && !fit_all(stretch)) return std::nullopt;
        if (stretch.length() > kLongest * c.radius) ways[0].open = ways[1].open = false;
      }
    }
    const Stretch walled{ways[0].walled, ways[1].walled};
    const float margin = kMargin * c.radius;
    for (int k = 0; k < 3; ++k) {
      if (!fit(c, {walled.from + margin, walled.to - margin}, tolerance_, false)) return std::nullopt;
    }
    if (on < kSurer * beside || !(unseen(c, walled) > kUnseen * surface_.epsilon())) return std::nullopt;
    return Bore{c, walled};
  }

  /// How much of a stretch has hardly any wall.
  float unseen(const Cylinder& c, const Stretch& walled) const {
    const float step = kStep * c.radius;
    float length = 0;
    for (float t = walled.from; t + step <= walled.to; t += step) {
      if (std::popcount(section(c, {t, t + step}, tolerance_, 0).wall) < kBare) length += step;
    }
    return length;
  }

  BoreSurface& surface_;
  float tolerance_;  ///< of a point's distance from the wall
};

}  // namespace

Expected<std::span<BoreEnd>> continue_round_bores(BoreSurface& surface, std::span<BoreEnd> ends,
                                                  const StageProgress& progress) {
  RoundBores bores(surface);
  const auto all = static_cast<double>(ends.size());
  std::size_t next = 0;
  while (next < ends.size()) {
    if (!progress.advance(1 - static_cast<double>(ends.size() - next) / all)) {
      return fail(ErrorCode::kCancelled, "cancelled while the walls of round bores were continued");
    }
    BoreEnd& end = ends[next];
    const auto before = ends.first(next++);
    const bool tried_near = std::any_of(before.begin(), before.end(), [&](const BoreEnd& o) {
      const Vec3f d = surface.position(o.point) - surface.position(end.point);
      return o.tried && d.dot(d) < kApart * kApart * o.width * o.width;
    });
    if (tried_near) continue;
    const auto bore = bores.from(end);
    end.tried = !bore;
    if (!bore) continue;
    bores.settle(*bore);
    const auto on_it = [&](const BoreEnd& o) { return bores.contains(*bore, surface.position(o.point)); };
    const auto done = ends.first(next);
    next -= static_cast<std::size_t>(std::count_if(done.begin(), done.end(), on_it));
    ends = ends.first(static_cast<std::size_t>(std::remove_if(ends.begin(), ends.end(), on_it) - ends.begin()));
  }
  return ends;
}

}  // namespace plumbline
