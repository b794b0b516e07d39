#include "slicer/normal_orientation.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "slicer/dipole_field.hpp"
#include "slicer/sided_sets.hpp"

namespace plumbline {
namespace {

constexpr const char* kStage = "normals";

constexpr std::uint32_t kPairs = 10;    ///< nearest points that a point is joined with
constexpr std::uint32_t kBatch = 4096;  ///< points whose neighbours are searched at a time
constexpr std::uint32_t kNobody = 0xFFFFFFFFU;

/// Classes of weights, surest first. What is below the last one joins nothing: a single such pair, at the rim of a hole or
/// where two sheets touch, would turn all of a sheet. That is left to the field.
constexpr std::array<float, 3> kLeastWeight = {0.95F, 0.8F, 0.5F};
constexpr std::uint8_t kNoClass = kLeastWeight.size();

constexpr std::uint32_t kSmallestSheet = 32;  ///< points; smaller ones are turned point by point
constexpr std::uint32_t kSheetSamples = 512;  ///< points of a sheet where the field is asked
constexpr std::uint32_t kSizeClass = 4;  ///< sheets within this ratio of size are turned without regard to each other

constexpr std::uint32_t kAreaSamples = 4096;
constexpr float kMostRadius = 3;         ///< times the median: a share of the surface is not larger
constexpr std::int64_t kUnit = 1 << 20;  ///< of the evidence, which is summed as whole numbers
constexpr float kMostEvidence = 2;       ///< of one sample: a lid that fits its hole has about 1/2
constexpr double kPi = 3.14159265358979323846;

/// A set of points whose sides are known relative to each other.
struct Sheet {
  std::uint32_t root = 0;
  std::uint32_t points = 0;
  std::int32_t votes = 0;     ///< known normals that agree less those that do not
  std::uint32_t samples = 0;  ///< points where the field was asked
  std::int64_t winding = 0;   ///< sum of kUnit W over the samples
  std::int64_t slope = 0;     ///< sum of kUnit -<n, grad W> times the size of the sheet
  double area = 0;            ///< mm^2
  Vec3d centroid = Vec3d::Zero();
  double flux = 0;   ///< sum of a <n, p - c>
  double reach = 0;  ///< sum of a |p - c|: the most that the flux can be
  float side = 0;    ///< 1 or -1 once it is known
};

constexpr std::uint32_t kNoSheet = SidedSets::kIndex;

std::uint32_t sheets_at_most(std::uint32_t points) { return points / kSmallestSheet; }

class Orientation {
 public:
  Orientation(Cloud& cloud, const KdTree3& tree, std::span<const std::uint64_t> estimated, Arena& arena,
              const StageProgress& progress)
      : cloud_(cloud), tree_(tree), estimated_(estimated), arena_(arena), progress_(progress) {}

  Status run() {
    auto entries = arena_.take_top<std::uint32_t>(cloud_.size, kStage);
    if (!entries) return tl::unexpected<Error>(entries.error());
    sets_ = SidedSets(*entries);
    for (std::uint32_t i = 0; i < cloud_.size; ++i) sets_.start(i, !is_estimated(i));
    PLUMBLINE_TRY(limit_areas());
    PLUMBLINE_TRY(join());
    PLUMBLINE_TRY(list_sheets());
    measure_sheets();
    return turn_sheets();
  }

 private:
  bool is_estimated(std::uint32_t i) const { return ((estimated_[i / 64] >> (i % 64)) & 1U) != 0; }

  /// A stray point has as much room round it as a thousand points of the surface and must not speak for as many.
  Status limit_areas() {
    const ArenaScope scope(arena_);
    const std::uint32_t samples = std::min(kAreaSamples, cloud_.size);
    auto block = arena_.take_top<float>(samples, kStage);
    if (!block) return tl::unexpected<Error>(block.error());
    for (std::uint32_t s = 0; s < samples; ++s) {
      (*block)[s] = cloud_.radius[static_cast<std::uint32_t>(std::uint64_t{s} * cloud_.size / samples)];
    }
    const auto middle = block->begin() + samples / 2;
    std::nth_element(block->begin(), middle, block->end());
    if (!(*middle > 0)) return {};
    const float most = kMostRadius * *middle;
    for (float& radius : cloud_.radius.first(cloud_.size)) radius = std::min(radius, most);
    return {};
  }

