#include "firmware/pictures/orientation_picture.hpp"

#include <algorithm>
#include <cmath>

#include "firmware/pictures/preview/preview.hpp"
#include "firmware/pictures/preview/preview_page.hpp"
#include "firmware/pictures/preview/preview_shading.hpp"
#include "firmware/pictures/preview/preview_smoothing.hpp"
#include "slicer/placement/core_bounds.hpp"
#include "slicer/placement/placement.hpp"

namespace plumbline::firmware::inline pictures {

using namespace preview;

namespace {

constexpr const char* kStage = "orientation picture";
constexpr std::array<Rgb, 2> kColours{{{222, 222, 212}, {232, 150, 56}}};  // surface, needs supports
constexpr std::uint32_t kColumns = 350, kRows = 560;                       ///< pixels of a view
constexpr std::uint32_t kStep = 372;                                       ///< from one view to the next
constexpr std::int64_t kLeft = 58, kFloor = 670;

constexpr std::array<Rgb, 2> kSidesOfScan{{{222, 222, 212}, {96, 108, 122}}};  // of its surface: outside, inside
constexpr std::uint32_t kMostDrawnPoints = 1U << 17U;                          ///< of a small picture

/// Where the object is, and how large.
struct ScanSight {
  Vec3d middle;
  double diagonal;  ///< it fits, so every orientation does
};

Expected<ScanSight> find_sight(const Cloud& cloud, Arena& arena) {
  const auto core = core_bounds(cloud.positions(), arena);
  PLUMBLINE_TRY(core);
  const auto box = dense_bounds(cloud.positions(), *core, arena);
  PLUMBLINE_TRY(box);
  const Vec3d size = box->size().cast<double>();
  return ScanSight{box->centre().cast<double>(), std::max(1e-12, std::sqrt(size.dot(size)))};
}

/// Room for a depth map.
struct MapMemory {
  DepthMap map;
  std::span<float> scratch;
};

Expected<MapMemory> take_map(std::uint32_t columns, std::uint32_t rows, Arena& arena) {
  const std::size_t samples = std::size_t{columns} * rows;
  const auto depths = arena.take_top<float>(2 * samples, kStage);
  PLUMBLINE_TRY(depths);
  const auto materials = arena.take_top<std::uint8_t>(samples, kStage);
  PLUMBLINE_TRY(materials);
  return MapMemory{{depths->first(samples), *materials, columns, rows}, depths->last(samples)};
}

/// Draws each step-th point as a square, the nearest in front.
/// @param spacing    distance of these points from each other, unit of the cloud
/// @param is_second  whether a point with this rotated normal is of the second material
template <class IsSecond>
void draw_points(const Cloud& cloud, std::uint32_t step, float spacing, const Mat3d& rotation, const ScanSight& sight,
                 const MapMemory& memory, const IsSecond& is_second) {
  const DepthMap& map = memory.map;
  const double samples = std::min(map.columns, map.rows) / sight.diagonal;
  const double reach = 0.75 * static_cast<double>(spacing) * samples;  // to each side of a point
  std::fill(map.depth.begin(), map.depth.end(), DepthMap::kEmpty);
  for (std::uint32_t i = 0; i < cloud.size; i += step) {
    const Vec3d p = rotation * (cloud.position[i].cast<double>() - sight.middle) * samples;
    const bool second = is_second(rotation * cloud.normal[i].unpack().cast<double>());
    const double x = 0.5 * map.columns + p[0];
    const double y = 0.5 * map.rows - p[2];
    const auto clamped = [](double v, std::uint32_t end) {
      return static_cast<std::uint32_t>(std::clamp<double>(v, 0, end));
    };
    for (std::uint32_t row = clamped(y - reach, map.rows); row < clamped(y + reach + 1, map.rows); ++row) {
      for (std::uint32_t column = clamped(x - reach, map.columns); column < clamped(x + reach + 1, map.columns);
           ++column) {
        if (static_cast<float>(p[1]) < map.at(column, row)) map.show(column, row, static_cast<float>(p[1]), second);
      }
    }
  }
  const float voxel = static_cast<float>(std::max(1.0, 2 * reach));
  smooth_depth(map, memory.scratch, {.across = voxel, .deep = voxel});
}

/// What needs supports is the second material.
void draw_view(const Cloud& cloud, std::uint32_t step, float spacing, const std::array<double, 2>& degrees,
               const ScanSight& sight, const MapMemory& memory) {
  const auto needs_support = [](const Vec3d& normal) { return normal[2] < -static_cast<double>(kNeedsSupport); };
  draw_points(cloud, step, spacing, rotation_matrix({degrees[0], degrees[1], 0}), sight, memory, needs_support);
}

/// What the small pictures of one cloud share.
struct Studio {
  ScanSight sight;
  MapMemory memory;
};

/// @param arena  given back by the caller
template <class SmallPicture>
Expected<Studio> set_up(const Cloud& cloud, Arena& arena) {
  const auto memory =
      take_map(SmallPicture::kMostColumns * kSamplesPerPixel, SmallPicture::kMostRows * kSamplesPerPixel, arena);
  PLUMBLINE_TRY(memory);
  const auto sight = find_sight(cloud, arena);
  PLUMBLINE_TRY(sight);
  return Studio{*sight, *memory};
}

/// Shades what was drawn into the map.
template <class SmallPicture>
void fill_in(SmallPicture& picture, const MapMemory& memory, const std::array<Rgb, 2>& colours) {
  picture.columns = SmallPicture::kMostColumns;
  picture.rows = SmallPicture::kMostRows;
  const Picture page{picture.bytes(), picture.columns, picture.rows};
  draw_background(page);
  shade_depth(memory.map, memory.scratch, page, 0, 0, colours);
  keep_five_bits(picture.bytes());
}

}  // namespace

Expected<std::span<const std::byte>> encode_orientations(const Cloud& cloud, float spacing, std::string_view name,
                                                         std::span<const OrientationView> views, Arena& arena,
                                                         PictureEncoder& encoder) {
  const ArenaScope scope(arena);
  const auto rgb = arena.take_top<std::uint8_t>(kPageBytes, kStage);
  PLUMBLINE_TRY(rgb);
  const Picture picture{*rgb, kPreviewColumns, kPreviewRows};
  const auto memory = take_map(kColumns * kSamplesPerPixel, kRows * kSamplesPerPixel, arena);
  PLUMBLINE_TRY(memory);
  draw_background(picture);
  const LabelStyle title{page_faces().title, kInk};
  const LabelStyle plain{page_faces().plain, kInk};
  draw_text(picture, kLeft, 38, title.face.start_of(name, kPreviewColumns - 700), title);
  constexpr std::string_view kAbout = "the best orientations; what needs supports is orange";
  draw_text(picture, std::int64_t{kPreviewColumns} - kLeft - plain.face.width(kAbout), 52, kAbout, plain);

  const auto sight = find_sight(cloud, arena);
  PLUMBLINE_TRY(sight);
  std::int64_t left = kLeft;
  for (const OrientationView& view : views) {
    draw_view(cloud, 1, spacing, view.degrees, *sight, *memory);
    shade_depth(memory->map, memory->scratch, picture, left, kFloor - kRows, kColours);
    std::int64_t line = kFloor + 30;
    for (const std::string_view text : view.lines) {
      draw_text(picture, left, line, plain.face.start_of(text, kStep - 12), plain);
      line += 30;
    }
    left += kStep;
  }
  return encoder.encode(*rgb, kPreviewColumns, kPreviewRows);
}

Status draw_proposal_pictures(const Cloud& cloud, float spacing, std::span<const std::array<double, 2>> degrees,
                              Arena& arena, ProposalPictures& pictures) {
  for (ProposalPicture& picture : pictures) picture.clear();
  const ArenaScope scope(arena);
  const auto studio = set_up<ProposalPicture>(cloud, arena);
  PLUMBLINE_TRY(studio);
  const std::uint32_t step = cloud.size / kMostDrawnPoints + 1;
  const float apart = spacing * std::sqrt(static_cast<float>(step));
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    draw_view(cloud, step, apart, degrees[i], studio->sight, studio->memory);
    fill_in(pictures[i], studio->memory, kColours);
  }
  return {};
}

