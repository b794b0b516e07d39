#pragma once
/// The simulated printer's status screen: whoever watches gets each frame.

#include <deque>
#include <span>
#include <vector>

#include "hal/status_screen.hpp"

namespace plumbline::inline hal::inline sim {

/// Gets what the screen shows.
class ScreenWatcher {
 public:
  virtual ~ScreenWatcher() = default;
  /// @param pixels  as StatusScreen::present() takes them, valid during the call
  virtual void shown(std::uint32_t columns, std::uint32_t rows, std::span<const std::uint16_t> pixels) = 0;
};

class SimStatusScreen final : public StatusScreen {
 public:
  /// @param watcher  must outlive it; null: nobody watches
  SimStatusScreen(std::uint32_t columns, std::uint32_t rows, ScreenWatcher* watcher)
      : StatusScreen(columns, rows), watcher_(watcher) {}

  // The user's side.
  void touch(const ScreenTouch& touch) { touches_.push_back(touch); }
  /// What it shows; empty before the first frame.
  std::span<const std::uint16_t> pixels() const { return pixels_; }

 private:
  Status do_present(std::span<const std::uint16_t> pixels) override;
  std::optional<ScreenTouch> do_next_touch() override;

  ScreenWatcher* watcher_;
  std::vector<std::uint16_t> pixels_;
  std::deque<ScreenTouch> touches_;
};

}  // namespace plumbline::inline hal::inline sim
