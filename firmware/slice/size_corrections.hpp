#pragma once
/// What was done so that a print gets its true size.

#include <array>

#include "firmware/io/text/fixed_text.hpp"
#include "slicer/slice_settings.hpp"

namespace plumbline::firmware {

class JsonWriter;

/// Stored byte for byte.
struct SizeCorrections {
  std::array<double, 3> size = {1, 1, 1};  ///< PlacementSettings::correction
  double absolute_mm = 0;                  ///< SliceSettings::absolute_correction_mm

  Vec3d relative() const { return {size[0], size[1], size[2]}; }
  bool any() const { return *this != SizeCorrections(); }
  /// "masks 1.01, 1.01, 1 times as large in x, y, z; outlines moved by -0.02 mm"; empty if nothing is corrected.
  FixedText<160> text() const;
  bool operator==(const SizeCorrections&) const = default;
};

SizeCorrections corrections_of(const SliceSettings& settings);

/// Writes the members "size_correction" and "absolute_correction_mm".
void write_corrections(JsonWriter& json, const SizeCorrections& corrections);

}  // namespace plumbline::firmware