Status draw_scan_picture(const Cloud& cloud, Arena& arena, ScanPicture& picture) {
  picture.clear();
  const ArenaScope scope(arena);
  const auto studio = set_up<ScanPicture>(cloud, arena);
  PLUMBLINE_TRY(studio);
  constexpr std::uint32_t kEnough = 1U << 15U;
  const std::uint32_t step = cloud.size / kEnough + 1;
  // As if the points lay on a ball of that diameter.
  const double radius = studio->sight.diagonal / 2;
  const auto apart = static_cast<float>(radius * std::sqrt(4 * 3.14159 * step / cloud.size));
  const auto faces_away = [](const Vec3d& normal) { return normal[1] > 0.1; };
  const auto draw = [&](int side) {
    constexpr double kAbove = 20;
    const Mat3d rotation = rotation_matrix({kAbove, 0, 0}) * rotation_matrix({0, 0, side * 45.0});
    draw_points(cloud, step, apart, rotation, studio->sight, studio->memory, faces_away);
  };
  const DepthMap& map = studio->memory.map;
  int best = 0;
  std::size_t most = 0;
  for (int side = 0; side < 8; ++side) {
    draw(side);
    std::size_t seen = 0;
    for (std::size_t i = 0; i < map.depth.size(); ++i) {
      if (map.depth[i] < DepthMap::kEmpty && map.material[i] == 0) ++seen;
    }
    // Others must be clearly better than the front.
    if (seen <= most + most / 20) continue;
    most = seen;
    best = side;
  }
  draw(best);
  fill_in(picture, studio->memory, kSidesOfScan);
  return {};
}

}  // namespace plumbline::firmware::inline pictures
