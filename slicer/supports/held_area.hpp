#pragma once
/// Tracks which pixels of a layer are held from below.

#include <cstdint>

#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/bit_spans.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/supports/near.hpp"
#include "slicer/supports/support_settings.hpp"
#include "slicer/supports/window.hpp"

namespace plumbline::inline slicer {

/// The held pixels of a layer, made from those of the layer below.
///
/// A pixel of the object is held if it lies
///   - above a held pixel, or within g = layer_height / tan(overhang_angle) of one that continues;
///   - in a tip's disc;
///   - where the object has been for reach() / g layers.
/// New pixels farther than reach() from all held ones need a support.
///
/// g is a few pixels or less than one, so the area grows in steps of one pixel, as many per layer as add up to g over the
/// layers. Some steps go to the four neighbours, the others to all eight, in the ratio that makes an octagon (Rosenfeld and
/// Pfaltz 1968), which is round to 8 %.
class HeldArea {
 public:
  HeldArea() = default;
  /// @retval ErrorCode::kOutOfMemory  bytes_needed() from the top of the arena
  [[nodiscard]] static Expected<HeldArea> create(const PrintGrid& grid, const SupportSettings& settings, Arena& arena);
  static std::size_t bytes_needed(const PrintGrid& grid);

  /// Starts with the first layer, all of which the plate holds.
  void begin(ConstBitImage mask);
  /// Goes to the next layer, before its tips are known.
  /// @param window  holds all pixels of `mask` and of the mask below
  void next_layer(std::uint32_t layer, ConstBitImage mask, const Window& window);
  /// A tip holds the pixels of its disc.
  void add_disc(std::uint32_t column, std::uint32_t row, Nanometres radius, ConstBitImage mask);

  /// Pixels [begin, end) of a row are held.
  void add_run(std::uint32_t row, std::uint32_t begin, std::uint32_t end) { fill(held_, row, begin, end, true); }

  /// A pixel is left out of the layer.
  void take_out(std::uint32_t column, std::uint32_t row);

  /// Clears the pixels of `fresh` that are within reach() of a held one.
  /// @param marks  of each row of `fresh`: its words that may have pixels
  void drop_what_is_near(BitImage fresh, ConstBitImage marks) const;

  /// Of `pixels` in a word of a row, those that are not held.
  std::uint64_t unheld(std::uint32_t row, std::uint32_t word, std::uint64_t pixels) const;

  Nanometres reach() const { return reach_; }  ///< half of the longest bridge

 private:
  void grow(std::uint32_t layer, ConstBitImage mask);
  void grow_one(bool columns, bool rows, bool corners, ConstBitImage mask);

  Window window_;  ///< of the layer
  PixelPitch pitch_;
  Nanometres reach_ = 0;
  Nanometres growth_ = 1;            ///< g
  std::uint32_t settle_layers_ = 1;  ///< a pixel that is there this long is held
  std::uint64_t steps_ = 0;          ///< steps along both axes so far
  Disc bridge_;
  BitImage held_;
  BitImage settling_;  ///< pixels that all layers have had since the last multiple of settle_layers_
  BitImage grown_;     ///< scratch
  BitImage open_;      ///< one row, a bit for each row that may have pixels that are not held
};

}  // namespace plumbline::inline slicer
