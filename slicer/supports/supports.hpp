#pragma once
/// The supports of a print: a short list, and the shape that all of them have.

#include <cstdint>
#include <span>

#include "slicer/core/print_grid.hpp"
#include "slicer/supports/disc.hpp"
#include "slicer/supports/support_settings.hpp"

namespace plumbline {

/// One support: upright, round, its axis through the centre of a pixel.
struct Support {
  std::uint16_t column = 0;
  std::uint16_t row = 0;
  std::uint16_t first = 0;  ///< lowest layer that it is in. 0: on the plate; else it stands on the object or a support
  std::uint16_t tip = 0;    ///< first layer of the object above it
  std::uint16_t end = 0;    ///< past the last layer that its head reaches into; tip or more

  bool on_plate() const { return first == 0; }
  bool is_in(std::uint32_t layer) const { return first <= layer && layer < end; }
  bool operator==(const Support&) const = default;
};

/// How thick supports are. Their discs are made of integers, so they are the same everywhere.
class SupportShape {
 public:
  SupportShape() = default;
  /// @param settings  that check_support_settings() takes
  SupportShape(const SupportSettings& settings, const PrintGrid& grid);

  /// Of the disc that `support` is in `layer`, nm: at the layer's middle, the narrowest of the cone below its tip, the
  /// pillar, and the cone above its foot on something else; or the base on the plate, where that is wider. A base is never
  /// taller than a third of its support.
  Nanometres radius(const Support& support, std::uint32_t layer) const;

  Nanometres head_radius() const { return head_; }
  Nanometres pillar_radius() const { return pillar_; }
  std::uint32_t penetration() const { return penetration_; }  ///< layers
  const PixelPitch& pitch() const { return pitch_; }

 private:
  Nanometres cone(Nanometres height) const { return head_ + (pillar_ - head_) * height / head_width_; }

  PixelPitch pitch_;
  Nanometres layer_height_ = 1;
  Nanometres head_ = 0, pillar_ = 0, base_ = 0;  ///< radii
  Nanometres head_width_ = 1, base_height_ = 0;
  std::uint32_t penetration_ = 0;
};

struct Supports {
  std::span<const Support> list;  ///< by first layer; the arena's
  SupportShape shape;

  bool empty() const { return list.empty(); }
};

}  // namespace plumbline