  /// w(i, j) of the header.
  float weight(std::uint32_t i, std::uint32_t j) const {
    const Vec3f n = cloud_.normal[i].unpack();
    const Vec3f m = cloud_.normal[j].unpack();
    const Vec3f d = cloud_.position[j] - cloud_.position[i];
    const float d2 = d.dot(d);
    if (!(d2 > 0)) return n.dot(m);
    return n.dot(m) - n.dot(d) * m.dot(d) / d2;
  }

  static std::uint8_t class_of(float magnitude) {
    std::uint8_t c = 0;
    while (c < kNoClass && magnitude < kLeastWeight[c]) ++c;
    return c;
  }

  /// Joins neighbours, class by class. A point is looked at again when a pair of it is due that joined nothing before.
  Status join() {
    const ArenaScope scope(arena_);
    const std::uint32_t batch = std::min(kBatch, cloud_.size);
    auto open_block = arena_.take_top<std::uint32_t>(batch, kStage);
    if (!open_block) return tl::unexpected<Error>(open_block.error());
    auto pair_block = arena_.take_top<std::uint32_t>(std::size_t{batch} * kPairs, kStage);
    if (!pair_block) return tl::unexpected<Error>(pair_block.error());
    auto class_block = arena_.take_top<std::uint8_t>(cloud_.size, kStage);
    if (!class_block) return tl::unexpected<Error>(class_block.error());
    open_ = *open_block;
    pairs_ = *pair_block;
    next_class_ = *class_block;
    for (std::uint32_t i = 0; i < cloud_.size; ++i) next_class_[i] = cloud_.normal[i].known() ? 0 : kNoClass;
    for (std::uint8_t c = 0; c < kNoClass; ++c) {
      std::uint32_t next = 0;
      while (next < cloud_.size) {
        std::uint32_t count = 0;
        for (; next < cloud_.size && count < batch; ++next) {
          if (next_class_[next] <= c) open_[count++] = next;
        }
        // The first class looks at every point, the others at what it left.
        const double done = c == 0 ? 0.5 * next / cloud_.size : 0.5 + 0.5 * c / kNoClass;
        if (!progress_.advance(done)) return fail(ErrorCode::kCancelled, "cancelled while normals were turned");
        search(count);
        for (std::uint32_t k = 0; k < count; ++k) join_point(k, c);
      }
    }
    return {};
  }

  void search(std::uint32_t count) {
#pragma omp parallel for schedule(dynamic, 64)
    for (std::uint32_t k = 0; k < count; ++k) {
      const std::uint32_t i = open_[k];
      std::array<Neighbour, kPairs + 1> found;  // NOLINT(cppcoreguidelines-pro-type-member-init)
      const std::uint32_t near = tree_.nearest(cloud_.position[i], found);
      std::uint32_t pairs = 0;
      for (std::uint32_t n = 0; n < near && pairs < kPairs; ++n) {
        if (found[n].index != i && cloud_.normal[found[n].index].known()) pairs_[k * kPairs + pairs++] = found[n].index;
      }
      for (; pairs < kPairs; ++pairs) pairs_[k * kPairs + pairs] = kNobody;
    }
  }

  /// One thread does this, in the order of the points: which join of a class comes first decides the signs.
  void join_point(std::uint32_t k, std::uint8_t current) {
    const std::uint32_t i = open_[k];
    std::uint8_t next = kNoClass;
    for (std::uint32_t p = k * kPairs; p < (k + 1) * kPairs && pairs_[p] != kNobody; ++p) {
      const std::uint32_t j = pairs_[p];
      const SidedSets::Place a = sets_.find(i);
      const SidedSets::Place b = sets_.find(j);
      if (a.root == b.root) continue;
      const float w = weight(i, j);
      const std::uint8_t c = class_of(std::abs(w));
      if (c <= current) {
        sets_.unite(a, b, w < 0);
      } else {
        next = std::min(next, c);
      }
    }
    next_class_[i] = next;
  }

  Status list_sheets() {
    auto block = arena_.take_top<Sheet>(sheets_at_most(cloud_.size), kStage);
    if (!block) return tl::unexpected<Error>(block.error());
    std::uint32_t count = 0;
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      if (!sets_.is_root(i)) continue;
      if (sets_.value(i) >= kSmallestSheet && cloud_.normal[i].known()) {
        Sheet sheet;
        sheet.root = i;
        sheet.points = sets_.value(i);
        (*block)[count++] = sheet;
      }
    }
    sheets_ = block->first(count);
    std::sort(sheets_.begin(), sheets_.end(), [](const Sheet& a, const Sheet& b) {
      return a.points != b.points ? a.points > b.points : a.root < b.root;
    });
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      if (sets_.is_root(i)) sets_.set_value(i, kNoSheet);
    }
    for (std::uint32_t s = 0; s < count; ++s) sets_.set_value(sheets_[s].root, s);
    return {};
  }

