#pragma once
/// Islands and overhangs by brute force: flood fill and distances, sharing no code with the supports.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "slicer/supports/drawing/supports.hpp"
#include "tests/slicer/support/pixels.hpp"

namespace plumbline::testing {

/// Islands: regions of pixels joined at their sides, none of which is above a pixel of the layer below. Layer 0 has none.
inline std::uint32_t floating_islands(const std::vector<Pixels>& masks) {
  std::uint32_t islands = 0;
  for (std::size_t k = 1; k < masks.size(); ++k) {
    const Pixels& mask = masks[k];
    Pixels seen(mask.columns(), mask.rows());
    for (std::uint32_t r = 0; r < mask.rows(); ++r) {
      for (std::uint32_t c = 0; c < mask.columns(); ++c) {
        if (!mask.at(c, r) || seen.at(c, r)) continue;
        bool held = false;
        std::vector<std::pair<std::int64_t, std::int64_t>> open{{c, r}};
        seen.set(c, r, true);
        while (!open.empty()) {
          const auto [x, y] = open.back();
          open.pop_back();
          held |= masks[k - 1].at(x, y);
          for (const auto& [nx, ny] :
               {std::pair{x + 1, y}, std::pair{x - 1, y}, std::pair{x, y + 1}, std::pair{x, y - 1}}) {
            if (!mask.at(nx, ny) || seen.at(nx, ny)) continue;
            seen.set(static_cast<std::uint32_t>(nx), static_cast<std::uint32_t>(ny), true);
            open.emplace_back(nx, ny);
          }
        }
        islands += held ? 0 : 1;
      }
    }
  }
  return islands;
}

/// The farthest that a pixel overhangs when its layer is cured, in pixels.
///
///   hang_k(p) = max(0, min over q of hang_(k-1)(q) + |p - q| - growth),   0 in layer 0 and at a tip,
///                                                                         |p - t| at most beside a tip t
/// The minimum is over the pixels q of the layer below. A pixel's overhang is the length of the path down and sideways
/// to a held pixel, less what a surface at the critical angle may advance in each layer.
/// @param masks   of the object, without supports
/// @param growth  pixels
/// @param most    pixels; larger overhangs are reported as this
inline double farthest_hang(const std::vector<Pixels>& masks, std::span<const Strut> struts, double growth, int most) {
  const auto columns = static_cast<int>(masks[0].columns());
  const auto rows = static_cast<int>(masks[0].rows());
  std::vector<double> below(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), most);
  std::vector<double> here(below.size());
  const auto at = [&](std::vector<double>& field, int c, int r) -> double& {
    return field[static_cast<std::size_t>(r) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(c)];
  };
  double farthest = 0;
  for (std::size_t k = 0; k < masks.size(); ++k) {
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) {
        double& hang = at(here, c, r);
        hang = k == 0 ? 0 : most;
        if (!masks[k].at(c, r) || k == 0) continue;
        for (int y = std::max(0, r - most); y <= std::min(rows - 1, r + most); ++y) {
          for (int x = std::max(0, c - most); x <= std::min(columns - 1, c + most); ++x) {
            if (!masks[k - 1].at(x, y)) continue;
            const int dx = x - c;
            const int dy = y - r;
            hang = std::min(hang, at(below, x, y) + std::sqrt(dx * dx + dy * dy) - growth);
          }
        }
        for (const Strut& tip : struts) {
          if (tip.kind != StrutKind::kTip || tip.first != k) continue;
          const int dx = tip.column0 - c;
          const int dy = tip.row0 - r;
          hang = std::min(hang, std::sqrt(static_cast<double>(dx * dx + dy * dy)));
        }
        hang = std::max(0.0, hang);
        if (!masks[k - 1].at(c, r)) farthest = std::max(farthest, hang);
      }
    }
    std::swap(here, below);
  }
  return farthest;
}

}  // namespace plumbline::testing
