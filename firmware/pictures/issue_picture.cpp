#include "firmware/pictures/issue_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <tuple>

#include "firmware/pictures/preview/preview.hpp"
#include "firmware/pictures/preview/preview_page.hpp"
#include "firmware/pictures/preview/preview_views.hpp"
#include "slicer/checks/overhangs.hpp"
#include "slicer/core/regions/layer_regions.hpp"
#include "slicer/supports/drawing/mask_stream.hpp"

namespace plumbline::firmware::inline pictures {

using namespace preview;

namespace {

constexpr const char* kStage = "issue picture";

/// Where the tiles are, in pixels.
struct TileLayout {
  std::uint32_t left, top;       ///< of the first one
  std::uint32_t columns, rows;   ///< of a tile
  std::uint32_t step, row_step;  ///< from one tile to the next
  std::uint32_t tiles_a_row;
};

/// The page: two rows of three tiles, each with two lines of text.
constexpr TileLayout kPage{60, 100, 470, 300, 505, 390, 3};
static_assert(kPage.left + 2 * kPage.step + kPage.columns <= kPreviewColumns &&
              kPage.top + kPage.row_step + kPage.rows <= kPreviewRows);
/// The page with an overview on the left.
constexpr TileLayout kPageBeside{344, 100, 380, 300, 408, 390, 3};
constexpr Page kOverview{.columns = kPreviewColumns,
                         .rows = kPreviewRows,
                         .margin = kPage.left,
                         .top = kPageBeside.top,
                         .bottom = kPageBeside.top + kPageBeside.row_step + kPageBeside.rows,
                         .gap = 45,
                         .beside = kPreviewColumns - kPageBeside.left + 34 - kPage.left};
static_assert(kPageBeside.left + 2 * kPageBeside.step + kPageBeside.columns <= kPreviewColumns - kPage.left);
constexpr std::int64_t kMark = 11;  ///< radius of a mark with the number of its tile, pixels
constexpr std::uint32_t kGap = 4;   ///< between the tiles of the small picture

/// The small picture: as few rows of tiles as there must be, which fill it.
TileLayout small_layout(std::size_t issues) {
  const auto count = static_cast<std::uint32_t>(issues);
  const std::uint32_t tiles_a_row = count <= 1 ? 1 : count <= 4 ? 2 : 3;
  const std::uint32_t tile_rows = (count + tiles_a_row - 1) / tiles_a_row;
  const std::uint32_t columns = (IssuesPicture::kMostColumns - (tiles_a_row - 1) * kGap) / tiles_a_row;
  const std::uint32_t rows = (IssuesPicture::kMostRows - (tile_rows - 1) * kGap) / tile_rows;
  return {0, 0, columns, rows, columns + kGap, rows + kGap, tiles_a_row};
}

constexpr Rgb kAir{28, 33, 40}, kSolid{206, 202, 192}, kBelow{86, 95, 107}, kIssue{232, 78, 56};

/// Pixels of the mask that a tile shows at least, on its shorter side.
constexpr double kLeastShown = 40;

/// What a tile shows of its layer, and what of it is the issue.
struct Layer {
  ConstBitImage mask;   ///< of the issue's layer
  ConstBitImage below;  ///< of the one below; black for layer 0
  const LayerRegions* regions = nullptr;
  std::uint32_t region = LayerRegions::kNone;  ///< the issue's; kNone: it is no region, or they are not known
  RegionBox box;                               ///< of the region, or of all white pixels
};

bool is_air(IssueKind kind) {
  return kind == IssueKind::kResinTrap || kind == IssueKind::kSuctionCup || kind == IssueKind::kPlateTrap;
}

/// The run that holds a pixel.
std::uint32_t run_at(const LayerRegions& regions, std::uint32_t column, std::uint32_t row) {
  std::uint32_t i = regions.row_begin(row);
  while (i + 1 < regions.row_begin(row + 1) &&
         (regions.run(i).first > regions.run(i).last || regions.run(i).last < column))
    ++i;
  return i;
}

/// The box of a region, or of all white pixels.
RegionBox box_of(const LayerRegions& regions, std::uint32_t region) {
  RegionBox box;
  for (std::uint32_t r = 0; r < regions.rows(); ++r) {
    for (std::uint32_t i = regions.row_begin(r); i < regions.row_begin(r + 1); ++i) {
      const auto run = regions.run(i);
      const bool counts = region == LayerRegions::kNone ? regions.white(r, i) : regions.region(i) == region;
      if (!counts || run.first > run.last) continue;
      box.column = std::min<std::uint32_t>(box.column, run.first);
      box.column_end = std::max<std::uint32_t>(box.column_end, run.last + 1U);
      box.row = std::min(box.row, r);
      box.row_end = r + 1;
    }
  }
  return box;
}

/// The box of an issue that is a part of a region, several times as wide as its area would be.
RegionBox around(const Issue& issue, const PrintGrid& grid) {
  const auto reach = static_cast<std::uint32_t>(2.5 * std::sqrt(static_cast<double>(issue.pixels))) + 1;
  RegionBox box;
  box.column = issue.column - std::min(issue.column, reach);
  box.row = issue.row - std::min(issue.row, reach);
  box.column_end = std::min(grid.columns, issue.column + reach);
  box.row_end = std::min(grid.rows, issue.row + reach);
  return box;
}

Rgb colour_at(const Issue& issue, const Layer& layer, std::uint32_t column, std::uint32_t row) {
  const bool white = layer.mask.at(column, row);
  const bool below = layer.below.at(column, row);
  bool is_issue = false;
  switch (issue.kind) {
    case IssueKind::kOverhang:
    case IssueKind::kUnreached:
    case IssueKind::kPeelJump: is_issue = white && !below; break;
    case IssueKind::kIsland:
    case IssueKind::kFreePiece:
    case IssueKind::kTear:
    case IssueKind::kResinTrap:
    case IssueKind::kSuctionCup:
    case IssueKind::kUnreachedIsland:
    case IssueKind::kPlateTrap:
    case IssueKind::kNeedle:
      is_issue = layer.region != LayerRegions::kNone && white != is_air(issue.kind) &&
                 layer.regions->region(run_at(*layer.regions, column, row)) == layer.region;
      break;
    case IssueKind::kTouchingBound:
    case IssueKind::kEmptyLayer:
    case IssueKind::kPrintHeight:
    case IssueKind::kThinWall:
    case IssueKind::kFirstLayerArea:
    case IssueKind::kPeelArea: is_issue = white; break;
  }
  if (is_issue) return kIssue;
  return white ? kSolid : below ? kBelow : kAir;
}

struct TilePlace {
  std::int64_t left = 0, top = 0;
};

void draw_tile(const Picture& picture, const TilePlace& place, const TileLayout& tile, const Issue& issue,
               const Layer& layer, const PrintGrid& grid) {
  const RegionBox& box = layer.box;
  const bool whole = box.empty();
  const double wide = whole ? grid.columns : 1.6 * (box.column_end - box.column);
  const double high = whole ? grid.rows : 1.6 * (box.row_end - box.row);
  // Pixels of the mask a pixel of the picture: the tile holds the box, and the pixels keep their shape.
  const double aspect = static_cast<double>(grid.pitch_y_mm) / static_cast<double>(grid.pitch_x_mm);
  const double step = std::max({wide / tile.columns, high * aspect / tile.rows, kLeastShown / tile.rows});
  const double middle_column = whole ? grid.columns / 2.0 : (box.column + box.column_end) / 2.0;
  const double middle_row = whole ? grid.rows / 2.0 : (box.row + box.row_end) / 2.0;
#pragma omp parallel for schedule(static)
  for (std::uint32_t y = 0; y < tile.rows; ++y) {
    const double row = middle_row + (y + 0.5 - tile.rows / 2.0) * step / aspect;
    for (std::uint32_t x = 0; x < tile.columns; ++x) {
      const double column = middle_column + (x + 0.5 - tile.columns / 2.0) * step;
      const bool outside = column < 0 || row < 0 || column >= grid.columns || row >= grid.rows;
      picture.fill(place.left + x, place.top + y, 1, 1,
                   outside
                       ? kAir
                       : colour_at(issue, layer, static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(row)));
    }
  }
}

using MarkPlace = std::array<std::int64_t, 2>;  ///< column and row of its middle

/// Draws the number of a tile on a disc round (column, row).
void draw_mark(const Picture& picture, std::int64_t column, std::int64_t row, std::size_t number) {
  for (std::int64_t y = -kMark; y <= kMark; ++y) {
    for (std::int64_t x = -kMark; x <= kMark; ++x) {
      const float outside = std::sqrt(static_cast<float>(x * x + y * y)) - static_cast<float>(kMark);
      picture.blend(column + x, row + y, kIssue, std::clamp(0.5F - outside, 0.0F, 1.0F));
    }
  }
  const char digit = static_cast<char>('0' + number);
  const Face& face = page_faces().plain;
  draw_text(picture, column - face.width({&digit, 1}) / 2, row - face.cap_height() / 2, {&digit, 1}, {face, kInk});
}

/// The nearest place to the right, to the left, above or below where a mark covers none of `others`.
MarkPlace nearest_free(const MarkPlace& wanted, std::span<const MarkPlace> others) {
  for (std::int64_t way = 0;; ++way) {
    for (const MarkPlace& step : {MarkPlace{1, 0}, MarkPlace{-1, 0}, MarkPlace{0, -1}, MarkPlace{0, 1}}) {
      const MarkPlace at{wanted[0] + way * step[0], wanted[1] + way * step[1]};
      const auto overlaps = [&](const MarkPlace& other) {
        const std::int64_t x = other[0] - at[0], y = other[1] - at[1];
        return x * x + y * y < 4 * kMark * kMark;
      };
      if (std::ranges::none_of(others, overlaps)) return at;
    }
  }
}

/// Draws the print from the front, each issue's place with the number of its tile.
Status draw_overview(const Picture& picture, const ShownIssues& shown, const RRep& rrep, const Supports& supports,
                     Arena& arena) {
  static_assert(ShownIssues::kMostShown < 10);
  const IssueScale scale(rrep.grid);
  std::array<MarkPlace, ShownIssues::kMostShown> marks = {};
  const auto find_places = [&](const SeenView& view) {
    for (std::size_t i = 0; i < shown.count; ++i) {
      const Issue& issue = shown.issues[i];
      const Vec3d at(scale.x_mm(issue), scale.y_mm(issue), scale.z_mm(issue.layer));
      const Vec3f sample = view.place(at.cast<float>()) / float{kSamplesPerPixel};
      marks[i] = {static_cast<std::int64_t>(sample[0]), static_cast<std::int64_t>(sample[1])};
    }
  };
  const Paint paint{kMaterials, find_places, kOfSupports};
  const auto layout = draw_views(rrep, supports, kOverview, Views::kFront, arena, picture, &paint);
  PLUMBLINE_TRY(layout);
  if (!*layout) return {};
  for (std::size_t i = 0; i < shown.count; ++i) {
    MarkPlace& mark = marks[i];
    mark = {mark[0] + (*layout)->front_left, mark[1] + (*layout)->floor - (*layout)->height};
    mark = nearest_free(mark, std::span(marks).first(i));
    draw_mark(picture, mark[0], mark[1], i + 1);
  }
  return {};
}

/// @param number  of the tile; 0: it has none
void draw_caption(const Picture& picture, const TilePlace& place, const TileLayout& tile, std::size_t number,
                  const Issue& issue, const IssueScale& scale) {
  const std::int64_t top = place.top + tile.rows + 12;
  const LabelStyle plain{page_faces().plain, kInk};
  const LabelStyle pale{page_faces().plain, kPaleInk};
  char text[96];
  const IssueWords& words = words_of(issue.kind);
  const bool is_volume = words.size == IssueSize::kVolume;
  const double size = is_volume ? scale.ml(issue.voxels) : scale.mm2(issue.pixels);
  const bool is_drop = is_volume && size < 0.01;  // told in mm3, which takes fewer digits
  std::snprintf(text, sizeof text, "%.*s, %.3g %s", static_cast<int>(words.one.size()), words.one.data(),
                is_drop ? 1000 * size : size,
                is_drop     ? "mm3"
                : is_volume ? "ml"
                            : "mm2");
  if (number > 0) draw_mark(picture, place.left + 2 * kMark, place.top + 2 * kMark, number);
  draw_text(picture, place.left, top, plain.face.start_of(text, static_cast<int>(tile.step - 12)), plain);
  std::snprintf(text, sizeof text, "layer %u, %.2f mm: x %.1f, y %.1f mm", issue.layer, scale.z_mm(issue.layer),
                scale.x_mm(issue), scale.y_mm(issue));
  draw_text(picture, place.left, top + 24, pale.face.start_of(text, static_cast<int>(tile.step - 12)), pale);
}

/// Draws a tile for each issue.
/// @param caption  called with each issue's place in `shown` and where its tile is
template <class Caption>
Status draw_tiles(const Picture& picture, const TileLayout& tile, const ShownIssues& shown, const PrintGrid& grid,
                  MaskOf masks, Arena& arena, Caption caption) {
  const ArenaScope scope(arena);
  std::array<BitImage, 2> images;  // the layer below, the layer
  for (BitImage& image : images) {
    const auto words = arena.take_top<std::uint64_t>(BitImage::words_needed(grid.columns, grid.rows), kStage);
    PLUMBLINE_TRY(words);
    image = BitImage(*words, grid.columns, grid.rows);
  }
  auto regions = LayerRegions::create(
      grid.columns, grid.rows, arena,
      {.runs_per_row = std::max(64U, grid.columns / 32), .join_white_corners = false, .stage = kStage});
  PLUMBLINE_TRY(regions);
  for (std::uint32_t i = 0; i < shown.count; ++i) {
    const Issue& issue = shown.issues[i];
    images[0].clear();
    for (std::uint32_t below = issue.layer > 0 ? 1 : 0, k = issue.layer - below; k <= issue.layer; ++k) {
      const auto mask = masks(k);
      PLUMBLINE_TRY(mask);
      std::copy(mask->words().begin(), mask->words().end(), images[k == issue.layer ? 1 : 0].words().begin());
    }
    Layer layer{.mask = images[1], .below = images[0], .regions = &*regions, .box = {}};
    if (regions->label(images[1])) {
      const bool is_region = is_air(issue.kind) || issue.kind == IssueKind::kIsland ||
                             issue.kind == IssueKind::kFreePiece || issue.kind == IssueKind::kTear ||
                             issue.kind == IssueKind::kUnreachedIsland || issue.kind == IssueKind::kNeedle ||
                             issue.kind == IssueKind::kThinWall;
      if (is_region) layer.region = regions->region(run_at(*regions, issue.column, issue.row));
      layer.box = box_of(*regions, layer.region);
      if (issue.kind == IssueKind::kOverhang || issue.kind == IssueKind::kUnreached) {
        layer.box = layer.box.empty() ? layer.box : around(issue, grid);
      }
    }
    const TilePlace place{tile.left + i % tile.tiles_a_row * tile.step,
                          tile.top + i / tile.tiles_a_row * tile.row_step};
    draw_tile(picture, place, tile, issue, layer, grid);
    caption(i, place);
  }
  return {};
}

/// Draws tiles and texts on a page that has its background.
Status draw_page(const Picture& picture, const TileLayout& tile, bool numbered, const ShownIssues& shown,
                 const PrintGrid& grid, std::string_view name, MaskOf masks, Arena& arena) {
  const LabelStyle title{page_faces().title, kInk};
  draw_text(picture, kPage.left, 38, title.face.start_of(name, kPreviewColumns - 800), title);
  constexpr std::string_view kAbout = "issues in red; grey: the layer below";
  const LabelStyle plain{page_faces().plain, kPaleInk};
  draw_text(picture, std::int64_t{kPreviewColumns} - kPage.left - plain.face.width(kAbout), 52, kAbout, plain);
  const IssueScale scale(grid);
  return draw_tiles(picture, tile, shown, grid, masks, arena, [&](std::size_t i, const TilePlace& place) {
    draw_caption(picture, place, tile, numbered ? i + 1 : 0, shown.issues[i], scale);
  });
}

/// Calls `draw` with a function that makes the masks of an R-Rep anew.
template <class Draw>
auto with_masks(const RRep& rrep, const Supports& supports, Arena& arena, Draw draw) {
  const std::size_t bottom = arena.bottom_mark();
  auto stream = MaskStream::create(rrep, supports, arena);
  const auto mask = [&](std::uint32_t layer) -> Expected<ConstBitImage> {
    PLUMBLINE_TRY(stream);
    return stream->mask(layer);
  };
  const auto drawn = draw(MaskOf(mask));
  arena.release_bottom(bottom);
  return drawn;
}

}  // namespace

ShownIssues::ShownIssues(const StackFindings& findings) {
  for (std::size_t place = 0; place < IssueGroup::kKept; ++place) {
    for (const IssueGroup& group : findings.groups) {
      if (place >= group.told_kept().size() || count == kMostShown) continue;
      if (group.kept[place].kind != IssueKind::kEmptyLayer) issues[count++] = group.kept[place];
    }
  }
  std::sort(issues.begin(), issues.begin() + static_cast<std::ptrdiff_t>(count), [](const Issue& a, const Issue& b) {
    return std::tie(a.layer, a.kind, a.row, a.column) < std::tie(b.layer, b.kind, b.row, b.column);
  });
}

Status draw_issues(const StackFindings& findings, const PrintGrid& grid, std::string_view name, MaskOf masks,
                   Arena& arena, std::span<std::uint8_t> rgb) {
  const Picture picture{rgb, kPreviewColumns, kPreviewRows};
  draw_background(picture);
  return draw_page(picture, kPage, false, ShownIssues(findings), grid, name, masks, arena);
}

Status draw_issues(const StackFindings& findings, const RRep& rrep, const Supports& supports, std::string_view name,
                   Arena& arena, std::span<std::uint8_t> rgb) {
  const Picture picture{rgb, kPreviewColumns, kPreviewRows};
  const ShownIssues shown(findings);
  PLUMBLINE_TRY(draw_overview(picture, shown, rrep, supports, arena));
  return with_masks(rrep, supports, arena, [&](MaskOf masks) {
    return draw_page(picture, kPageBeside, true, shown, rrep.grid, name, masks, arena);
  });
}

Status draw_issues_picture(const StackFindings& findings, const RRep& rrep, const Supports& supports, Arena& arena,
                           IssuesPicture& picture) {
  return with_masks(rrep, supports, arena,
                    [&](MaskOf masks) { return draw_issues_picture(findings, rrep.grid, masks, arena, picture); });
}

Status draw_issues_picture(const StackFindings& findings, const PrintGrid& grid, MaskOf masks, Arena& arena,
                           IssuesPicture& picture) {
  picture.clear();
  const ShownIssues shown(findings);
  if (shown.count == 0) return {};
  const Picture pixels{picture.memory, IssuesPicture::kMostColumns, IssuesPicture::kMostRows};
  draw_background(pixels);
  PLUMBLINE_TRY(draw_tiles(pixels, small_layout(shown.count), shown, grid, masks, arena,
                           [](std::size_t /*issue*/, const TilePlace& /*place*/) {}));
  picture.columns = IssuesPicture::kMostColumns;
  picture.rows = IssuesPicture::kMostRows;
  return {};
}

}  // namespace plumbline::firmware::inline pictures