  Sheet* sheet_of(std::uint32_t i) const {
    const std::uint32_t s = sets_.value(sets_.look(i).root);
    return s == kNoSheet ? nullptr : &sheets_[s];
  }
  double area(std::uint32_t i) const {
    const auto radius = static_cast<double>(cloud_.radius[i]);
    return kPi * radius * radius;
  }

  /// Turns the estimated normals of every sheet to one side, counts votes, sums area and flux.
  void measure_sheets() {
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      const bool turned = sets_.find(i).turned;
      Sheet* sheet = sheet_of(i);
      if (sheet == nullptr) continue;
      if (sets_.fixed(i)) {
        sheet->votes += turned ? -1 : 1;
      } else if (turned) {
        turn(i);
      }
      sheet->area += area(i);
      sheet->centroid += area(i) * cloud_.position[i].cast<double>();
    }
    for (Sheet& sheet : sheets_) {
      if (sheet.area > 0) sheet.centroid /= sheet.area;
    }
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      Sheet* sheet = sheet_of(i);
      if (sheet == nullptr) continue;
      const Vec3d from_centre = cloud_.position[i].cast<double>() - sheet->centroid;
      sheet->flux += area(i) * cloud_.normal[i].unpack().cast<double>().dot(from_centre);
      sheet->reach += area(i) * std::sqrt(from_centre.dot(from_centre));
    }
  }

  void turn(std::uint32_t i) {
    PackedNormal& n = cloud_.normal[i];
    n.x = static_cast<std::int16_t>(-n.x);
    n.y = static_cast<std::int16_t>(-n.y);
    n.z = static_cast<std::int16_t>(-n.z);
  }

  /// What the normal of point i counts in the field of the sheets whose side is known.
  float side(std::uint32_t i) const {
    if (sets_.fixed(i)) return cloud_.normal[i].known() ? 1.0F : 0.0F;
    const Sheet* sheet = sheet_of(i);
    return sheet == nullptr ? 0.0F : sheet->side;
  }

  Status turn_sheets() {
    auto nodes = arena_.take_top<DipoleField::Node>(DipoleField::nodes_needed(cloud_.size), kStage);
    if (!nodes) return tl::unexpected<Error>(nodes.error());
    DipoleField field(cloud_, *nodes);
    find_sides(field);
    turn_loose_points(field);
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      const Sheet* sheet = sheet_of(i);
      if (sheet != nullptr && sheet->side < 0 && !sets_.fixed(i)) turn(i);
    }
    return {};
  }

  /// Of every sheet, the largest first.
  void find_sides(DipoleField& field) {
    const auto side_of = [this](std::uint32_t i) { return side(i); };
    bool any_known = false;
    for (std::uint32_t i = 0; i < cloud_.size && !any_known; ++i) {
      any_known = sets_.fixed(i) && cloud_.normal[i].known();
    }
    for (Sheet& sheet : sheets_) {
      if (sheet.votes != 0) sheet.side = sheet.votes > 0 ? 1 : -1;
    }
    if (!any_known && !sheets_.empty()) sheets_[0].side = sheets_[0].flux < 0 ? -1 : 1;
    for (std::uint32_t first = 0; first < sheets_.size();) {
      if (sheets_[first].side != 0) {
        ++first;
        continue;
      }
      std::uint32_t last = first;
      while (last < sheets_.size() && sheets_[last].points * kSizeClass >= sheets_[first].points) ++last;
      field.build(side_of);
      ask_field(field, first, last);
      first = last;
    }
    // The largest may be a flat one that does not know its side; all together know it.
    if (!any_known && total_flux() < 0) {
      for (Sheet& sheet : sheets_) sheet.side = -sheet.side;
    }
  }

  /// Points in no sheet: strays, and crumbs at edges. They are no part of the field.
  void turn_loose_points(DipoleField& field) {
    const auto side_of = [this](std::uint32_t i) { return side(i); };
    field.build(side_of);
#pragma omp parallel for schedule(dynamic, 256)
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      if (sets_.fixed(i) || !cloud_.normal[i].known() || sheet_of(i) != nullptr) continue;
      if (field(cloud_.position[i], side_of).gradient.dot(cloud_.normal[i].unpack()) > 0) turn(i);
    }
  }

  /// Sides of sheets [first, last) by the field of those whose side is known. Sums are of whole numbers, so that they do not
  /// depend on the order in which threads add.
  void ask_field(const DipoleField& field, std::uint32_t first, std::uint32_t last) {
    const auto side_of = [this](std::uint32_t i) { return side(i); };
#pragma omp parallel for schedule(dynamic, 1024)
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      if (sets_.fixed(i)) continue;
      Sheet* sheet = sheet_of(i);
      if (sheet == nullptr || sheet->side != 0 || sheet < &sheets_[first] || sheet >= sheets_.data() + last) continue;
      if (scattered(i) % (sheet->points / kSheetSamples + 1) != 0) continue;
      const DipoleField::Value value = field(cloud_.position[i], side_of);
      const auto size = static_cast<float>(std::sqrt(sheet->area / kPi));
      const float slope = -size * value.gradient.dot(cloud_.normal[i].unpack());
      std::atomic_ref(sheet->winding).fetch_add(whole(value.winding), std::memory_order_relaxed);
      std::atomic_ref(sheet->slope).fetch_add(whole(slope), std::memory_order_relaxed);
      std::atomic_ref(sheet->samples).fetch_add(1, std::memory_order_relaxed);
    }
    for (Sheet& sheet : sheets_.subspan(first, last - first)) {
      if (sheet.side != 0) continue;
      const double samples = std::max(1.0, static_cast<double>(sheet.samples)) * kUnit;
      const double winding = static_cast<double>(sheet.winding) / samples;
      const double bulge = sheet.reach > 0 ? sheet.flux / sheet.reach : 0;
      const double evidence = bulge * (1 - 2 * winding) + static_cast<double>(sheet.slope) / samples;
      sheet.side = evidence < 0 ? -1 : 1;
    }
  }
  static std::int64_t whole(float value) {
    if (!std::isfinite(value)) return 0;
    return static_cast<std::int64_t>(std::clamp(value, -kMostEvidence, kMostEvidence) * static_cast<float>(kUnit));
  }
  /// Indices without the order of the tree in them.
  static std::uint32_t scattered(std::uint32_t i) { return (i * 2654435761U) >> 8U; }

  /// Of everything oriented about one place: positive if it is not inside out as a whole.
  double total_flux() const {
    Vec3d centroid = Vec3d::Zero();
    double total = 0;
    for (const Sheet& sheet : sheets_) {
      centroid += sheet.area * sheet.centroid;
      total += sheet.area;
    }
    if (!(total > 0)) return 0;
    centroid /= total;
    double flux = 0;
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      const float s = side(i);
      if (s == 0) continue;
      const Vec3d d = cloud_.position[i].cast<double>() - centroid;
      flux += static_cast<double>(s) * area(i) * cloud_.normal[i].unpack().cast<double>().dot(d);
    }
    return flux;
  }

  Cloud& cloud_;
  const KdTree3& tree_;
  std::span<const std::uint64_t> estimated_;
  Arena& arena_;
  StageProgress progress_;
  SidedSets sets_;
  std::span<Sheet> sheets_;
  std::span<std::uint32_t> open_;       ///< the points of a batch
  std::span<std::uint32_t> pairs_;      ///< kPairs neighbours of each
  std::span<std::uint8_t> next_class_;  ///< of each point: the surest class that may still join it to another set
};

}  // namespace

std::size_t orientation_bytes(std::uint32_t points) {
  const std::size_t sides = sizeof(std::uint32_t) * std::size_t{points};
  const std::size_t batch = sizeof(std::uint32_t) * (kPairs + 1) * std::min(kBatch, points) + points;
  const std::size_t field = sizeof(DipoleField::Node) * DipoleField::nodes_needed(points);
  return sides + std::max(batch, field + sizeof(Sheet) * sheets_at_most(points));
}

Status orient_normals(Cloud& cloud, const KdTree3& tree, std::span<const std::uint64_t> estimated, Arena& arena,
                      const StageProgress& progress) {
  const ArenaScope scope(arena);
  return Orientation(cloud, tree, estimated, arena, progress).run();
}

}  // namespace plumbline
