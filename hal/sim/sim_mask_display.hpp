#pragma once

#include "hal/mask_display.hpp"
#include "hal/sim/plant/plant.hpp"

namespace plumbline {

/// The plant's panel.
class SimMaskDisplay final : public MaskDisplay {
 public:
  SimMaskDisplay(Plant& plant, Interlock& interlock);

 private:
  Expected<BitImage> do_lend() override;
  void do_release() override {}
  Status do_present() override { return show(false); }
  Status do_blank() override { return show(true); }
  Status show(bool black);

  Plant& plant_;
};

}  // namespace plumbline
