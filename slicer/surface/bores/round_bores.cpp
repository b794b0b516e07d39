#include "slicer/surface/bores/round_bores.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>

#include "slicer/core/numbers/degrees.hpp"
#include "slicer/core/numbers/vec.hpp"
#include "slicer/surface/bores/cylinder.hpp"

namespace plumbline {
namespace {

// Distance from the cylinder within which a point is on its wall: the larger of these two.
constexpr float kToleranceEpsilons = 0.1F;
constexpr float kToleranceNoise = 2.5F;  ///< standard deviations of the noise
constexpr float kMaxTolerance = 0.4F;    ///< radii; with more, any points make a cylinder
// The first fit, within the width of the bore. Its tolerances, in widths, narrow down from the error of the first
// guess.
constexpr std::array<float, 7> kCoarseTolerances = {0.25F, 0.25F, 0.18F, 0.18F, 0.12F, 0.12F, 0.12F};
constexpr float kMaxRadius = 1;  ///< widths; a round bore has 0.5, where the width was measured across a diameter
constexpr float kMinRadius = 0.3F;
// Following the bore, in radii.
constexpr float kMaxChange = 2;  ///< ratio of the radius to the first; more is another cylinder
constexpr float kStep = 0.5F;
constexpr float kMinStep = 0.125F;  ///< a step that met something is halved down to this
constexpr float kMaxLength = 16;
// Limits that classify a point around the cylinder, by its distance from the axis, in radii, and by its normal.
constexpr float kSurveyRadius = 1.5F;  ///< farther points don't count
constexpr float kInsideRadius = 0.6F;  ///< nearer points are inside the bore
constexpr float kBoreRadius = 1.3F;    ///< nearer points belong to the bore
constexpr float kFaceCosine = 0.7F;    ///< least inner product of a face's normal with the axis: 45 degrees
// Limits that decide whether a step has left the bore, and whether the cylinder is a bore.
constexpr std::uint32_t kBottomPoints = 4;  ///< points inside a step that make a bottom
constexpr int kFaced = 4;                   ///< of eight directions with a face around: the bore's mouth
constexpr int kWalled = 7;                  ///< of eight directions with wall: walls all around
constexpr int kBare = 5;                    ///< with fewer, a step counts as unseen
constexpr std::uint32_t kMinRatio = 3;      ///< points of its own wall for each point of another
constexpr float kRetryDistance = 0.3F;      ///< widths; no new attempt starts closer to one that failed
// Two first fits from one end that are the same cylinder, which is followed once.
constexpr float kSameAxis = 0.995F;  ///< least inner product of their axes: 6 degrees
constexpr float kSamePlace = 0.1F;   ///< largest distance of their axes, and difference of their radii, in radii

/// Unit vector at an angle from frame.t towards frame.s.
Vec3f direction(const Frame& frame, double degrees) {
  const SineCosine turned = sine_cosine(degrees);
  return frame.at(static_cast<float>(turned.cosine), static_cast<float>(turned.sine));
}

/// What lies around a stretch of a cylinder.
struct Survey {
  std::uint32_t wall = 0;    ///< bit for each of eight directions that has wall
  std::uint32_t mouth = 0;   ///< bit for each direction that has a face around the mouth
  std::uint32_t on = 0;      ///< points of its wall
  std::uint32_t beside = 0;  ///< points of other walls that face its axis
  std::uint32_t inside = 0;  ///< points inside the bore
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

bool are_same(const Cylinder& a, const Cylinder& b) {
  const Vec3f apart = a.middle - b.middle;
  const Vec3f across = apart - b.axis * apart.dot(b.axis);
  const float limit = kSamePlace * b.radius;
  return std::abs(a.axis.dot(b.axis)) > kSameAxis && across.dot(across) < limit * limit &&
         std::abs(a.radius - b.radius) < limit;
}

class RoundBores {
 public:
  explicit RoundBores(BoreSurface& surface)
      : surface_(surface),
        tolerance_(std::max(kToleranceEpsilons * surface.epsilon(), kToleranceNoise * surface.noise())) {}

  std::optional<Bore> find_from(const BoreEnd& end) const {
    const Vec3f n = surface_.normal(end.point);
    const float width = end.width;
    const Frame frame(n);
    std::array<Cylinder, kDirections> first;
    for (std::size_t k = 0; k < kDirections; ++k) {
      const Vec3f axis = direction(frame, 180.0 * static_cast<double>(k) / kDirections);
      first[k] = {surface_.position(end.point) + n * (0.5F * width), axis, 0.5F * width};
    }
    std::array<bool, kDirections> fits = {};
#pragma omp parallel for schedule(dynamic, 1)
    for (std::size_t k = 0; k < kDirections; ++k) fits[k] = fit_first(first[k], width);
    std::size_t count = 0;
    for (std::size_t k = 0; k < kDirections; ++k) {
      const auto is_known = [&](const Cylinder& c) { return are_same(first[k], c); };
      if (fits[k] && std::none_of(first.begin(), first.begin() + count, is_known)) first[count++] = first[k];
    }
    std::array<std::optional<Bore>, kDirections> bores;
#pragma omp parallel for schedule(dynamic, 1)
    for (std::size_t k = 0; k < count; ++k) bores[k] = follow(first[k]);
    const auto found = std::find_if(bores.begin(), bores.end(), [](const auto& bore) { return bore.has_value(); });
    return found != bores.end() ? *found : std::nullopt;
  }

