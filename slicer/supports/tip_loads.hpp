#pragma once
/// The overhang that each tip carries.

#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/supports/drawing/disc.hpp"
#include "slicer/supports/support_settings.hpp"
#include "slicer/supports/tips.hpp"

namespace plumbline::inline slicer {

/// Tips by their place, in square cells, so that the nearest to a pixel is found in nine of them.
class TipLoads {
 public:
  static constexpr std::uint32_t kMostPixels = 16;  ///< that carry() takes at once

  TipLoads() = default;
  /// @param list  of all tips, those to come included; must outlive this
  /// @retval ErrorCode::kOutOfMemory  bytes_needed() from the top of the arena
  [[nodiscard]] static Expected<TipLoads> create(const PrintGrid& grid, const SupportSettings& settings,
                                                 std::span<Tip> list, Arena& arena);
  static std::size_t bytes_needed(const PrintGrid& grid, std::size_t tips);

  /// Adds list[tip], which must be higher than none of those added later.
  void add(std::uint32_t tip);

  /// Gives `pixels` of overhang in `layer`, round (column, row), to the nearest tip.
  /// @returns that tip if it had its full load already, so that another one is needed here
  const Tip* carry(std::uint32_t column, std::uint32_t row, std::uint32_t layer, std::uint32_t pixels);

 private:
  static constexpr std::uint32_t kNone = ~0U;

  std::span<Tip> list_;
  std::span<std::uint32_t> head_;  ///< by cell: its last tip
  std::span<std::uint32_t> next_;  ///< by tip: the one before it in its cell
  PixelPitch pitch_;
  std::uint32_t cell_ = 1;  ///< pixels
  std::uint32_t cells_x_ = 1, cells_y_ = 1;
  std::uint32_t most_ = 1;            ///< pixels that a tip carries
  std::uint32_t most_of_island_ = 1;  ///< if it is dense
  std::uint32_t layers_ = 1;          ///< below: a tip farther down carries nothing here
  Nanometres apart_ = 0;              ///< least distance of tips
  std::uint32_t reserve_ = 0;         ///< pixels of overhang that may come nearer than that
};

}  // namespace plumbline::inline slicer
