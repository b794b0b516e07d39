#include "firmware/pictures/coverage_picture.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "firmware/pictures/coverage_survey.hpp"
#include "firmware/pictures/coverage_views.hpp"
#include "firmware/pictures/preview/preview_page.hpp"
#include "firmware/pictures/preview/preview_smoothing.hpp"

namespace plumbline {

using namespace preview;

namespace {

constexpr const char* kStage = "coverage picture";

/// By Evidence.
constexpr std::array<Colour, kEvidenceCount> kColours{{{222, 222, 212}, {232, 78, 56}, {74, 138, 232}}};
constexpr std::array<const char*, kEvidenceCount> kMeanings{"scanned", "not scanned: closed to fit its surroundings",
                                                            "not scanned: underside, closed flat"};

void draw_legend(const Picture& picture, const ConfidenceMap& map) {
  const auto share = map.surface();
  std::int64_t line = 788;
  for (std::size_t e = 0; e < kEvidenceCount; ++e, line += 24) {
    picture.fill(kMargin, line - 1, 30, 16, kColours[e]);
    char text[96];
    std::snprintf(text, sizeof text, "%5.1f %%  %s", 100 * share[e], kMeanings[e]);
    draw_text(picture, kMargin + 44, line, text, {.scale = 2, .colour = kInk});
  }
}

Status draw(const RRep& rrep, const ConfidenceMap& map, const PreviewText& text, Arena& arena, const Picture& picture) {
  PLUMBLINE_TRY(draw_coverage_views(rrep, map, kCoveragePage, true, arena, picture));
  const TextStyle title{.scale = 4, .colour = kInk};
  draw_text(picture, kMargin, 38, cut(text.name, kPreviewColumns - 700, title), title);
  constexpr std::string_view kAbout = "which parts of the surface were scanned";
  const TextStyle plain{.scale = 2, .colour = kInk};
  draw_text(picture, std::int64_t{kPreviewColumns} - kMargin - text_width(kAbout, plain), 52, kAbout, plain);
  draw_legend(picture, map);
  return {};
}

}  // namespace

Expected<PagePart> preview::draw_coverage_views(const RRep& rrep, const ConfidenceMap& map, const Page& page,
                                                bool named, Arena& arena, const Picture& picture) {
  const ArenaScope scope(arena);
  draw_background(picture);
  const PrintGrid& grid = rrep.grid;
  const auto words = arena.take_top<std::uint64_t>(BitImage::words_needed(grid.columns, grid.rows), kStage);
  PLUMBLINE_TRY(words);
  const TextStyle plain{.scale = 2, .colour = kInk};
  const Extent extent = find_extent(rrep, *words);
  if (extent.empty()) return PagePart{};
  const CoverageLayout layout = CoverageLayout::of(extent, grid, page);
  const auto in_samples = [&](float mm) { return mm * static_cast<float>(layout.samples_per_mm); };
  std::int64_t left = layout.left;
  // Two views at a time: all four at once would need more memory than any other stage of a small job.
  const auto draw_pair = [&](bool walls) -> Status {
    const ArenaScope pair(arena);
    const std::uint32_t columns = layout.width * kSamplesPerPixel;
    const std::uint32_t rows = (walls ? layout.height : layout.depth) * kSamplesPerPixel;
    const std::size_t samples = std::size_t{columns} * rows;
    const auto depths = arena.take_top<float>(2 * samples, kStage);
    PLUMBLINE_TRY(depths);
    const auto materials = arena.take_top<std::uint8_t>(2 * samples, kStage);
    PLUMBLINE_TRY(materials);
    std::fill(depths->begin(), depths->end(), DepthMap::kEmpty);
    const DepthMap first{depths->first(samples), materials->first(samples), columns, rows};
    const DepthMap second{depths->last(samples), materials->last(samples), columns, rows};
    const CoverageViews views = walls ? CoverageViews{first, second, {}, {}} : CoverageViews{{}, {}, first, second};
    PLUMBLINE_TRY(survey_coverage(rrep, map, extent, layout, *words, arena, views));

    const auto scratch = arena.take_top<float>(samples, kStage);
    PLUMBLINE_TRY(scratch);
    const float across_mm =
        walls ? std::max(grid.pitch_x_mm, grid.layer_height_mm) : std::max(grid.pitch_x_mm, grid.pitch_y_mm);
    const float deep_mm = walls ? grid.pitch_y_mm : grid.layer_height_mm;
    for (const bool is_first : {true, false}) {
      const DepthMap& view = is_first ? first : second;
      const std::string_view name = walls ? (is_first ? "front" : "back") : (is_first ? "above" : "below");
      smooth_depth(view, *scratch, {.across = in_samples(across_mm), .deep = in_samples(deep_mm)});
      const std::int64_t height = rows / kSamplesPerPixel;
      shade_depth(view, *scratch, picture, left, (std::int64_t{page.top} + page.bottom - height) / 2, kColours);
      if (named) {
        draw_text(picture, left + (std::int64_t{layout.width} - text_width(name, plain)) / 2, page.bottom + 6, name,
                  plain);
      }
      left += layout.step;
    }
    return {};
  };
  PLUMBLINE_TRY(draw_pair(true));
  PLUMBLINE_TRY(draw_pair(false));
  const std::uint32_t tall = std::max(layout.height, layout.depth);
  return PagePart{static_cast<std::uint32_t>(layout.left) - kRim, (page.top + page.bottom - tall) / 2 - kRim,
                  static_cast<std::uint32_t>(3 * layout.step) + layout.width + 2 * kRim, tall + 2 * kRim};
}

Expected<std::span<const std::byte>> encode_coverage(const RRep& rrep, const ConfidenceMap& map,
                                                     const PreviewText& text, Arena& arena, PngEncoder& encoder) {
  const ArenaScope scope(arena);
  const auto rgb = arena.take_top<std::uint8_t>(std::size_t{3} * kPreviewColumns * kPreviewRows, kStage);
  PLUMBLINE_TRY(rgb);
  PLUMBLINE_TRY(draw(rrep, map, text, arena, {*rgb, kPreviewColumns, kPreviewRows}));
  return encoder.encode(*rgb, kPreviewColumns, kPreviewRows);
}

}  // namespace plumbline
