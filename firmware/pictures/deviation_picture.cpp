#include "firmware/pictures/deviation_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "firmware/pictures/preview/preview_page.hpp"
#include "firmware/pictures/preview/preview_views.hpp"

namespace plumbline::firmware::inline pictures {

using namespace preview;

namespace {

constexpr float kMostUm = 250;  // of the scale
constexpr std::size_t kSteps = 100;

/// Object and supports as in the preview, and then the scale.
std::array<Rgb, kMaterials.size() + 2 * kSteps + 1> palette() {
  constexpr std::array<Rgb, 3> kScale{{{36, 84, 214}, {250, 248, 244}, {214, 44, 32}}};
  std::array<Rgb, kMaterials.size() + 2 * kSteps + 1> colours;
  std::copy(kMaterials.begin(), kMaterials.end(), colours.begin());
  colours[0] = {150, 150, 146};
  for (std::size_t i = 0; i <= 2 * kSteps; ++i) {
    const std::size_t half = std::min(i / kSteps, std::size_t{1});
    const float share = static_cast<float>(i - half * kSteps) / kSteps;
    for (std::size_t c = 0; c < 3; ++c) {
      const float mixed =
          static_cast<float>(kScale[half][c]) * (1 - share) + static_cast<float>(kScale[half + 1][c]) * share;
      colours[kMaterials.size() + i][c] = static_cast<std::uint8_t>(mixed + 0.5F);
    }
  }
  return colours;
}

std::uint8_t colour_of(float deviation_mm) {
  const float step = std::clamp(1000 * deviation_mm / kMostUm, -1.0F, 1.0F) * kSteps;
  return static_cast<std::uint8_t>(static_cast<int>(kMaterials.size() + kSteps) + static_cast<int>(std::lround(step)));
}

/// Gives each sample of a view that shows the object the colour of the nearest point that is seen near it.
void paint(std::span<const OrientedPoint> points, std::span<const float> deviations_mm, const SeenView& view) {
  const DepthMap& map = view.map;
  // Half of the points face the view, so each covers about this many samples, at most.
  const double piece = 2.0 * map.columns * map.rows / static_cast<double>(std::max<std::size_t>(points.size(), 1));
  const auto reach = static_cast<std::int64_t>(std::clamp(2 * std::sqrt(piece), 3.0, 40.0));
  const auto steepest = static_cast<float>(4 * reach);  // a piece may be steep, and its walls thin
  std::vector<float> nearest(map.depth.size(), static_cast<float>(reach * reach));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3f place = view.place(points[i].at), facing = view.place(points[i].at + points[i].normal) - place;
    if (facing[2] >= 0) continue;
    const auto column = static_cast<std::int64_t>(place[0]), row = static_cast<std::int64_t>(place[1]);
    for (std::int64_t r = std::max<std::int64_t>(row - reach, 0);
         r <= std::min(row + reach, std::int64_t{map.rows} - 1); ++r) {
      for (std::int64_t c = std::max<std::int64_t>(column - reach, 0);
           c <= std::min(column + reach, std::int64_t{map.columns} - 1); ++c) {
        const std::size_t sample = static_cast<std::size_t>(r) * map.columns + static_cast<std::size_t>(c);
        const auto away = static_cast<float>((r - row) * (r - row) + (c - column) * (c - column));
        if (away >= nearest[sample] || map.material[sample] == 1 || std::abs(map.depth[sample] - place[2]) > steepest)
          continue;
        nearest[sample] = away;
        map.material[sample] = colour_of(deviations_mm[i]);
      }
    }
  }
}

}  // namespace

Status draw_deviation(const RRep& rrep, const Supports& supports, const PreviewText& text,
                      std::span<const OrientedPoint> points, std::span<const float> deviations_mm, Arena& arena,
                      std::span<std::uint8_t> rgb) {
  const auto colours = palette();
  const auto paint_view = [&](const SeenView& view) { paint(points, deviations_mm, view); };
  const Paint how{colours, paint_view, kOfSupports};
  PLUMBLINE_TRY(draw_preview(rrep, supports, text, arena, rgb, &how));
  const Picture picture{rgb, kPreviewColumns, kPreviewRows};
  const LabelStyle plain{page_faces().plain, kInk};
  constexpr std::int64_t kStep = 2, kWidth = kStep * (2 * kSteps + 1), kTop = 800;
  constexpr std::int64_t kLeft = std::int64_t{kPreviewColumns} - kMargin - kWidth - 60;
  for (std::size_t i = 0; i <= 2 * kSteps; ++i) {
    picture.fill(kLeft + static_cast<std::int64_t>(i) * kStep, kTop, kStep, 18, colours[kMaterials.size() + i]);
  }
  const std::array<std::pair<std::int64_t, std::string_view>, 3> labels{
      {{0, "-250 um"}, {kWidth / 2, "0"}, {kWidth, "+250 um"}}};
  for (const auto& [at, label] : labels)
    draw_text(picture, kLeft + at - plain.face.width(label) / 2, kTop + 28, label, plain);
  return {};
}

}  // namespace plumbline::firmware::inline pictures
