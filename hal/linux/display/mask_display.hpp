#pragma once
/// The panel of a board. A mask is drawn as bits and packed into display memory when it is presented.

#include <array>
#include <vector>

#include "hal/linux/display/kms_panel.hpp"
#include "hal/linux/display/pack_pixels.hpp"
#include "hal/mask_display.hpp"

namespace plumbline::inline hal::inline linux_board {

class LinuxMaskDisplay final : public MaskDisplay {
 public:
  /// @param layout    must pass check()
  /// @param settling  from the end of a scan-out until the pixels have settled
  LinuxMaskDisplay(const PanelLayout& layout, KmsPanel panel, std::chrono::nanoseconds settling, Interlock& interlock);

 private:
  Expected<Lent> do_lend() override;
  void do_release() override {}
  Status do_present() override;
  Status do_blank() override;
  Status flip_and_settle();

  PanelLayout layout_;
  KmsPanel panel_;
  std::chrono::nanoseconds settling_;
  // The mask presented last, and the one to lend.
  std::array<std::vector<std::uint64_t>, 2> words_;
  std::array<std::vector<GreyRun>, 2> runs_;
  std::array<GreyRuns, 2> greys_;
  GreyScale::Values values_;
  LampShares shares_;
  std::size_t lent_ = 0;
};

}  // namespace plumbline::inline hal::inline linux_board