  bool contains(const Bore& bore, const Vec3f& x) const {
    const Cylinder& c = bore.cylinder;
    const OnCylinder at = cylinder_coordinates(c, x);
    return at.distance < kBoreRadius * c.radius && at.along > bore.walled.from - c.radius &&
           at.along < bore.walled.to + c.radius;
  }

  void extend(const Bore& bore) {
    const Cylinder& c = bore.cylinder;
    for_stretch(c, bore.walled, kBoreRadius * c.radius, [&](std::uint32_t i, const OnCylinder& at) {
      // Outside the wall is the inside of the object, or the other side of a thin wall.
      const bool other_side = at.distance > c.radius && surface_.normal(i).dot(at.outwards) > 0;
      if (is_wall(i, c, at, tolerance_)) {
        surface_.set_normal(i, -at.outwards);
      } else if (surface_.is_sparse(i) && !other_side) {
        surface_.mark_noise(i);
      }
    });
    const float spacing = BoreSurface::kSpacing * surface_.epsilon();
    const Frame frame(c.axis);
    const auto rings = static_cast<int>(bore.walled.length() / spacing) + 1;
    const auto places = static_cast<int>(2 * std::numbers::pi_v<float> * c.radius / spacing) + 1;  // of a ring
    for (int k = 0; k <= rings; ++k) {
      const float share = static_cast<float>(k) / static_cast<float>(rings);
      const Vec3f middle = c.on_axis(bore.walled.from + bore.walled.length() * share);
      for (int place = 0; place < places && !surface_.full(); ++place) {
        const Vec3f outwards = direction(frame, 360.0 * place / places);
        const Vec3f x = middle + outwards * c.radius;
        if (!surface_.has_wall(x, -outwards)) surface_.add(x, -outwards);
      }
    }
  }

 private:
  static constexpr std::size_t kDirections = 12;  ///< of the first axes, across the normal of an end

  /// The first fit, within the width of a bore.
  /// @returns whether there is a cylinder with wall all around
  bool fit_first(Cylinder& c, float width) const {
    if (std::popcount(survey(c, {-0.5F * width, 0.5F * width}, 0.25F * width, 0).wall) < kWalled) return false;
    return std::all_of(kCoarseTolerances.begin(), kCoarseTolerances.end(), [&](float tolerance) {
      return fit(c, {-width, width}, std::max(tolerance * width, tolerance_)) && c.radius < kMaxRadius * width &&
             c.radius > kMinRadius * width;
    });
  }

  /// Calls visit(i, coordinates) for the points of the scan along a stretch, up to a distance from the axis.
  template <class Visit>
  void for_stretch(const Cylinder& c, const Stretch& stretch, float max_distance, Visit visit) const {
    Box3f box;
    box.extend(c.on_axis(stretch.from));
    box.extend(c.on_axis(stretch.to));
    const Vec3f margin = Vec3f::Constant(max_distance);
    const float clearly_off2 = 1.01F * max_distance * max_distance;
    surface_.visit_box(box.low - margin, box.high + margin, [&](std::uint32_t i) {
      // Without a root: most points of the box are off the stretch.
      const Vec3f d = surface_.position(i) - c.middle;
      const float along = d.dot(c.axis);
      if (along < stretch.from || along >= stretch.to || d.dot(d) - along * along > clearly_off2) return;
      const OnCylinder at = cylinder_coordinates(c, surface_.position(i));
      if (at.distance <= max_distance) visit(i, at);
    });
  }

  /// Whether a point is on the cylinder's wall: within the tolerance, and not clearly on a face or on the outside of a
  /// thin wall.
  bool is_wall(std::uint32_t i, const Cylinder& c, const OnCylinder& at, float tolerance) const {
    if (std::abs(at.distance - c.radius) >= tolerance) return false;
    if (surface_.is_sparse(i)) return true;
    const Vec3f n = surface_.normal(i);
    return std::abs(n.dot(c.axis)) <= kFaceCosine && n.dot(at.outwards) <= 0;
  }

