#include "hal/linux/display/mask_display.hpp"

#include <algorithm>

#include "hal/linux/events/clock.hpp"

namespace plumbline::inline hal::inline linux_board {

LinuxMaskDisplay::LinuxMaskDisplay(const PanelLayout& layout, KmsPanel panel, std::chrono::nanoseconds settling,
                                   Interlock& interlock)
    : MaskDisplay(layout.columns, layout.rows, interlock),
      layout_(layout),
      panel_(std::move(panel)),
      settling_(settling),
      values_(layout.grey.values()),
      shares_(layout.lamp, layout.columns, layout.rows) {
  for (auto& words : words_) words.resize(BitImage::words_needed(layout.columns, layout.rows));
  if (!layout.grey.has_levels()) return;
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    runs_[i].resize(GreyRuns::runs_needed(layout.columns, layout.rows));
    greys_[i] = GreyRuns(runs_[i], layout.columns);
  }
}

Expected<MaskDisplay::Lent> LinuxMaskDisplay::do_lend() {
  return Lent{BitImage(words_[lent_], layout_.columns, layout_.rows), &greys_[lent_]};
}

Status LinuxMaskDisplay::flip_and_settle() {
  PLUMBLINE_TRY(panel_.flip());
  sleep_until_monotonic(monotonic_now() + panel_.frame() + settling_);
  return {};
}

Status LinuxMaskDisplay::do_present() {
  const auto back = panel_.back();
  if (!back) return tl::unexpected<Error>(back.error());
  const ConstBitImage mask(words_[lent_], layout_.columns, layout_.rows);
  const auto greys = greys_[lent_].runs();
  pack_pixels(layout_, mask, *back, panel_.pitch());
  if (shares_.known()) {
    pack_evenly(layout_, mask, greys, shares_, values_, *back, panel_.pitch());
  } else {
    pack_greys(layout_, greys, values_, *back, panel_.pitch());
  }
  lent_ = 1 - lent_;
  return flip_and_settle();
}

Status LinuxMaskDisplay::do_blank() {
  const auto back = panel_.back();
  if (!back) return tl::unexpected<Error>(back.error());
  std::fill(back->begin(), back->end(), 0U);
  return flip_and_settle();
}

}  // namespace plumbline::inline hal::inline linux_board
