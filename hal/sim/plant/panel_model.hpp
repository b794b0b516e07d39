#pragma once
/// The panel: two buffers and a flip at the next frame, which changes the rows from top to bottom.

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "hal/panel_layout.hpp"
#include "hal/sim/plant/timeline.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/grey_runs.hpp"

namespace plumbline::inline hal::inline sim {

class PanelModel {
 public:
  struct Build {
    std::uint32_t columns = 1440;
    std::uint32_t rows = 2560;
    double pitch_x_mm = 0.04725;
    double pitch_y_mm = 0.04725;
    GreyScale grey;
    LampMap lamp;                           ///< that its driver evens out; needs grey.has_levels()
    nanoseconds frame{16'666'667};          ///< 60 Hz
    nanoseconds settling{20'000'000};       ///< from the end of the scan-out until the liquid crystals have settled
    nanoseconds flip_timeout{500'000'000};  ///< time limit of present()
  };

  PanelModel(Timeline& timeline, const Build& build);

  /// The hidden buffer.
  BitImage back() { return image(1 - shown_); }
  GreyRuns& back_greys() { return greys_[1 - shown_]; }
  /// Shows the back buffer, or black: changes row by row during the next frame, then settles.
  /// @param on_settled  called when it has settled
  void flip(bool black, std::function<void()> on_settled);
  /// Cuts the power.
  void cut();

  bool changing() const { return changing_; }  ///< between the flip and its settling
  bool black() const { return black_; }
  bool matches_mask() const { return matches_mask_; }  ///< whether all rows are those of the last flip
  /// The pixels that let light through now. After a torn flip: the upper half of the new mask, the lower half of the old.
  ConstBitImage visible();
  /// Of these pixels, those that let some of the light through, 0 to 255 of 255 as the panel's levels and gamma make it. Valid until the
  /// next call.
  std::span<const GreyRun> visible_greys();

  /// Called just before a flip starts changing rows.
  std::function<void()> on_change;

  // Faults.
  bool never_flips = false;
  bool torn = false;
  bool stale = false;
  nanoseconds extra{};

 private:
  BitImage image(std::size_t which) { return {buffers_[which], build_.columns, build_.rows}; }
  void add_visible(const GreyRun& run, LampShares::Row* row);
  /// Whether the upper half shows one mask and the lower another.
  bool shows_two() const { return changing_ || (!matches_mask_ && torn); }

  Timeline& timeline_;
  Build build_;
  std::array<std::vector<std::uint64_t>, 2> buffers_;
  std::array<std::vector<GreyRun>, 2> runs_;
  std::array<GreyRuns, 2> greys_;
  GreyScale::Values light_{};  ///< as GreyScale::values()
  LampShares shares_;
  std::vector<std::uint64_t> torn_;
  std::vector<GreyRun> sent_, visible_greys_;
  std::size_t shown_ = 0;
  bool black_ = true;
  bool was_black_ = true;
  bool changing_ = false;
  bool matches_mask_ = true;
  Timeline::Due due_;
};

}  // namespace plumbline::inline hal::inline sim
