#pragma once
/// Tips that a person has placed, and where no others may be.

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "slicer/core/bit_image.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/supports/drawing/disc.hpp"
#include "slicer/supports/support_settings.hpp"

namespace plumbline::inline slicer {

class PlacedTips {
 public:
  /// Where the tip of a place goes: the lowest pixel that faces down within kPlaceReach of its height, in its own column or else in the
  /// nearest one within 0.5 mm.
  struct Surface {
    Nanometres away = std::numeric_limits<Nanometres>::max();  ///< from the place's column, squared
    std::uint32_t column = 0, row = 0, layer = 0;              ///< layer 0: there is none
  };

  /// @param settings  outlives this
  PlacedTips(const SupportSettings& settings, const PrintGrid& grid)
      : settings_(&settings), grid_(grid), pitch_(grid) {}

  bool empty() const { return settings_->added.all().empty(); }
  /// Looks for surfaces in a layer. Layers come in order.
  /// @param layer  of the print, 1 or more
  /// @param below  the mask of the layer below
  void look_at(std::uint32_t layer, ConstBitImage mask, ConstBitImage below);
  /// Of settings.added, in its order.
  std::span<const Surface> surfaces() const { return std::span(surfaces_).first(settings_->added.all().size()); }
  /// Bit i: there is no surface at settings.added.list[i].
  std::uint32_t missed() const;
  /// Whether a ball of settings.blocked holds a pixel's middle on the underside of a layer.
  bool is_blocked(std::uint32_t column, std::uint32_t row, std::uint32_t layer) const;

 private:
  const SupportSettings* settings_;
  PrintGrid grid_;
  PixelPitch pitch_;
  std::array<Surface, std::tuple_size_v<decltype(SupportPlaces::list)>> surfaces_{};
};

}  // namespace plumbline::inline slicer
