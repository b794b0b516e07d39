#pragma once
/// A part of the print that did not stay.

#include <cstdint>
#include <string>

namespace plumbline::inline hal::inline sim {

enum class LossKind : std::uint8_t {
  kDropped,   ///< a region that touches nothing held
  kTorn,      ///< a piece that the film holds more strongly than the part does
  kShadowed,  ///< what lies on the film kept light from the part
};

struct Loss {
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  LossKind kind = LossKind::kDropped;
  /// Index of the loss that this one, dropped too, has become part of: its volume is there.
  std::uint32_t joined = kNone;
  std::uint32_t layer = 0;       ///< where it began, 0-based
  std::uint32_t last_layer = 0;  ///< that it has taken something from
  double x_mm = 0, y_mm = 0;     ///< from the panel's corner; middle of the region's widest row in `layer`
  std::uint64_t pixels = 0;      ///< of the region in `layer`
  /// Volume that the masks asked for and the part has not. Of a dropped region, until it would have met the part; of a torn piece,
  /// with all that would have hung from it; of a shadow, where the rest of the region stayed.
  double ml = 0;
  double asked_n = 0, held_n = 0;  ///< of a torn piece: the force of the peel, and what held against it
};

/// "1.234 ml at (12.3, 45.6) mm, layers 40 to 52"
std::string to_string(const Loss& loss);

}  // namespace plumbline::inline hal::inline sim
