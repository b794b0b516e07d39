#include "firmware/pictures/orientation_picture.hpp"

#include <algorithm>
#include <functional>
#include <limits>

#include "firmware/pictures/drawn_points.hpp"
#include "firmware/pictures/preview/preview.hpp"
#include "firmware/pictures/preview/preview_page.hpp"
#include "firmware/pictures/preview/preview_shading.hpp"
#include "slicer/placement/placement.hpp"

namespace plumbline::firmware::inline pictures {

using namespace preview;

namespace {

constexpr const char* kStage = "orientation picture";
constexpr std::array<Rgb, 2> kColours{{kMaterials[0], {255, 160, 48}}};  // surface, needs supports
constexpr std::uint32_t kColumns = 350, kRows = 560;                     ///< pixels of a view
constexpr std::uint32_t kStep = 372;                                     ///< from one view to the next
constexpr std::int64_t kLeft = 58, kFloor = 670;

constexpr std::array<Rgb, 2> kSidesOfScan{{kMaterials[0], {96, 108, 122}}};  // of its surface: outside, inside
constexpr std::uint32_t kMostOfPage = 1U << 19U;                             ///< points that are drawn
constexpr std::uint32_t kMostOfProposal = 1U << 17U, kMostOfScan = 1U << 15U;

/// Room for a depth map.
Expected<MapMemory> take_map(std::uint32_t columns, std::uint32_t rows, Arena& arena) {
  const std::size_t samples = std::size_t{columns} * rows;
  const auto depths = arena.take_top<float>(2 * samples, kStage);
  PLUMBLINE_TRY(depths);
  const auto materials = arena.take_top<std::uint8_t>(samples, kStage);
  PLUMBLINE_TRY(materials);
  return MapMemory{{depths->first(samples), *materials, columns, rows}, depths->last(samples)};
}

/// What the pictures of one cloud share.
struct Studio {
  DrawnPoints points;
  MapMemory memory;

  /// @param columns, rows  of the largest view, pixels
  /// @param arena          given back by the caller
  static Expected<Studio> set_up(const Cloud& cloud, std::uint32_t most, std::uint32_t columns, std::uint32_t rows,
                                 Arena& arena) {
    const auto memory = take_map(columns * kSamplesPerPixel, rows * kSamplesPerPixel, arena);
    PLUMBLINE_TRY(memory);
    const auto points = DrawnPoints::create(cloud, most, arena);
    PLUMBLINE_TRY(points);
    return Studio{*points, *memory};
  }

  /// The largest scale at which each of some views fits the map.
  template <class Views, class Degrees>
  double scale(const Views& views, const Degrees& degrees) const {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& view : views)
      least = std::min(least, DrawnPoints::scale(points.box(rotation(degrees(view))), memory.map));
    return least;
  }

  /// What needs supports is the second material.
  void draw(const std::array<double, 2>& degrees, double scale) const {
    const auto needs_support = [](const Vec3d& normal) { return normal[2] < -static_cast<double>(kNeedsSupport); };
    const Mat3d turned = rotation(degrees);
    points.draw(turned, points.box(turned), scale, memory, needs_support);
  }

  static Mat3d rotation(const std::array<double, 2>& degrees) { return rotation_matrix({degrees[0], degrees[1], 0}); }
};

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

Expected<std::span<const std::byte>> encode_orientations(const Cloud& cloud, std::string_view name,
                                                         std::span<const OrientationView> views, Arena& arena,
                                                         PictureEncoder& encoder) {
  const ArenaScope scope(arena);
  const auto rgb = arena.take_top<std::uint8_t>(kPageBytes, kStage);
  PLUMBLINE_TRY(rgb);
  const Picture picture{*rgb, kPreviewColumns, kPreviewRows};
  const auto studio = Studio::set_up(cloud, kMostOfPage, kColumns, kRows, arena);
  PLUMBLINE_TRY(studio);
  draw_background(picture);
  const LabelStyle title{page_faces().title, kInk};
  const LabelStyle plain{page_faces().plain, kInk};
  draw_text(picture, kLeft, 38, title.face.start_of(name, kPreviewColumns - 700), title);
  constexpr std::string_view kAbout = "the best orientations; what needs supports is orange";
  draw_text(picture, std::int64_t{kPreviewColumns} - kLeft - plain.face.width(kAbout), 52, kAbout, plain);

  const double scale = studio->scale(views, [](const OrientationView& view) { return view.degrees; });
  std::int64_t left = kLeft;
  for (const OrientationView& view : views) {
    studio->draw(view.degrees, scale);
    shade_depth(studio->memory.map, studio->memory.scratch, picture, left, kFloor - kRows, kColours);
    std::int64_t line = kFloor + 30;
    for (const std::string_view text : view.lines) {
      draw_text(picture, left, line, plain.face.start_of(text, kStep - 12), plain);
      line += 30;
    }
    left += kStep;
  }
  return encoder.encode(*rgb, kPreviewColumns, kPreviewRows);
}

Status draw_proposal_pictures(const Cloud& cloud, std::span<const std::array<double, 2>> degrees, Arena& arena,
                              ProposalPictures& pictures) {
  for (ProposalPicture& picture : pictures) picture.clear();
  const ArenaScope scope(arena);
  const auto studio =
      Studio::set_up(cloud, kMostOfProposal, ProposalPicture::kMostColumns, ProposalPicture::kMostRows, arena);
  PLUMBLINE_TRY(studio);
  const double scale = studio->scale(degrees, std::identity());
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    studio->draw(degrees[i], scale);
    fill_in(pictures[i], studio->memory, kColours);
  }
  return {};
}

Status draw_scan_picture(const Cloud& cloud, Arena& arena, ScanPicture& picture) {
  picture.clear();
  const ArenaScope scope(arena);
  const auto studio = Studio::set_up(cloud, kMostOfScan, ScanPicture::kMostColumns, ScanPicture::kMostRows, arena);
  PLUMBLINE_TRY(studio);
  const auto& [points, memory] = *studio;
  constexpr int kSides = 8;
  const auto rotation = [](int side) -> Mat3d {
    constexpr double kAbove = 20;
    return rotation_matrix({kAbove, 0, 0}) * rotation_matrix({0, 0, side * 45.0});
  };
  const auto draw = [&, &points = points, &memory = memory](int side, double scale) {
    const auto faces_away = [](const Vec3d& normal) { return normal[1] > 0.1; };
    const Mat3d turned = rotation(side);
    points.draw(turned, points.box(turned), scale, memory, faces_away);
  };
  double scale = std::numeric_limits<double>::infinity();
  for (int side = 0; side < kSides; ++side) {
    scale = std::min(scale, DrawnPoints::scale(points.box(rotation(side)), memory.map));
  }
  int best = 0;
  std::size_t most = 0;
  for (int side = 0; side < kSides; ++side) {
    draw(side, scale);
    const DepthMap& map = memory.map;
    std::size_t seen = 0;
    for (std::size_t i = 0; i < map.depth.size(); ++i) {
      if (map.depth[i] < DepthMap::kEmpty && map.material[i] == 0) ++seen;
    }
    // Others must be clearly better than the front.
    if (seen <= most + most / 20) continue;
    most = seen;
    best = side;
  }
  draw(best, DrawnPoints::scale(points.box(rotation(best)), memory.map));
  fill_in(picture, memory, kSidesOfScan);
  return {};
}

}  // namespace plumbline::firmware::inline pictures
