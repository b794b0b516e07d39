#include "slicer/supports/tip_loads.hpp"

#include <algorithm>
#include <cmath>

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "supports";
/// mm; tips are at most about 2 mm apart.
constexpr double kCell = 2;
/// mm in height over which an overhang still hangs from a tip.
constexpr double kHangs = 3;

/// A tip of an island carries at most so many times a light tip's area. Of less than a sixteenth held, a region is an island to UVtools
/// and slicer/checks.
constexpr double kIslandShare = 10;
/// Of a tip's load, at most, that is kept for overhang too near for another tip.
constexpr double kMostReserve = 0.8;
constexpr double kPi = 3.14159265358979324;

std::uint32_t cell_pixels(const PrintGrid& grid) {
  const double pitch = std::max(static_cast<double>(grid.pitch_x_mm), static_cast<double>(grid.pitch_y_mm));
  return static_cast<std::uint32_t>(std::max(1.0, std::floor(kCell / pitch)));
}
std::uint32_t cells(std::uint32_t pixels, std::uint32_t cell) { return pixels / cell + 1; }

}  // namespace

Expected<TipLoads> TipLoads::create(const PrintGrid& grid, const SupportSettings& settings, std::span<Tip> list,
                                    Arena& arena) {
  TipLoads loads;
  loads.list_ = list;
  loads.pitch_ = PixelPitch(grid);
  loads.cell_ = cell_pixels(grid);
  loads.cells_x_ = cells(grid.columns, loads.cell_);
  loads.cells_y_ = cells(grid.rows, loads.cell_);
  const double pixel = static_cast<double>(grid.pitch_x_mm) * static_cast<double>(grid.pitch_y_mm);
  loads.most_ = static_cast<std::uint32_t>(std::clamp(settings.area_per_tip / pixel, 1.0, 4e9));
  const double light = settings.head_front_diameter * kLightTip;
  loads.most_of_island_ =
      static_cast<std::uint32_t>(std::clamp(kIslandShare * kPi / 4 * light * light / pixel, 1.0, 4e9));
  loads.layers_ = static_cast<std::uint32_t>(std::ceil(kHangs / static_cast<double>(grid.layer_height_mm)));
  loads.apart_ = nanometres(settings.points_minimal_distance);
  // No tip can relieve another one this near, so every tip keeps room for what may come there.
  const double near = kPi * settings.points_minimal_distance * settings.points_minimal_distance / pixel;
  loads.reserve_ = static_cast<std::uint32_t>(std::min(near, loads.most_ * kMostReserve));
  const auto head = arena.take_top<std::uint32_t>(std::size_t{loads.cells_x_} * loads.cells_y_, kStage);
  PLUMBLINE_TRY(head);
  const auto next = arena.take_top<std::uint32_t>(list.size(), kStage);
  PLUMBLINE_TRY(next);
  loads.head_ = *head;
  loads.next_ = *next;
  std::fill(loads.head_.begin(), loads.head_.end(), kNone);
  return loads;
}

std::size_t TipLoads::bytes_needed(const PrintGrid& grid, std::size_t tips) {
  const std::uint32_t cell = cell_pixels(grid);
  return Arena::rounded(std::size_t{cells(grid.columns, cell)} * cells(grid.rows, cell) * sizeof(std::uint32_t)) +
         Arena::rounded(tips * sizeof(std::uint32_t));
}

void TipLoads::add(std::uint32_t tip) {
  std::uint32_t& head = head_[std::size_t{list_[tip].row / cell_} * cells_x_ + list_[tip].column / cell_];
  next_[tip] = head;
  head = tip;
}

const Tip* TipLoads::carry(std::uint32_t column, std::uint32_t row, std::uint32_t layer, std::uint32_t pixels) {
  std::uint32_t nearest = kNone;
  Nanometres least = 0;
  const std::uint32_t x = column / cell_;
  const std::uint32_t y = row / cell_;
  for (std::uint32_t cy = y - std::min(y, 1U); cy <= std::min(y + 1, cells_y_ - 1); ++cy) {
    for (std::uint32_t cx = x - std::min(x, 1U); cx <= std::min(x + 1, cells_x_ - 1); ++cx) {
      for (std::uint32_t i = head_[std::size_t{cy} * cells_x_ + cx]; i != kNone; i = next_[i]) {
        const Tip& tip = list_[i];
        if (tip.layer + layers_ < layer) break;  // those before it are lower still
        const Nanometres dx = (Nanometres{tip.column} - column) * pitch_.x;
        const Nanometres dy = (Nanometres{tip.row} - row) * pitch_.y;
        const Nanometres apart = dx * dx + dy * dy;
        if (nearest != kNone && (apart > least || (apart == least && i > nearest))) continue;
        nearest = i;
        least = apart;
      }
    }
  }
  if (nearest == kNone) return nullptr;
  Tip& tip = list_[nearest];
  if (least < apart_ * apart_) {
    tip.close += pixels;
  } else if ((tip.dense && tip.load + pixels > most_of_island_) ||
             tip.load + pixels + reserve_ - std::min(reserve_, tip.close) > most_) {
    return &tip;
  }
  tip.load += pixels;
  return nullptr;
}

}  // namespace plumbline::inline slicer
