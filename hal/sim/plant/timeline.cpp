#include "hal/sim/plant/timeline.hpp"

#include <algorithm>
#include <thread>

namespace plumbline::inline hal::inline sim {

Timeline::Due Timeline::at(TimePoint time, Action action) {
  const Due due{std::max(time, now_), ++order_};
  due_.emplace(due, std::move(action));
  return due;
}

bool Timeline::step(TimePoint time) {
  const auto next = due_.begin();
  if (next == due_.end() || next->first.first > time) {
    set_now(std::max(now_, time));
    return false;
  }
  const auto node = due_.extract(next);
  set_now(node.key().first);
  node.mapped()();
  return true;
}

void Timeline::set_now(TimePoint time) {
  now_ = time;
  if (pace_.speedup <= 0) return;
  const std::chrono::duration<double> since_start = now_.time_since_epoch();
  std::this_thread::sleep_until(host_start_ +
                                std::chrono::duration_cast<HostClock::duration>(since_start / pace_.speedup));
}

void Timeline::enter_call() {
  if (depth_++ > 0 || pace_.computing <= 0) return;
  const auto computed = std::chrono::duration_cast<nanoseconds>((HostClock::now() - left_at_) * pace_.computing);
  advance_until(now_ + computed, [] { return false; });
}

void Timeline::leave_call() {
  if (--depth_ == 0 && pace_.computing > 0) left_at_ = HostClock::now();
}

}  // namespace plumbline::inline hal::inline sim
