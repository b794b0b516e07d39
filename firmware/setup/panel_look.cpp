#include "firmware/setup/panel_look.hpp"

#include <algorithm>
#include <cmath>

namespace plumbline::firmware {
namespace {

using Mirror = PanelLayout::Mirror;

struct PanelTurn {
  std::uint32_t rotation_deg;
  Mirror mirror;
};
/// Each way a picture can be turned and mirrored, once. The plainest come first.
constexpr std::array<PanelTurn, 8> kOrientations = {{{0, Mirror::kNone},
                                                     {0, Mirror::kX},
                                                     {0, Mirror::kY},
                                                     {180, Mirror::kNone},
                                                     {90, Mirror::kNone},
                                                     {270, Mirror::kNone},
                                                     {90, Mirror::kX},
                                                     {90, Mirror::kY}}};

/// Corner k of a picture of 2 x 2 pixels, clockwise from the upper left.
constexpr std::array<PanelLayout::Pixel, 4> kCorners = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};

std::size_t corner_at(const PanelLayout::Pixel& pixel) {
  return static_cast<std::size_t>(std::find(kCorners.begin(), kCorners.end(), pixel) - kCorners.begin());
}

}  // namespace

std::uint32_t square_side(std::uint32_t columns, std::uint32_t rows) {
  // Seven sides for four squares and the gaps between them, one to the corner, and as much again to the middle.
  return std::max(1U, std::min(columns, rows) / 18);
}

void draw_corners(BitImage picture) {
  picture.clear();
  const std::uint32_t side = square_side(picture.columns(), picture.rows());
  for (std::size_t corner = 0; corner < 4; ++corner) {
    const bool right = kCorners[corner].column == 1, below = kCorners[corner].row == 1;
    for (std::uint32_t square = 0; square < kSentCorners[corner]; ++square) {
      for (std::uint32_t y = 0; y < side; ++y) {
        for (std::uint32_t x = 0; x < side; ++x) {
          const std::uint32_t column = side * (1 + 2 * square) + x, row = side + y;
          if (column >= picture.columns() || row >= picture.rows()) continue;
          picture.set(right ? picture.columns() - 1 - column : column, below ? picture.rows() - 1 - row : row);
        }
      }
    }
  }
}

CornerSquares squares_in(ConstBitImage picture) {
  std::array<std::uint64_t, 4> pixels{};
  for (std::uint32_t row = 0; row < picture.rows(); ++row) {
    for (std::uint32_t column = 0; column < picture.columns(); ++column) {
      if (!picture.at(column, row)) continue;
      ++pixels[corner_at({column * 2 / picture.columns(), row * 2 / picture.rows()})];
    }
  }
  const double area = std::pow(square_side(picture.columns(), picture.rows()), 2);
  CornerSquares squares{};
  for (std::size_t i = 0; i < 4; ++i) {
    squares[i] = static_cast<unsigned>(std::lround(static_cast<double>(pixels[i]) / area));
  }
  return squares;
}

Expected<PanelLayout> layout_for(const PanelLayout& sent, const CornerSquares& seen) {
  for (const PanelTurn& one : kOrientations) {
    // Corner k of the mask goes to corner `to` of the picture that is sent, and whoever looks must see it with left and right swapped.
    const PanelLayout small{2, 2, one.rotation_deg, one.mirror, false};
    const bool fits = std::all_of(kCorners.begin(), kCorners.end(), [&](const PanelLayout::Pixel& corner) {
      const unsigned squares = kSentCorners[corner_at(small.sent(corner))];
      return seen[corner_at({1 - corner.column, corner.row})] == squares;
    });
    if (!fits) continue;
    const bool sideways = one.rotation_deg % 180 != 0;
    return PanelLayout{sideways ? sent.rows : sent.columns, sideways ? sent.columns : sent.rows, one.rotation_deg,
                       one.mirror, sent.rgb};
  }
  return fail(
      ErrorCode::kBadSetting,
      "no panel shows the corners as %u %u %u %u: going round, each corner has one square more than the one before "
      "or after it, and 1 follows 4. Look again",
      seen[0], seen[1], seen[2], seen[3]);
}

}  // namespace plumbline::firmware
