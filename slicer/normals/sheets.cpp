#include "slicer/normals/sheets.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>

#include "slicer/core/numbers/median.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "normals";

constexpr std::uint32_t kSmallestSheet = 32;  ///< points; limits the sheets' memory. Points of smaller ones turn singly
constexpr std::uint32_t kSheetSamples = 512;  ///< most points of a sheet that evaluate the field: time against noise
constexpr std::uint32_t kFirstSamples = 64;   ///< the same, to tell an inside-out largest sheet: -1/2 from 1/2
/// Sheets whose sizes differ by less than this factor are turned without regard to each other. Each class of sizes costs a
/// rebuild of the field.
constexpr std::uint32_t kSizeClass = 4;

constexpr std::uint32_t kAreaSamples =
    4096;                         ///< points for the median radius: standard error 2 % of the radii's spread
constexpr float kMostRadius = 3;  ///< times the median: no point of a surface has a larger share of it
/// Units of evidence, which is summed as integers so that the order of the threads does not matter.
constexpr std::int64_t kUnit = 1 << 20;
constexpr float kMostEvidence = 2;  ///< limit for one sample; a lid that fits its hole has about 1/2

/// A sheet with less evidence waits until the sides of others are known. The wall beside a known face of a box has 0.14 to 0.18; a lid
/// has 1 once the walls are known, but up to -0.05 if only a plate far below is, whose field it seems to contradict.
constexpr double kClearEvidence = 0.1;

/// A sheet that agrees with its neighbours, or has hardly any, is turned only if the evidence exceeds this: it may be the floor
/// inside a vase whose underside nobody saw. A lid on a tube that was seen all around has 1, one that fits its hole 1/2.
constexpr double kAloneEvidence = 0.5;
constexpr std::uint32_t kFollowers = 3;  ///< following points in the order of the tree that may lie in another sheet
constexpr float kBeside = 4;             ///< radii of a point's share within which another is its neighbour
/// Two neighbours agree if their join_weight() is above this, and contradict each other if it is below its opposite.
constexpr float kContradicts = 0.25F;

/// A single point is turned over by the sign of the field alone if it changes by this within the radius of the point's share. At a turned
/// point of a dense surface it changes by some .5, behind a wall that more views saw by hardly anything.
constexpr float kLooseEvidence = 0.05F;

/// A scan is inside out if the winding number on its largest sheet is below this. It is 1/2 on a closed surface, -1/2 on the
/// same inside out, and 0.3 and -0.3 on half a sphere. What encloses less could as well be the inside of a bowl, and stays
/// as the scan says.
constexpr double kInsideOut = -0.25;
/// A scan of which at most this share faces down is a height field, such as a valley, and can't be inside out.
constexpr double kFacesDown = 0.01;

constexpr std::uint32_t kNoSheet = SidedSets::kIndex;

std::uint32_t sheets_at_most(std::uint32_t points) { return points / kSmallestSheet; }

/// Evidence in units, limited.
std::int64_t to_units(float value) {
  if (!std::isfinite(value)) return 0;
  return static_cast<std::int64_t>(std::clamp(value, -kMostEvidence, kMostEvidence) * static_cast<float>(kUnit));
}
/// Mean of a sum of evidence over a sheet's samples.
double mean(const NormalSheet& sheet, std::int64_t units) {
  return static_cast<double>(units) / (std::max(1.0, static_cast<double>(sheet.samples)) * kUnit);
}
/// Whether neighbours in other sheets face the other side along a part of its rim. A patch that was turned over in the middle of a
/// surface has several such pairs for each point of its rim; points on the other face of a thin wall are a few by chance.
bool contradicts_neighbours(const NormalSheet& sheet) {
  return static_cast<float>(2 * sheet.contradictions) > std::sqrt(static_cast<float>(sheet.points));
}
/// Hashes an index, so that samples don't follow the order of the tree (Knuth's multiplicative hash, 2^32 / golden ratio).
std::uint32_t scattered(std::uint32_t i) { return (i * 2654435761U) >> 8U; }

}  // namespace

