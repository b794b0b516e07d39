#pragma once
/// What a simulated printer knows of the part it made.

#include <cstdint>
#include <string_view>
#include <vector>

namespace plumbline::firmware {

/// Something that the masks asked for and the part has not.
struct LostPiece {
  std::string_view kind;  ///< "region dropped", ...: the objection's
  std::uint32_t layer = 0, last_layer = 0;
  double x_mm = 0, y_mm = 0;  ///< from the panel's corner
  double ml = 0;
};

struct PartFigures {
  double largest_peel_n = 0;  ///< of any layer
  double suction_cm2 = 0;     ///< largest area of sealed cavities that a layer was peeled with
  std::uint32_t traps = 0;    ///< closed cavities
  double trapped_ml = 0;      ///< resin in them
  double bleed_ml = 0;        ///< cured below down-facing surfaces by light beyond a layer
  std::vector<LostPiece> lost;

  double lost_ml() const {
    double sum = 0;
    for (const LostPiece& piece : lost) sum += piece.ml;
    return sum;
  }
};

}  // namespace plumbline::firmware
