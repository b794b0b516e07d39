#include "firmware/canvas/glyph_raster.hpp"

#include <algorithm>
#include <cstddef>
#include <span>

namespace plumbline {
namespace {

/// Parts of a pixel.
constexpr std::int64_t kPixel = 256;
constexpr int kLines = 8;
/// Levels of cover above 0. Nobody sees the difference to 255, and a picture of a screen has few colours, so that its PNG is small.
constexpr std::uint32_t kLevels = 15;
/// Straight pieces of a curve: a letter 100 pixels high has corners of less than a tenth of a pixel.
constexpr int kPieces = 8;

struct Point {
  std::int64_t x = 0, y = 0;  ///< parts of a pixel, y down
};

struct Edge {
  Point from, to;
};

/// @pre b is not 0
std::int64_t floor_div(std::int64_t a, std::int64_t b) {
  if (b < 0) return floor_div(-a, -b);
  return a >= 0 ? a / b : -((-a + b - 1) / b);
}

class Outline {
 public:
  void line_to(const Point& to) {
    if (to.y != at_.y) edges.push_back({at_, to});
    at_ = to;
  }
  void curve_to(const Point& control, const Point& to) {
    const Point from = at_;
    for (std::int64_t i = 1; i <= kPieces; ++i) {
      const std::int64_t a = (kPieces - i) * (kPieces - i), b = 2 * i * (kPieces - i), c = i * i;
      constexpr std::int64_t kSum = std::int64_t{kPieces} * kPieces;
      line_to({floor_div(a * from.x + b * control.x + c * to.x, kSum),
               floor_div(a * from.y + b * control.y + c * to.y, kSum)});
    }
  }
  void begin(const Point& at) { at_ = at; }

  std::vector<Edge> edges;

 private:
  Point at_;
};

void add_contour(std::span<const OutlinePoint> contour, std::int64_t x_height, std::int64_t units, Outline& outline) {
  const auto is_corner = [&](std::size_t i) {
    return (contour[i % contour.size()].flags & OutlinePoint::kOnCurve) != 0;
  };
  const auto point = [&](std::size_t i) {
    const OutlinePoint& p = contour[i % contour.size()];
    return Point{floor_div(p.x * x_height * kPixel, units), floor_div(-p.y * x_height * kPixel, units)};
  };
  outline.begin(point(0));
  for (std::size_t i = 1; i <= contour.size(); ++i) {
    if (is_corner(i)) {
      outline.line_to(point(i));
    } else {
      outline.curve_to(point(i), point(i + 1));
      ++i;
    }
  }
}

/// Where an edge crosses a horizontal line, and whether it goes down there.
struct Crossing {
  std::int64_t x = 0;
  int turn = 0;
};

/// Adds what a line has of each pixel between two crossings. @param sums  of the row: kPixel for a whole pixel
void add_run(std::int64_t from, std::int64_t to, std::int64_t left, std::span<std::uint32_t> sums) {
  from -= left * kPixel;
  to -= left * kPixel;
  for (std::int64_t at = from; at < to;) {
    const std::int64_t pixel = floor_div(at, kPixel), end = std::min(to, (pixel + 1) * kPixel);
    sums[static_cast<std::size_t>(pixel)] += static_cast<std::uint32_t>(end - at);
    at = end;
  }
}

}  // namespace

GlyphPicture rasterise(const FontOutlines& font, const GlyphOutline& glyph, int x_height) {
  GlyphPicture picture;
  Outline outline;
  const auto points = font.points.subspan(glyph.first, glyph.count);
  for (std::size_t start = 0, i = 0; i < points.size(); ++i) {
    if ((points[i].flags & OutlinePoint::kLastOfContour) == 0) continue;
    add_contour(points.subspan(start, i + 1 - start), x_height, font.x_height, outline);
    start = i + 1;
  }
  if (outline.edges.empty()) return picture;
  Point low = outline.edges[0].from, high = low;
  for (const Edge& edge : outline.edges) {
    for (const Point& p : {edge.from, edge.to}) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
  }
  picture.left = static_cast<int>(floor_div(low.x, kPixel));
  picture.top = static_cast<int>(floor_div(low.y, kPixel));
  picture.columns = static_cast<int>(floor_div(high.x, kPixel)) + 1 - picture.left;
  picture.rows = static_cast<int>(floor_div(high.y, kPixel)) + 1 - picture.top;
  std::vector<std::uint32_t> sums;
  std::vector<Crossing> crossings;
  for (int row = 0; row < picture.rows; ++row) {
    sums.assign(static_cast<std::size_t>(picture.columns), 0);
    for (int line = 0; line < kLines; ++line) {
      const std::int64_t y = (picture.top + row) * kPixel + (2 * line + 1) * kPixel / (2 * kLines);
      crossings.clear();
      for (const auto& [from, to] : outline.edges) {
        const bool down = to.y > from.y;
        if (y < std::min(from.y, to.y) || y >= std::max(from.y, to.y)) continue;
        crossings.push_back({from.x + floor_div((to.x - from.x) * (y - from.y), to.y - from.y), down ? 1 : -1});
      }
      std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) { return a.x < b.x; });
      int winding = 0;
      for (std::size_t i = 0; i + 1 < crossings.size(); ++i) {
        winding += crossings[i].turn;
        if (winding != 0) add_run(crossings[i].x, crossings[i + 1].x, picture.left, sums);
      }
    }
    for (const std::uint32_t sum : sums) {
      const auto level = static_cast<std::uint8_t>((sum * kLevels + kLines * kPixel / 2) / (kLines * kPixel));
      picture.cover.push_back(static_cast<std::uint8_t>(level * (255 / kLevels)));
    }
  }
  return picture;
}

}  // namespace plumbline
