#pragma once
/// The panel of a board: masks are drawn as bits, and packed into the display's memory when they are presented.

#include <vector>

#include "hal/linux/display/kms_panel.hpp"
#include "hal/linux/display/panel_layout.hpp"
#include "hal/mask_display.hpp"

namespace plumbline {

class LinuxMaskDisplay final : public MaskDisplay {
 public:
  /// @param layout   checked
  /// @param settling  from the end of a scan-out until the panel's pixels stand
  LinuxMaskDisplay(const PanelLayout& layout, KmsPanel panel, std::chrono::nanoseconds settling, Interlock& interlock);

 private:
  Expected<BitImage> do_lend() override;
  void do_give_back() override {}
  Status do_present() override;
  Status do_blank() override;
  Status flip_and_settle();

  PanelLayout layout_;
  KmsPanel panel_;
  std::chrono::nanoseconds settling_;
  std::array<std::vector<std::uint64_t>, 2> words_;  // one was presented, one is lent
  std::size_t lent_ = 0;
};

}  // namespace plumbline