float join_weight(const Cloud& cloud, std::uint32_t i, std::uint32_t j) {
  const Vec3f n = cloud.normal[i].unpack();
  const Vec3f m = cloud.normal[j].unpack();
  const Vec3f d = cloud.position[j] - cloud.position[i];
  const float d2 = d.dot(d);
  if (!(d2 > 0)) return n.dot(m);
  return n.dot(m) - n.dot(d) * m.dot(d) / d2;
}

std::size_t Sheets::bytes_needed(std::uint32_t points) {
  return sizeof(DipoleField::Node) * DipoleField::nodes_needed(points) + sizeof(NormalSheet) * sheets_at_most(points);
}

Expected<float> Sheets::limit_areas(Cloud& cloud, Arena& arena) {
  const ArenaScope scope(arena);
  const std::uint32_t samples = std::min(kAreaSamples, cloud.size);
  const auto block = arena.take_top<float>(samples, kStage);
  PLUMBLINE_TRY(block);
  for (std::uint32_t s = 0; s < samples; ++s) (*block)[s] = cloud.radius[cloud.sampled(s, samples)];
  const float middle = median(*block);
  if (!(middle > 0)) return 0.0F;
  const float most = kMostRadius * middle;
  for (float& radius : cloud.radius.first(cloud.size)) radius = std::min(radius, most);
  return middle;
}

Expected<NormalCounts> Sheets::turn(FirstSide first, Stays stays) {
  const ArenaScope scope(arena_);
  rule_ = first;
  PLUMBLINE_TRY(list());
  measure();
  auto nodes = arena_.take_top<DipoleField::Node>(DipoleField::nodes_needed(cloud_.size), kStage);
  PLUMBLINE_TRY(nodes);
  DipoleField field(cloud_, *nodes);
  find_sides(field, first);
  field.build(sides());
  if (first == FirstSide::kLargest && !any_known_ && first_is_inside_out(field)) {
    counts_.inside_out = true;
    for (NormalSheet& sheet : sheets_) sheet.side = 0;
    sheets_[0].side = -1;
    find_other_sides(field);
    field.build(sides());
  }
  turn_loose_points(field, stays);
  for (std::uint32_t i = 0; i < cloud_.size; ++i) {
    const NormalSheet* sheet = sheet_of(i);
    if (sheet == nullptr || sets_.fixed(i)) continue;
    const bool inward = sheet->side < 0;
    if (inward) cloud_.normal[i].turn_over();
    counts_.turned += inward != sets_.look(i).turned ? 1 : 0;  // measure() may have turned it already
  }
  return counts_;
}

Status Sheets::list() {
  PLUMBLINE_TRY(arena_.take_top(sheets_, sheets_at_most(cloud_.size), kStage));
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < cloud_.size; ++i) {
    if (!sets_.is_root(i)) continue;
    const std::uint32_t points = sets_.value(i);
    if (points >= kSmallestSheet && cloud_.normal[i].known()) sheets_[count++] = {.root = i, .points = points};
    sets_.set_value(i, kNoSheet);
  }
  sheets_ = sheets_.first(count);
  std::sort(sheets_.begin(), sheets_.end(), [](const NormalSheet& a, const NormalSheet& b) {
    return a.points != b.points ? a.points > b.points : a.root < b.root;
  });
  for (std::uint32_t s = 0; s < count; ++s) sets_.set_value(sheets_[s].root, s);
  return {};
}

NormalSheet* Sheets::sheet_of(std::uint32_t i) const {
  const std::uint32_t s = sets_.value(sets_.look(i).root);
  return s == kNoSheet ? nullptr : &sheets_[s];
}

double Sheets::area(std::uint32_t i) const {
  const auto radius = static_cast<double>(cloud_.radius[i]);
  return std::numbers::pi * radius * radius;
}

