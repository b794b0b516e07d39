#include "firmware/pictures/orientation_picture.hpp"

#include <algorithm>
#include <cmath>

#include "firmware/pictures/preview.hpp"
#include "firmware/pictures/preview_page.hpp"
#include "firmware/pictures/preview_shading.hpp"
#include "slicer/placement/core_bounds.hpp"
#include "slicer/placement/placement.hpp"

namespace plumbline {

using namespace preview;

namespace {

constexpr const char* kStage = "orientation picture";
constexpr std::array<Colour, 2> kColours{{{222, 222, 212}, {232, 150, 56}}};  // surface, needs supports
constexpr float kSteep = 0.70710678F;                                         ///< cosine of 45 degrees
constexpr std::uint32_t kColumns = 350, kRows = 560;                          ///< pixels of a view
constexpr std::uint32_t kStep = 372;                                          ///< from one view to the next
constexpr std::int64_t kLeft = 58, kFloor = 690;

/// Draws every point as a square of `reach` samples to each side, the nearest in front.
void splat(const Cloud& cloud, const Mat3d& rotation, const Vec3d& middle, double samples, double reach,
           const DepthMap& map) {
  std::fill(map.depth.begin(), map.depth.end(), DepthMap::kEmpty);
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    const Vec3d p = rotation * (cloud.position[i].cast<double>() - middle) * samples;
    const bool steep = rotation.row(2).dot(cloud.normal[i].unpack().cast<double>()) < -static_cast<double>(kSteep);
    const double x = 0.5 * map.columns + p[0];
    const double y = 0.5 * map.rows - p[2];
    const auto clamped = [](double v, std::uint32_t end) {
      return static_cast<std::uint32_t>(std::clamp<double>(v, 0, end));
    };
    for (std::uint32_t row = clamped(y - reach, map.rows); row < clamped(y + reach + 1, map.rows); ++row) {
      for (std::uint32_t column = clamped(x - reach, map.columns); column < clamped(x + reach + 1, map.columns);
           ++column) {
        if (static_cast<float>(p[1]) < map.at(column, row)) map.show(column, row, static_cast<float>(p[1]), steep);
      }
    }
  }
}

}  // namespace

Expected<std::span<const std::byte>> encode_orientations(const Cloud& cloud, float spacing, std::string_view name,
                                                         std::span<const OrientationView> views, Arena& arena,
                                                         PngEncoder& encoder) {
  const ArenaScope scope(arena);
  const auto rgb = arena.take_top<std::uint8_t>(std::size_t{3} * kPreviewColumns * kPreviewRows, kStage);
  PLUMBLINE_TRY(rgb);
  const Picture picture{*rgb, kPreviewColumns, kPreviewRows};
  constexpr std::uint32_t kMapColumns = kColumns * kSamplesPerPixel;
  constexpr std::uint32_t kMapRows = kRows * kSamplesPerPixel;
  constexpr std::size_t kMapSamples = std::size_t{kMapColumns} * kMapRows;
  const auto depths = arena.take_top<float>(2 * kMapSamples, kStage);
  PLUMBLINE_TRY(depths);
  const auto materials = arena.take_top<std::uint8_t>(kMapSamples, kStage);
  PLUMBLINE_TRY(materials);
  const DepthMap map{depths->first(kMapSamples), *materials, kMapColumns, kMapRows};
  draw_background(picture);
  const TextStyle title{.scale = 4, .colour = kInk};
  const TextStyle plain{.scale = 2, .colour = kInk};
  draw_text(picture, kLeft, 38, cut(name, kPreviewColumns - 700, title), title);
  constexpr std::string_view kAbout = "the best ways up; what needs supports is orange";
  draw_text(picture, std::int64_t{kPreviewColumns} - kLeft - text_width(kAbout, plain), 52, kAbout, plain);

  const auto core = core_bounds(cloud.positions(), arena);
  PLUMBLINE_TRY(core);
  const auto box = dense_bounds(cloud.positions(), *core, arena);
  PLUMBLINE_TRY(box);
  const Vec3d middle = box->centre().cast<double>();
  // The diagonal fits, so every orientation does.
  const Vec3d size = box->size().cast<double>();
  const double samples = std::min(kMapColumns, kMapRows) / std::max(1e-12, std::sqrt(size.dot(size)));
  const double reach = 0.75 * static_cast<double>(spacing) * samples;
  std::int64_t left = kLeft;
  for (const OrientationView& view : views) {
    splat(cloud, rotation_matrix({view.degrees[0], view.degrees[1], 0}), middle, samples, reach, map);
    const float voxel = static_cast<float>(std::max(1.0, 2 * reach));
    smooth_depth(map, depths->last(kMapSamples), {.across = voxel, .deep = voxel});
    shade_depth(map, picture, left, kFloor - kRows, kColours);
    std::int64_t line = kFloor + 30;
    for (const std::string_view text : view.lines) {
      draw_text(picture, left, line, cut(text, kStep - 12, plain), plain);
      line += 30;
    }
    left += kStep;
  }
  return encoder.encode(*rgb, kPreviewColumns, kPreviewRows);
}

}  // namespace plumbline
