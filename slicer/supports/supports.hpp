#pragma once
/// The supports of a print: a short list, and their common shape.

#include <cstdint>
#include <span>

#include "slicer/core/print_grid.hpp"
#include "slicer/supports/disc.hpp"
#include "slicer/supports/support_settings.hpp"

namespace plumbline {

/// A vertical round support with its axis through the centre of a pixel.
struct Support {
  std::uint16_t column = 0;
  std::uint16_t row = 0;
  std::uint16_t first = 0;  ///< lowest layer. 0: on the plate; else on the object or a support
  std::uint16_t tip = 0;    ///< first layer of the object above it
  std::uint16_t end = 0;    ///< layer after the last of its head; at least `tip`

  bool on_plate() const { return first == 0; }
  bool is_in(std::uint32_t layer) const { return first <= layer && layer < end; }
  bool operator==(const Support&) const = default;
};

/// Radii of supports. They are integers, so discs are the same on all machines.
class SupportShape {
 public:
  SupportShape() = default;
  /// @param settings  that check_support_settings() takes
  SupportShape(const SupportSettings& settings, const PrintGrid& grid);

  /// Radius of the disc of `support` in `layer`, nm, at the layer's middle: the smallest of the cone below the tip, the pillar,
  /// and the cone above a foot on the object or a support; or that of the base on the plate, if larger. A base is at most a
  /// third as high as its support.
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
