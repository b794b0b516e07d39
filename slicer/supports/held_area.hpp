#pragma once
/// What of a layer is held from below, and how far the rest is from it.

#include <cstdint>

#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/supports/near.hpp"
#include "slicer/supports/support_settings.hpp"
#include "slicer/supports/window.hpp"

namespace plumbline {

/// The held pixels of a layer, made from those of the layer below.
///
/// They are those of the layer below, as far as the object goes on above them, and what is within
///   g = layer_height / tan(critical_angle)
/// of them; with tips' discs, and with all pixels that the object has had for reach() / g layers. What is new and farther
/// than reach() from all of them is not held.
///
/// g is a few pixels, or less than one: the area grows by single pixels, in each layer by as many as make g on the whole.
/// Some of these steps go to the four neighbours of a pixel, the others to all eight, in the ratio that makes an octagon
/// (Rosenfeld and Pfaltz 1968): it is round to 8 %.
class HeldArea {
 public:
  HeldArea() = default;
  /// @param window  where masks have pixels
  /// @retval ErrorCode::kOutOfMemory  bytes_needed() from the top of the arena
  [[nodiscard]] static Expected<HeldArea> create(const PrintGrid& grid, const SupportSettings& settings,
                                                 const Window& window, Arena& arena);
  static std::size_t bytes_needed(const PrintGrid& grid);

  /// The first layer: the plate holds all of it.
  void begin(ConstBitImage mask);
  /// The next one, before its tips are known.
  void next_layer(std::uint32_t layer, ConstBitImage mask);
  /// A tip holds what it meets.
  void add_disc(std::uint32_t column, std::uint32_t row, Nanometres radius, ConstBitImage mask);

  /// Of `fresh`, leaves what is farther than reach() from all that is held.
  void drop_what_is_near(BitImage fresh) const;

  Nanometres reach() const { return reach_; }  ///< half of the longest bridge

 private:
  void grow(std::uint32_t layer, ConstBitImage mask);
  void grow_one(bool columns, bool rows, bool corners, ConstBitImage mask);

  Window window_;
  PixelPitch pitch_;
  Nanometres reach_ = 0;
  Nanometres growth_ = 1;            ///< g
  std::uint32_t settle_layers_ = 1;  ///< after which what is there is held
  std::uint64_t steps_ = 0;          ///< in both directions, up to now
  Disc bridge_;
  BitImage held_;
  BitImage settling_;  ///< what all layers have had since the last multiple of settle_layers_
  BitImage grown_;     ///< scratch
};

}  // namespace plumbline
