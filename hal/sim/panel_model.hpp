#pragma once
/// The panel: two buffers, a flip at the next frame, rows that change from top to bottom.

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "hal/sim/timeline.hpp"
#include "slicer/core/bit_image.hpp"

namespace plumbline {

class PanelModel {
 public:
  struct Build {
    std::uint32_t columns = 1440;
    std::uint32_t rows = 2560;
    double pitch_x_mm = 0.04725;
    double pitch_y_mm = 0.04725;
    nanoseconds frame{16'666'667};          ///< 60 Hz
    nanoseconds settling{20'000'000};       ///< that the liquid crystals take after the scan-out
    nanoseconds flip_timeout{500'000'000};  ///< bound of present()
  };

  PanelModel(Timeline& timeline, const Build& build);

  /// The buffer that is not shown.
  BitImage back() { return image(1 - shown_); }
  /// Shows the back buffer, or black: at the next frame, row by row during that frame, settled after it.
  /// @param on_settled  told when it is
  void flip(bool black, std::function<void()> on_settled);
  /// No power.
  void cut();

  bool changing() const { return changing_; }  ///< between the flip and its settling
  bool black() const { return black_; }
  bool true_to_mask() const { return true_; }  ///< all rows are those of the last flip
  /// What lets light through now. Where the last flip was torn: the upper half of the new mask, the lower half of the old.
  ConstBitImage seen();

  /// Called just before a flip begins to change rows.
  std::function<void()> on_change;

  // Faults.
  bool never_flips = false;
  bool tears = false;
  bool stays = false;
  nanoseconds extra{};

 private:
  BitImage image(std::size_t which) { return {buffers_[which], build_.columns, build_.rows}; }

  Timeline& timeline_;
  Build build_;
  std::array<std::vector<std::uint64_t>, 2> buffers_;
  std::vector<std::uint64_t> torn_;
  std::size_t shown_ = 0;
  bool black_ = true;
  bool was_black_ = true;
  bool changing_ = false;
  bool true_ = true;
  Timeline::Due due_;
};

}  // namespace plumbline