/// Turns the normals of each sheet to one side, counts votes, and sums area and flux.
void Sheets::measure() {
  for (std::uint32_t i = 0; i < cloud_.size; ++i) {
    const bool turned = sets_.find(i).turned;
    NormalSheet* sheet = sheet_of(i);
    if (sheet == nullptr) continue;
    if (sets_.fixed(i)) {
      sheet->votes += turned ? -1 : 1;
    } else if (turned) {
      cloud_.normal[i].turn_over();
    }
    sheet->area += area(i);
    sheet->centroid += area(i) * cloud_.position[i].cast<double>();
  }
  if (rule_ == FirstSide::kLargest) count_contradictions();
  for (NormalSheet& sheet : sheets_) {
    if (sheet.area > 0) sheet.centroid /= sheet.area;
  }
  for (std::uint32_t i = 0; i < cloud_.size; ++i) {
    NormalSheet* sheet = sheet_of(i);
    if (sheet == nullptr) continue;
    const Vec3d from_centre = cloud_.position[i].cast<double>() - sheet->centroid;
    sheet->flux += area(i) * cloud_.normal[i].unpack().cast<double>().dot(from_centre);
    sheet->reach += area(i) * std::sqrt(from_centre.dot(from_centre));
  }
}

/// Counts how many neighbours in other sheets contradict each sheet.
void Sheets::count_contradictions() {
  for (std::uint32_t i = 0; i < cloud_.size; ++i) {
    NormalSheet* sheet = sheet_of(i);
    if (sheet == nullptr) continue;
    const float reach = kBeside * cloud_.radius[i];
    for (std::uint32_t j = i + 1; j <= i + kFollowers && j < cloud_.size; ++j) {
      NormalSheet* other = sheet_of(j);
      if (other == nullptr || other == sheet) continue;
      const Vec3f d = cloud_.position[j] - cloud_.position[i];
      if (d.dot(d) > reach * reach) continue;
      const float weight = join_weight(cloud_, i, j);
      const int vote = weight < -kContradicts ? 1 : weight > kContradicts ? -1 : 0;
      sheet->contradictions += vote;
      other->contradictions += vote;
    }
  }
}

/// Weight of point i in the field of the oriented sheets: 1, -1, or 0 while its side is unknown.
float Sheets::side(std::uint32_t i) const {
  if (sets_.fixed(i)) return cloud_.normal[i].known() ? 1.0F : 0.0F;
  const NormalSheet* sheet = sheet_of(i);
  return sheet == nullptr ? 0.0F : sheet->side;
}

/// Finds the side of every sheet, the largest first.
void Sheets::find_sides(DipoleField& field, FirstSide rule) {
  for (std::uint32_t i = 0; i < cloud_.size && !any_known_; ++i) {
    any_known_ = sets_.fixed(i) && cloud_.normal[i].known();
  }
  for (NormalSheet& sheet : sheets_) {
    if (sheet.votes != 0) sheet.side = sheet.votes > 0 ? 1 : -1;
  }
  const bool convex = rule == FirstSide::kKnownOrConvex && !any_known_;
  if (!sheets_.empty()) {
    if (rule == FirstSide::kLargest && !any_known_) sheets_[0].side = 1;
    if (convex) sheets_[0].side = sheets_[0].flux < 0 ? -1 : 1;
  }
  find_other_sides(field);
  // The largest sheet may be flat, and its side a guess. The flux of all sheets corrects it.
  if (convex && total_flux() < 0) {
    for (NormalSheet& sheet : sheets_) sheet.side = -sheet.side;
  }
}

/// Finds the sides that are not known yet, those of large sheets first.
void Sheets::find_other_sides(DipoleField& field) {
  for (std::uint32_t first = 0; first < sheets_.size();) {
    if (sheets_[first].side != 0) {
      ++first;
      continue;
    }
    std::uint32_t last = first;
    while (last < sheets_.size() && sheets_[last].points * kSizeClass >= sheets_[first].points) ++last;
    field.build(sides());
    find_sides_by_field(field, sheets_.subspan(first, last - first));
  }
}

