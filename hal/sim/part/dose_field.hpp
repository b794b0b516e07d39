#pragma once
/// The light that each place of a part got.

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <span>
#include <vector>

#include "hal/sim/plant/cured_part.hpp"
#include "hal/sim/plant/resin.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/grey_runs.hpp"

namespace plumbline::inline hal::inline sim {

struct DoseModel {
  Resin resin;
  double pitch_x_mm = 0.05, pitch_y_mm = 0.05;  ///< of the panel's pixels
  /// Of an uneven lamp: its light at a place in times that of the doses. Null: 1
  std::function<double(double x_mm, double y_mm)> lamp = nullptr;
  double lamp_at(double x_mm, double y_mm) const { return lamp ? lamp(x_mm, y_mm) : 1; }

  /// Beyond this depth the light of a layer is below kFaintest Ec, and is left out.
  double reach_mm(Dose dose) const;
  static constexpr double kFaintest = 1e-4;
};

/// Dose over a part, mJ/cm2:
///
///     D(x, y, z) = T1 + (1 - e) (T1 + T2 + ... - T1),  Tj = Ej Gj(x, y) exp(-(zj - z) / Dp) for all layers with zj >= z
///
/// T1 is the largest of the terms, Ej the dose of layer j, zj the height of its film, e Resin::exchange. Below its film light fades as
/// Beer and Lambert say, and resin is solid where D >= Ec (P. F. Jacobs, Rapid Prototyping & Manufacturing, 1992, ch. 4). Doses of layers
/// add up as long as the resin stays where it is (e = 0). Gj is the share of the mask's light: its pixels, squares of even light of level / 255,
/// blurred by a Gaussian of sigma s pixels. The weight of a pixel whose middle is u pixels away is the product over both axes of
///
///     w(u) = (erf((u + 1/2) / (s sqrt 2)) - erf((u - 1/2) / (s sqrt 2))) / 2
///
/// Places are mm from the corner of pixel (0, 0), and upwards from the plate; nothing cures in the plate. Holds some layers at a time.
class DoseField {
 public:
  /// @param model  blur_px 0 to kMostBlur
  explicit DoseField(const DoseModel& model);
  /// Of a whole part, which must have kept its pixels. For small ones: takes memory for all layers.
  DoseField(const DoseModel& model, const CuredPart& part);
  static constexpr double kMostBlur = 2;

  /// Adds the light at one height.
  /// @param greys  ascending: pixels that get their level of the dose, whatever their bits say
  void add(const CuredLayer& layer, ConstBitImage mask, std::span<const GreyRun> greys = {});
  /// Gives back the layers whose film is below `z_mm`: from now on at() is right from there upwards.
  void drop_below(double z_mm);

  const DoseModel& model() const { return model_; }
  double at(double x_mm, double y_mm, double z_mm) const;
  /// Where the ray through a pixel's middle enters and leaves cured resin, mm from the plate, in turn. Exact: between two films all light
  /// grows as exp(z / Dp).
  std::vector<double> cured_depths(std::uint32_t column, std::uint32_t row) const;

 private:
  /// The light at one height. The mask's black rim is not kept.
  struct Layer {
    double z_mm = 0;
    double dose = 0;
    double fade = 1;  ///< of its light at the film of the layer before
    std::int64_t first_row = 0, rows = 0, first_word = 0, stride = 0;
    std::vector<std::uint64_t> words;
    std::int64_t columns = 0;  ///< of the mask
    std::vector<GreyRun> greys;

    std::uint64_t word(std::int64_t row, std::int64_t w) const {
      const std::int64_t r = row - first_row, i = w - first_word;
      return r < 0 || r >= rows || i < 0 || i >= stride ? 0 : words[static_cast<std::size_t>(r * stride + i)];
    }
  };
  /// Weights of the pixels near a place, along one axis.
  struct Weights {
    static constexpr unsigned kMost = 18;
    std::int64_t first = 0;
    unsigned count = 0;
    std::array<double, kMost> of = {};
  };

  Weights weights(double pixels) const;
  double share(const Layer& layer, const Weights& across, const Weights& along) const;
  static double grey_share(const Layer& layer, std::int64_t row, const Weights& across, std::uint64_t bits);
  double combined(double largest, double sum) const { return largest + (1 - model_.resin.exchange) * (sum - largest); }

  DoseModel model_;
  std::deque<Layer> layers_;  ///< by height
  double reach_mm_ = 0;       ///< of the brightest
};

}  // namespace plumbline::inline hal::inline sim
