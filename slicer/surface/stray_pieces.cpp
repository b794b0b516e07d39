#include "slicer/surface/stray_pieces.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <span>

#include "slicer/core/cell_pieces.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr std::uint32_t kMinSlots = 1U << 10;
/// Of the cell table; the surface of a million points fills half of them.
constexpr std::uint32_t kMaxSlots = 1U << 17;

constexpr double kMaxShare = 0.02;     ///< area of a stray piece over that of the largest piece: a fiftieth
constexpr double kMaxAllShare = 0.05;  ///< area of all stray pieces over that of what stays: a twentieth
/// Distance of the winding number from 0 or 1 within which it counts as that. A wider range would drop surface in
/// holes, a narrower one would keep strays in front of openings.
constexpr float kSure = 0.1F;

constexpr std::uint32_t kMaxSuspects = 256;  ///< largest number of small pieces that are tested; the others stay
// The winding number is evaluated directly, so its time grows with the product of these two.
constexpr std::uint32_t kPlaces = 4;              ///< of a piece
constexpr std::uint32_t kFieldPoints = 1U << 14;  ///< points that represent the whole cloud

Box3f surface_bounds(const Cloud& cloud) {
  Box3f box;
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    if (cloud.is_surface(i)) box.extend(cloud.position[i]);
  }
  return box;
}

/// A small piece, which may be a stray piece.
struct Suspect {
  std::uint32_t root = 0;
  std::uint32_t points = 0;
  float area = 0;
  std::uint32_t visited = 0;  ///< points visited to choose the places
  std::uint32_t places = 0;   ///< points at which the winding number was evaluated
  float winding = 0;          ///< sum over the places
  bool stray = false;
};

class Search {
 public:
  Search(Cloud& cloud, const CellPieces& cells, float area_factor, std::span<Suspect> suspects)
      : cloud_(cloud), cells_(cells), area_factor_(area_factor), suspects_(suspects) {}

  StrayPieces mark() {
    find_suspects();
    if (suspects_.empty()) return {};
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      if (Suspect* s = suspect(i)) ++s->points;
    }
    decide();
    StrayPieces strays;
    double dropped_area = 0;
    for (const Suspect& s : suspects_) {
      if (!s.stray) continue;
      ++strays.pieces;
      dropped_area += static_cast<double>(s.area);
    }
    if (strays.pieces == 0 || !(dropped_area < kMaxAllShare * (total_area_ - dropped_area))) return {};
    strays.share = static_cast<float>(dropped_area / total_area_);
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      const Suspect* s = suspect(i);
      if (s == nullptr || !s->stray) continue;
      cloud_.normal[i].point_class = PointClass::kNoise;
      ++strays.points;
    }
    return strays;
  }

 private:
  void find_suspects() {
    float largest = 0;
    for (std::uint32_t at = 0; at < cells_.size(); ++at) {
      if (!cells_.is_piece(at)) continue;
      largest = std::max(largest, cells_.amount(at));
      total_area_ += static_cast<double>(cells_.amount(at));
    }
    std::uint32_t count = 0;
    for (std::uint32_t at = 0; at < cells_.size() && count < suspects_.size(); ++at) {
      if (cells_.is_piece(at) && cells_.amount(at) < static_cast<float>(kMaxShare) * largest) {
        Suspect& found = suspects_[count++] = {};
        found.root = at;
        found.area = cells_.amount(at);
      }
    }
    suspects_ = suspects_.first(count);  // sorted by root
  }

  /// The suspect that a point belongs to; nullptr for noise and for points of other pieces.
  Suspect* suspect(std::uint32_t point) const {
    if (!cloud_.is_surface(point)) return nullptr;
    const std::uint32_t root = cells_.piece_of(cloud_.position[point]);
    const auto found = std::lower_bound(suspects_.begin(), suspects_.end(), root,
                                        [](const Suspect& s, std::uint32_t r) { return s.root < r; });
    return found != suspects_.end() && found->root == root ? &*found : nullptr;
  }

  /// Decides by the winding number of all other points at some places of each suspect.
  void decide() {
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      Suspect* s = suspect(i);
      if (s == nullptr || s->points < kFewestOfPiece || s->visited++ % (s->points / kPlaces + 1) != 0) continue;
      s->winding += winding_without(s->root, cloud_.position[i]);
      ++s->places;
    }
    for (Suspect& s : suspects_) {
      if (s.places == 0) continue;
      const float w = s.winding / static_cast<float>(s.places);
      s.stray = w < kSure || w > 1 - kSure;
    }
  }

  /// Winding number at x of all points but those of one piece. Uses every n-th point; they are evenly spread, since
  /// they are in the order of their tree.
  float winding_without(std::uint32_t root, const Vec3f& x) const {
    const std::uint32_t step = cloud_.size / kFieldPoints + 1;
    float w = 0;
    for (std::uint32_t i = step / 2; i < cloud_.size; i += step) {
      if (!cloud_.is_surface(i) || cells_.piece_of(cloud_.position[i]) == root) continue;
      const Vec3f e = cloud_.position[i] - x;
      const float distance2 = e.dot(e);
      const float area = static_cast<float>(step) * area_factor_ * cloud_.radius[i] * cloud_.radius[i];
      if (distance2 > 0) w += area * cloud_.normal[i].unpack().dot(e) / (distance2 * std::sqrt(distance2));
    }
    return w / (4 * std::numbers::pi_v<float>);
  }

  Cloud& cloud_;
  const CellPieces& cells_;
  float area_factor_;
  std::span<Suspect> suspects_;
  double total_area_ = 0;  ///< mm^2
};

std::uint32_t slots_for(std::uint32_t points) { return std::clamp(std::bit_ceil(points / 4), kMinSlots, kMaxSlots); }

}  // namespace

std::size_t stray_pieces_bytes(std::uint32_t points) {
  return Arena::rounded(slots_for(points) * sizeof(CellPieces::Cell)) + Arena::rounded(kMaxSuspects * sizeof(Suspect));
}

Expected<StrayPieces> mark_stray_pieces(Cloud& cloud, const ClusteringResult& clustering, Arena& arena) {
  const ArenaScope scope(arena);
  const auto slots = arena.take_top<CellPieces::Cell>(slots_for(cloud.size), "stray pieces");
  PLUMBLINE_TRY(slots);
  const auto suspects = arena.take_top<Suspect>(kMaxSuspects, "stray pieces");
  PLUMBLINE_TRY(suspects);
  const float area_factor = std::numbers::pi_v<float> / cloud.support_points;
  const Box3f box = surface_bounds(cloud);
  for (float edge = kTogetherEpsilons * clustering.epsilon;; edge *= 2) {
    CellPieces cells(box, edge, *slots);
    bool room = true;
    for (std::uint32_t i = 0; i < cloud.size && room; ++i) {
      if (cloud.is_surface(i)) room = cells.add(cloud.position[i], area_factor * cloud.radius[i] * cloud.radius[i]);
    }
    if (!room) continue;
    cells.join();
    return Search(cloud, cells, area_factor, *suspects).mark();
  }
}

}  // namespace plumbline::inline slicer