/// Finds the sides of those sheets that the field of the known ones tells clearly; if it tells none clearly, of all.
void Sheets::find_sides_by_field(const DipoleField& field, std::span<NormalSheet> sheets) {
  sample(field, sheets, kSheetSamples);
  const auto evidence = [](const NormalSheet& sheet) {
    const double bulge = sheet.reach > 0 ? sheet.flux / sheet.reach : 0;
    return bulge * (1 - 2 * mean(sheet, sheet.winding)) + mean(sheet, sheet.slope);
  };
  const auto clear = [&](const NormalSheet& sheet) {
    return sheet.side == 0 && std::abs(evidence(sheet)) >= kClearEvidence;
  };
  const double least = std::any_of(sheets.begin(), sheets.end(), clear) ? kClearEvidence : 0;
  for (NormalSheet& sheet : sheets) {
    if (sheet.side != 0 || std::abs(evidence(sheet)) < least) continue;
    const bool stays = rule_ == FirstSide::kLargest && !counts_.inside_out && !contradicts_neighbours(sheet);
    sheet.side = evidence(sheet) < (stays ? -kAloneEvidence : 0) ? -1 : 1;
  }
}

/// Evaluates the field at some points of each of the given sheets, `most` at most, but for those whose side is known by votes.
void Sheets::sample(const DipoleField& field, std::span<NormalSheet> sheets, std::uint32_t most) {
  for (NormalSheet& sheet : sheets) {
    sheet.winding = sheet.slope = 0;
    sheet.samples = 0;
  }
#pragma omp parallel for schedule(dynamic, 1024)
  for (std::uint32_t i = 0; i < cloud_.size; ++i) {
    if (sets_.fixed(i)) continue;
    NormalSheet* sheet = sheet_of(i);
    if (sheet == nullptr || sheet->votes != 0 || sheet < sheets.data() || sheet >= sheets.data() + sheets.size()) {
      continue;
    }
    if (scattered(i) % (sheet->points / most + 1) != 0) continue;
    const DipoleField::Value value = field(cloud_.position[i], sides());
    const auto size = static_cast<float>(std::sqrt(sheet->area / std::numbers::pi));
    const float slope = -size * value.gradient.dot(cloud_.normal[i].unpack());
    std::atomic_ref(sheet->winding).fetch_add(to_units(value.winding), std::memory_order_relaxed);
    std::atomic_ref(sheet->slope).fetch_add(to_units(slope), std::memory_order_relaxed);
    std::atomic_ref(sheet->samples).fetch_add(1, std::memory_order_relaxed);
  }
}

/// Whether the largest sheet faces into what all sheets enclose.
bool Sheets::first_is_inside_out(const DipoleField& field) {
  if (sheets_.empty()) return false;
  sample(field, sheets_.first(1), kFirstSamples);
  return mean(sheets_[0], sheets_[0].winding) < kInsideOut && !is_height_field();
}

bool Sheets::is_height_field() const {
  std::uint32_t down = 0;
  std::uint32_t all = 0;
  for (std::uint32_t i = 0; i < cloud_.size; ++i) {
    const float s = side(i);
    if (s == 0) continue;
    ++all;
    down += s * cloud_.normal[i].unpack()[2] < -kNeutralSine ? 1 : 0;
  }
  return down <= kFacesDown * all;
}

/// Turns the points that are in no sheet: outliers, and small groups at edges. They are not part of the field.
void Sheets::turn_loose_points(const DipoleField& field, Stays stays) {
  // stays() reads the normals of others, so all are asked before the first is turned. Classes have no other use before the clustering.
#pragma omp parallel for schedule(dynamic, 256)
  for (std::uint32_t i = 0; i < cloud_.size; ++i) {
    PackedNormal& normal = cloud_.normal[i];
    normal.point_class = PointClass::kNoise;
    if (sets_.fixed(i) || !normal.known() || sheet_of(i) != nullptr) continue;
    const float slope = field(cloud_.position[i], sides(), kRoughShare).gradient.dot(normal.unpack());
    if (!(slope > 0) || (cloud_.radius[i] * slope < kLooseEvidence && stays(i))) continue;
    normal.point_class = PointClass::kNeutral;
  }
  for (PackedNormal& normal : cloud_.normal.first(cloud_.size)) {
    if (normal.point_class == PointClass::kNoise) continue;
    normal.point_class = PointClass::kNoise;
    normal.turn_over();
    ++counts_.turned;
  }
}

/// Flux of all oriented points about their centroid: negative if the whole is inside out.
double Sheets::total_flux() const {
  Vec3d centroid = Vec3d::Zero();
  double total = 0;
  for (const NormalSheet& sheet : sheets_) {
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

}  // namespace plumbline::inline slicer