  /// Gives sparse points more weight: they lie deep in the bore and determine its axis.
  bool fit(Cylinder& c, const Stretch& stretch, float tolerance) const {
    CylinderFit fit(c);
    for_stretch(c, stretch, c.radius + tolerance, [&](std::uint32_t i, const OnCylinder& at) {
      if (!is_wall(i, c, at, tolerance)) return;
      const float off = (at.distance - c.radius) / tolerance;
      const float near = 1 - off * off;
      const float share = surface_.share_radius(i);
      fit.add(at, near * near * share * share);
    });
    return fit.improve(c) && c.radius > 0.25F * surface_.epsilon();
  }

  /// @param way  1 or -1: direction along the axis that a face around the mouth looks; 0 finds no faces
  Survey survey(const Cylinder& c, const Stretch& stretch, float tolerance, float way) const {
    Survey s;
    const Frame frame(c.axis);
    for_stretch(c, stretch, kSurveyRadius * c.radius, [&](std::uint32_t i, const OnCylinder& at) {
      const std::uint32_t direction = 1U << octant(at.outwards.dot(frame.t), at.outwards.dot(frame.s));
      if (is_wall(i, c, at, tolerance)) {
        s.wall |= direction;
        ++s.on;
        return;
      }
      if (!surface_.is_surface(i)) return;
      const Vec3f n = surface_.normal(i);
      if (at.distance < kInsideRadius * c.radius) {
        ++s.inside;
      } else if (at.distance > c.radius && !surface_.is_sparse(i) && n.dot(c.axis) * way > kFaceCosine) {
        s.mouth |= direction;
      } else if (n.dot(at.outwards) < -kWallCosine) {
        ++s.beside;
      }
    });
    return s;
  }

  /// One of the two directions along a bore.
  struct Way {
    float sign;
    float step;
    float reached = 0;
    float walled = 0;  ///< last position with wall all around
    bool open = true;
  };

  std::optional<Bore> follow(Cylinder c) const {
    const float first_radius = c.radius;
    const auto fit_all = [&](const Stretch& stretch) {
      return fit(c, stretch, tolerance_) && fit(c, stretch, tolerance_) && c.radius < kMaxChange * first_radius &&
             first_radius < kMaxChange * c.radius;
    };
    if (tolerance_ > kMaxTolerance * c.radius) return std::nullopt;
    std::array<Way, 2> ways{{{-1, kStep * c.radius}, {1, kStep * c.radius}}};
    std::uint32_t on = 0;
    std::uint32_t beside = 0;
    while (ways[0].open || ways[1].open) {
      for (Way& way : ways) {
        if (!way.open) continue;
        const float next = way.reached + way.sign * way.step;
        const Survey s = survey(c, {std::min(way.reached, next), std::max(way.reached, next)}, tolerance_, way.sign);
        if (s.inside >= kBottomPoints || std::popcount(s.mouth) >= kFaced) {
          way.step *= 0.5F;
          way.open = way.step >= kMinStep * c.radius;
          continue;
        }
        way.reached = next;
        on += s.on;
        beside += s.beside;
        if (std::popcount(s.wall) >= kWalled) way.walled = next;
        const Stretch stretch{ways[0].reached, ways[1].reached};
        if (s.on > 0 && !fit_all(stretch)) return std::nullopt;
        if (stretch.length() > kMaxLength * c.radius) ways[0].open = ways[1].open = false;
      }
    }
    const Stretch walled{ways[0].walled, ways[1].walled};
    if (on < kMinRatio * beside || !(unseen_length(c, walled) > kLeastUnseen * surface_.epsilon())) return std::nullopt;
    return Bore{c, walled};
  }

  /// Length of a stretch that has little wall.
  float unseen_length(const Cylinder& c, const Stretch& walled) const {
    const float step = kStep * c.radius;
    float length = 0;
    for (float t = walled.from; t + step <= walled.to; t += step) {
      if (std::popcount(survey(c, {t, t + step}, tolerance_, 0).wall) < kBare) length += step;
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
      return fail(ErrorCode::kCancelled, "cancelled while the walls of round bores were extended");
    }
    BoreEnd& end = ends[next];
    const auto before = ends.first(next++);
    const bool tried_near = std::any_of(before.begin(), before.end(), [&](const BoreEnd& o) {
      const Vec3f d = surface.position(o.point) - surface.position(end.point);
      return o.not_round && d.dot(d) < kRetryDistance * kRetryDistance * o.width * o.width;
    });
    if (tried_near) continue;
    const auto bore = bores.find_from(end);
    end.not_round = !bore;
    if (!bore) continue;
    bores.extend(*bore);
    const auto on_it = [&](const BoreEnd& o) { return bores.contains(*bore, surface.position(o.point)); };
    const auto done = ends.first(next);
    next -= static_cast<std::size_t>(std::count_if(done.begin(), done.end(), on_it));
    ends = ends.first(static_cast<std::size_t>(std::remove_if(ends.begin(), ends.end(), on_it) - ends.begin()));
  }
  return ends;
}

}  // namespace plumbline
