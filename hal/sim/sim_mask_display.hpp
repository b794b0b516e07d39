#pragma once

#include <vector>

#include "hal/mask_display.hpp"
#include "hal/sim/plant/plant.hpp"

namespace plumbline::inline hal::inline sim {

/// The plant's panel.
class SimMaskDisplay final : public MaskDisplay {
 public:
  SimMaskDisplay(Plant& plant, Interlock& interlock);

 private:
  Expected<Lent> do_lend() override;
  void do_release() override {}
  Status do_present() override;
  Status do_blank() override { return show(true); }
  Status show(bool black);
  /// Sends the lent mask as the firmware believes, and takes it as the panel is built.
  Status send_otherwise(const BuiltOtherwise& otherwise);

  Plant& plant_;
  std::vector<std::uint64_t> lent_;  ///< only for a panel that is built otherwise, which shows no grey
  GreyRuns no_greys_;
};

}  // namespace plumbline::inline hal::inline sim
