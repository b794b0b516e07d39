#include "firmware/pictures/coverage_picture.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "firmware/pictures/coverage_survey.hpp"
#include "firmware/pictures/preview/preview_page.hpp"
#include "firmware/pictures/preview/preview_smoothing.hpp"

namespace plumbline::firmware::inline pictures {

using namespace preview;

namespace {

constexpr const char* kStage = "coverage picture";

/// By Evidence.
constexpr std::array<Rgb, kEvidenceCount> kColours{{{222, 222, 212}, {232, 78, 56}, {74, 138, 232}}};
constexpr std::array<const char*, kEvidenceCount> kMeanings{"scanned", "not scanned: closed to fit its surroundings",
                                                            "not scanned: underside, closed flat"};

void draw_legend(const Picture& picture, const ConfidenceMap& map) {
  const auto share = map.surface();
  const LabelStyle plain{page_faces().plain, kInk};
  const std::int64_t middle = std::int64_t{kMargin} + 44 + plain.face.width("100.0 %");
  std::int64_t line = 788;
  for (std::size_t e = 0; e < kEvidenceCount; ++e, line += 24) {
    picture.fill(kMargin, line - 1, 30, 16, kColours[e]);
    char percent[16];
    std::snprintf(percent, sizeof percent, "%.1f %%", 100 * share[e]);
    draw_text(picture, middle - plain.face.width(percent), line, percent, plain);
    draw_text(picture, middle + 14, line, kMeanings[e], plain);
  }
}

/// Draws the print from the front, the back, above and below.
Status draw_views(const RRep& rrep, const ConfidenceMap& map, Arena& arena, const Picture& picture) {
  constexpr const Page& page = kCoveragePage;
  const ArenaScope scope(arena);
  const PrintGrid& grid = rrep.grid;
  Extent extent;
  {
    const ArenaScope looking(arena);
    const auto words = arena.take_top<std::uint64_t>(BitImage::words_needed(grid.columns, grid.rows), kStage);
    PLUMBLINE_TRY(words);
    extent = find_extent(rrep, *words);
  }
  const LabelStyle plain{page_faces().plain, kInk};
  if (extent.empty()) return {};
  const CoverageLayout layout = CoverageLayout::of(extent, grid, page);
  const auto in_samples = [&](float mm) { return mm * static_cast<float>(layout.samples_per_mm); };
  std::int64_t left = layout.left;
  // Two views at a time: all four at once would need more memory than any other stage of a small job.
  const std::uint32_t columns = layout.width * kSamplesPerPixel;
  for (const bool walls : {true, false}) {
    const ArenaScope pair(arena);
    const std::uint32_t height = walls ? layout.height : layout.depth, rows = height * kSamplesPerPixel;
    const std::size_t samples = std::size_t{columns} * rows;
    const auto depths = arena.take_top<float>(2 * samples, kStage);
    PLUMBLINE_TRY(depths);
    const auto materials = arena.take_top<std::uint8_t>(2 * samples, kStage);
    PLUMBLINE_TRY(materials);
    const std::array<DepthMap, 2> views = {{{depths->first(samples), materials->first(samples), columns, rows},
                                            {depths->last(samples), materials->last(samples), columns, rows}}};
    PLUMBLINE_TRY(survey_coverage(rrep, map, extent, layout, arena, walls, views));
    const auto scratch = arena.take_top<float>(samples, kStage);
    PLUMBLINE_TRY(scratch);
    const float across_mm = std::max(grid.pitch_x_mm, walls ? grid.layer_height_mm : grid.pitch_y_mm);
    const float deep_mm = walls ? grid.pitch_y_mm : grid.layer_height_mm;
    for (std::size_t v = 0; v < views.size(); ++v, left += layout.step) {
      smooth_depth(views[v], *scratch, {.across = in_samples(across_mm), .deep = in_samples(deep_mm)});
      shade_depth(views[v], *scratch, picture, left, (std::int64_t{page.top} + page.bottom - height) / 2, kColours);
      const std::string_view name = walls ? (v == 0 ? "front" : "back") : (v == 0 ? "above" : "below");
      const std::int64_t spare = std::int64_t{layout.width} - plain.face.width(name);
      draw_text(picture, left + spare / 2, page.bottom + 6, name, plain);
    }
  }
  return {};
}

}  // namespace

Status draw_coverage(const RRep& rrep, const ConfidenceMap& map, std::string_view name, Arena& arena,
                     std::span<std::uint8_t> rgb) {
  const Picture picture{rgb, kPreviewColumns, kPreviewRows};
  draw_background(picture);
  PLUMBLINE_TRY(draw_views(rrep, map, arena, picture));
  const LabelStyle title{page_faces().title, kInk};
  draw_text(picture, kMargin, 38, title.face.start_of(name, kPreviewColumns - 700), title);
  constexpr std::string_view kAbout = "which parts of the surface were scanned";
  const LabelStyle plain{page_faces().plain, kInk};
  draw_text(picture, std::int64_t{kPreviewColumns} - kMargin - plain.face.width(kAbout), 52, kAbout, plain);
  draw_legend(picture, map);
  return {};
}

}  // namespace plumbline::firmware::inline pictures
