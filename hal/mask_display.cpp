#include "hal/mask_display.hpp"

namespace plumbline::inline hal {

MaskBuffer& MaskBuffer::operator=(MaskBuffer&& other) noexcept {
  if (this != &other) {
    release();
    display_ = std::exchange(other.display_, nullptr);
    image_ = std::exchange(other.image_, BitImage());
    greys_ = std::exchange(other.greys_, nullptr);
  }
  return *this;
}

void MaskBuffer::release() {
  if (display_ == nullptr) return;
  display_->do_release();
  display_->lent_ = false;
  display_ = nullptr;
  image_ = BitImage();
  greys_ = nullptr;
}

Expected<MaskBuffer> MaskDisplay::lend() {
  PLUMBLINE_TRY(interlock_.check_power());
  if (lent_) {
    return fail(ErrorCode::kBusy, "the mask's buffer is already lent: present or release it before asking again");
  }
  const auto lent = do_lend();
  PLUMBLINE_TRY(lent);
  assert(lent->image.columns() == columns_ && lent->image.rows() == rows_);
  lent->greys->clear();
  lent_ = true;
  return MaskBuffer(*this, lent->image, *lent->greys);
}

Status MaskDisplay::present(MaskBuffer&& buffer) {
  assert(buffer.display_ == this && "present a buffer on the display that lent it");
  PLUMBLINE_TRY(interlock_.check_power());
  if (interlock_.lamp_lit()) {
    return fail(ErrorCode::kLampLit, "the mask can't change while the lamp is lit:\tturn it off first");
  }
  presented_ = false;
  auto shown = do_present();
  lent_ = false;
  buffer.display_ = nullptr;
  buffer.image_ = BitImage();
  buffer.greys_ = nullptr;
  presented_ = shown.has_value();
  return shown;
}

Status MaskDisplay::blank() {
  PLUMBLINE_TRY(interlock_.check_power());
  if (interlock_.lamp_lit()) {
    return fail(ErrorCode::kLampLit, "the mask can't be blanked while the lamp is lit:\tturn it off first");
  }
  presented_ = false;
  return do_blank();
}

}  // namespace plumbline::inline hal
