/// The mistakes of plumblined-broken, which the tests on the emulated board must find. The environment variable PLUMBLINE_BROKEN
/// chooses one. It happens at one layer.
///
///   early-light   present() returns before the flip: the lamp lights what the panel showed before
///   lost-step     one pulse of the stage's step line is missing
///   wrong-pixel   one pixel of the mask is flipped
///
/// The linker replaces the functions wrapped here (--wrap); the firmware itself is unchanged.

#include <gpiod.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <thread>

#include "hal/linux/display/kms_panel.hpp"

namespace plumbline::firmware {
namespace {

constexpr int kMask = 4;           // the mistake happens at this mask, counted from 1
constexpr unsigned kStepLine = 0;  // offset in board/rig.toml
constexpr std::size_t kPixel = 100;

int masks_shown = 0;
bool step_due = false;  // the next pulse will be lost

bool broken_by(std::string_view fault) {
  const char* const chosen = std::getenv("PLUMBLINE_BROKEN");
  return chosen != nullptr && fault == chosen;
}

}  // namespace

Status flip(KmsPanel* panel) asm("__real__ZN9plumbline3hal11linux_board8KmsPanel4flipEv");

Status broken_flip(KmsPanel* panel) asm("__wrap__ZN9plumbline3hal11linux_board8KmsPanel4flipEv");
Status broken_flip(KmsPanel* panel) {
  const auto back = panel->back();
  if (!back) return tl::unexpected<Error>(back.error());
  const bool is_mask = std::any_of(back->begin(), back->end(), [](std::uint32_t pixel) { return pixel != 0; });
  if (!is_mask || ++masks_shown != kMask) return flip(panel);
  step_due = broken_by("lost-step");
  if (broken_by("wrong-pixel")) (*back)[kPixel] ^= 0xFFFFFF;
  if (!broken_by("early-light")) return flip(panel);
  std::thread([panel] {
    constexpr auto kLate = std::chrono::milliseconds(300);  // less than an exposure
    std::this_thread::sleep_for(kLate);
    static_cast<void>(flip(panel));
  }).detach();
  return {};
}

extern "C" int __real_gpiod_line_set_value(gpiod_line* line, int value);

extern "C" int __wrap_gpiod_line_set_value(gpiod_line* line, int value);
extern "C" int __wrap_gpiod_line_set_value(gpiod_line* line, int value) {
  if (step_due && value == 1 && ::gpiod_line_offset(line) == kStepLine) {
    step_due = false;
    return 0;
  }
  return __real_gpiod_line_set_value(line, value);
}

}  // namespace plumbline::firmware
