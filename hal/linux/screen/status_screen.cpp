#include "hal/linux/screen/status_screen.hpp"

#include <algorithm>
#include <utility>

namespace plumbline::inline hal::inline linux_board {

ScreenLayout LinuxStatusScreen::layout_of(const ScreenSettings& settings) {
  return {settings.columns, settings.rows, settings.rotation_deg, settings.bits};
}

Expected<std::unique_ptr<LinuxStatusScreen>> LinuxStatusScreen::open(const ScreenSettings& settings,
                                                                     const std::optional<CardInUse>& beside,
                                                                     const Clock& clock) {
  const ScreenLayout layout = layout_of(settings);
  auto panel = KmsScreen::open(settings, layout.sent_columns(), layout.sent_rows(), beside);
  PLUMBLINE_TRY(panel);
  std::optional<TouchPanel> touch;
  if (!settings.touch.empty()) {
    auto opened = TouchPanel::open(settings.touch, layout);
    PLUMBLINE_TRY(opened);
    touch.emplace(std::move(*opened));
  }
  return std::unique_ptr<LinuxStatusScreen>(new LinuxStatusScreen(layout, std::move(*panel), std::move(touch), clock));
}

LinuxStatusScreen::LinuxStatusScreen(const ScreenLayout& layout, KmsScreen panel, std::optional<TouchPanel> touch,
                                     const Clock& clock)
    : StatusScreen(layout.columns, layout.rows),
      layout_(layout),
      panel_(std::move(panel)),
      touch_(std::move(touch)),
      clock_(clock),
      waiting_(std::size_t{layout.columns} * layout.rows),
      sending_(waiting_.size()),
      thread_([this] { run_thread(); }) {}

LinuxStatusScreen::~LinuxStatusScreen() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

Status LinuxStatusScreen::do_present(std::span<const std::uint16_t> pixels) {
  bool failed = false;
  {
    const std::lock_guard lock(mutex_);
    std::copy(pixels.begin(), pixels.end(), waiting_.begin());
    has_waiting_ = true;
    failed = failed_;
  }
  changed_.notify_one();
  if (failed) return fail(ErrorCode::kPanelFailed, "the status screen does not take its picture:\tcheck its cable");
  return {};
}

std::optional<ScreenTouch> LinuxStatusScreen::do_next_touch() {
  const auto place = touch_ ? touch_->next() : std::nullopt;
  if (!place) return std::nullopt;
  return ScreenTouch{clock_.now(), place->column, place->row};
}

void LinuxStatusScreen::run_thread() {
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return has_waiting_ || ends_; });
      if (ends_) return;
      std::swap(waiting_, sending_);
      has_waiting_ = false;
    }
    pack_screen(layout_, sending_, panel_.memory(), panel_.pitch());
    const bool failed = !panel_.send().has_value();
    const std::lock_guard lock(mutex_);
    failed_ = failed;
  }
}

}  // namespace plumbline::inline hal::inline linux_board
