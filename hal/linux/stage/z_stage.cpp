#include "hal/linux/stage/z_stage.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "hal/linux/events/clock.hpp"
#include "hal/linux/events/real_time.hpp"

namespace plumbline::inline hal::inline linux_board {
namespace {

constexpr Distance kRelease =
    1_mm;  // down from a pressed switch; no more, because a faulty one may be pressed near the film
constexpr Distance kOvertravel = 2_mm;            // how far an approach continues above the end stop's nominal height
constexpr auto kGrace = std::chrono::seconds(1);  // past ends_by(), before the stage counts as hung

nanoseconds duration_of(Distance distance, Speed speed, Acceleration acceleration) {
  return std::chrono::round<nanoseconds>(
      Ramp(distance < Distance() ? -distance : distance, speed, acceleration).duration());
}

}  // namespace

LinuxZStage::LinuxZStage(const Limits& limits, const Mechanics& mechanics, StageLines& lines, Interlock& interlock)
    : ZStage(limits, interlock),
      mechanics_(mechanics),
      lines_(lines),
      legs_(lines, mechanics.step_mm, limits.acceleration),
      wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  std::unique_lock lock(mutex_);
  thread_ = std::thread([this] { run_thread(); });
  changed_.wait(lock, [this] { return order_ == Order::kNone && ended_at_ != nanoseconds(); });
}

LinuxZStage::~LinuxZStage() {
  legs_.stop();
  {
    const std::scoped_lock lock(mutex_);
    order_ = Order::kQuit;
  }
  changed_.notify_all();
  thread_.join();
  static_cast<void>(lines_.enable(false));
  if (wake_ >= 0) ::close(wake_);
}

void LinuxZStage::run_thread() {
  has_real_time_priority_ = set_real_time_priority(kStagePriority);
  std::unique_lock lock(mutex_);
  ended_at_ = monotonic_now();  // shows the constructor that the thread runs
  changed_.notify_all();
  for (;;) {
    changed_.wait(lock, [this] { return order_ != Order::kNone; });
    const Order order = order_;
    if (order == Order::kQuit) return;
    lock.unlock();
    const Status outcome = order == Order::kMove ? move() : order == Order::kJog ? jog() : home();
    lock.lock();
    if (order_ != Order::kQuit) order_ = Order::kNone;
    arrived_ = outcome.has_value();
    const bool stopped = !outcome && outcome.error().code() == ErrorCode::kCancelled;
    outcome_ = stopped ? Status() : outcome;
    if (order == Order::kHome) homed_ = arrived_;
    if (!outcome_) homed_ = false;
    ended_at_ = monotonic_now();
    if (ended_count_ < ended_.size()) ended_[ended_count_++] = ended_at_;
    const std::uint64_t one = 1;
    static_cast<void>(::write(wake_, &one, sizeof one));  // fails only if it is already readable
    moving_ = false;
    changed_.notify_all();
  }
}

void LinuxZStage::drain(EventQueue& events) {
  std::uint64_t times = 0;
  if (::read(wake_, &times, sizeof times) != sizeof times) return;
  const std::scoped_lock lock(mutex_);
  for (std::size_t i = 0; i < ended_count_; ++i) events.add(EventKind::kMotionEnded, ended_[i]);
  ended_count_ = 0;
}

std::int64_t LinuxZStage::steps_of(Distance distance) const {
  return std::llround(static_cast<double>(distance.nanometres()) / (mechanics_.step_mm * 1e6));
}

Distance LinuxZStage::distance_of(std::int64_t steps) const {
  return Distance::nanometres(std::llround(static_cast<double>(steps) * mechanics_.step_mm * 1e6));
}

ZPosition LinuxZStage::height_of(std::int64_t count) const { return reference_ + distance_of(count); }

bool LinuxZStage::do_homed() const {
  const std::scoped_lock lock(mutex_);
  return homed_;
}

bool LinuxZStage::do_moving() const {
  const std::scoped_lock lock(mutex_);
  return moving_;
}

bool LinuxZStage::do_end_stop_pressed() const { return lines_.pressed(); }

ZPosition LinuxZStage::do_position() const {
  const std::scoped_lock lock(mutex_);
  return height_of(legs_.count());
}

void LinuxZStage::start(Order order) {
  legs_.clear_stop();
  legs_.clear_delayed_end();
  order_ = order;
  moving_ = true;
  arrived_ = false;
  steps_lost_ = Distance();
  began_at_height_.reset();
  outcome_ = Status();
  changed_.notify_all();
}

Status LinuxZStage::do_begin_move(ZPosition target, Speed speed) {
  const std::scoped_lock lock(mutex_);
  target_ = steps_of(target - reference_);
  speed_ = speed;
  began_at_ = monotonic_now();
  ends_by_ = began_at_ + duration_of(distance_of(target_ - legs_.count()), speed, limits().acceleration);
  start(Order::kMove);
  return {};
}

Status LinuxZStage::do_begin_jog(Distance distance, Speed speed) {
  const std::scoped_lock lock(mutex_);
  homed_ = false;
  target_ = legs_.count() + steps_of(distance);
  speed_ = speed;
  began_at_ = monotonic_now();
  ends_by_ = began_at_ + duration_of(distance, speed, limits().acceleration);
  start(Order::kJog);
  return {};
}

Status LinuxZStage::do_begin_homing() {
  const std::scoped_lock lock(mutex_);
  was_homed_ = std::exchange(homed_, false);
  began_at_ = monotonic_now();
  homed_from_ = legs_.count();
  const Distance travel = limits().end_stop - limits().lowest + kOvertravel;
  const Distance slow_legs = kRelease + kBackOff * 2 + kOvertravel;  // counted twice below, as a margin
  ends_by_ = began_at_ + duration_of(travel, std::min(kApproachSpeed, limits().fastest), limits().acceleration) +
             2 * duration_of(slow_legs, mechanics_.find_speed, limits().acceleration) + std::chrono::seconds(10);
  start(Order::kHome);
  return {};
}

TimePoint LinuxZStage::do_ends_by() const {
  const std::scoped_lock lock(mutex_);
  return TimePoint(std::max(ends_by_, legs_.delayed_end()));
}

Status LinuxZStage::do_stop() {
  legs_.stop();
  const std::scoped_lock lock(mutex_);
  if (!moving_) return {};
  legs_.clear_delayed_end();
  const auto slowing = std::chrono::duration<double>(limits().fastest.value() / limits().acceleration.value());
  ends_by_ = std::min(ends_by_, monotonic_now() + std::chrono::round<nanoseconds>(slowing));
  return {};
}

Expected<MotionReport> LinuxZStage::do_finish() {
  std::unique_lock lock(mutex_);
  while (moving_) {
    const nanoseconds until = std::max(ends_by_, legs_.delayed_end()) + kGrace;
    if (monotonic_now() > until) {
      return fail(ErrorCode::kDeviceTimeout, "the stage did not end its motion:\tswitch the printer off and on");
    }
    changed_.wait_for(lock, until - monotonic_now() + std::chrono::milliseconds(1));
  }
  if (!outcome_) return tl::unexpected<Error>(outcome_.error());
  return MotionReport{.began_at = TimePoint(began_at_),
                      .ended_at = TimePoint(ended_at_),
                      .position = height_of(legs_.count()),
                      .arrived = arrived_,
                      .steps_lost = steps_lost_,
                      .began_at_height = arrived_ ? began_at_height_ : std::nullopt};
}

Status LinuxZStage::run_leg(Distance distance, Speed speed, LegUntil until, StepLegResult& result) {
  result = legs_.run(steps_of(distance), std::min(speed, limits().fastest), until, monotonic_now());
  if (result.end == StepLegEnd::kFailed) {
    return fail(ErrorCode::kStageStalled, "a line of the stage's driver can't be set: %s", std::strerror(errno));
  }
  if (result.end == StepLegEnd::kStopped) return fail(ErrorCode::kCancelled, "stopped");
  return {};
}

Status LinuxZStage::move() {
  if (!lines_.enable(true)) {
    return fail(ErrorCode::kStageStalled, "the stage's driver can't be enabled: %s", std::strerror(errno));
  }
  const auto result = legs_.run(target_ - legs_.count(), speed_, LegUntil::kDone, began_at_);
  switch (result.end) {
    case StepLegEnd::kDone:
    case StepLegEnd::kSwitched: return {};
    case StepLegEnd::kStopped: return fail(ErrorCode::kCancelled, "stopped");
    case StepLegEnd::kMetStop:
      return fail(ErrorCode::kEndStopStuck,
                  "the end stop closed %.2f mm too low:\tcheck the switch and what blocks the stage",
                  (limits().end_stop - height_of(result.switched)).millimetres());
    case StepLegEnd::kFailed:
      return fail(ErrorCode::kStageStalled, "a line of the stage's driver can't be set: %s", std::strerror(errno));
  }
  return {};
}

Status LinuxZStage::jog() {
  if (!lines_.enable(true)) {
    return fail(ErrorCode::kStageStalled, "the stage's driver can't be enabled: %s", std::strerror(errno));
  }
  StepLegResult result;
  PLUMBLINE_TRY(run_leg(distance_of(target_ - legs_.count()), speed_, LegUntil::kPressed, result));
  if (result.end == StepLegEnd::kSwitched) return fail(ErrorCode::kCancelled, "the end stop closed");
  return {};
}

Status LinuxZStage::home() {
  if (!lines_.enable(true)) {
    return fail(ErrorCode::kStageStalled, "the stage's driver can't be enabled: %s", std::strerror(errno));
  }
  PLUMBLINE_TRY(approach());
  PLUMBLINE_TRY(find_end_stop());
  StepLegResult back;
  return run_leg(limits().highest - height_of(legs_.count()), kApproachSpeed, LegUntil::kDone, back);
}

/// Brings the stage just below the end stop, which is then released.
Status LinuxZStage::approach() {
  StepLegResult result;
  if (lines_.pressed()) {
    if (was_homed_ && height_of(legs_.count()) < limits().end_stop - kBackOff) {
      return fail(ErrorCode::kEndStopStuck, "the end stop is pressed, but the stage is elsewhere:\tcheck the switch");
    }
    PLUMBLINE_TRY(run_leg(-kRelease, mechanics_.find_speed, LegUntil::kReleased, result));
    if (result.end != StepLegEnd::kSwitched) {
      return fail(ErrorCode::kEndStopStuck, "the end stop stays pressed:\tcheck its switch");
    }
  } else {
    PLUMBLINE_TRY(
        run_leg(limits().end_stop - limits().lowest + kOvertravel, kApproachSpeed, LegUntil::kPressed, result));
    if (result.end != StepLegEnd::kSwitched) {
      return fail(ErrorCode::kEndStopNotFound,
                  "the stage covered its whole travel without meeting the end stop:\tcheck switch and cable");
    }
    PLUMBLINE_TRY(run_leg(-kBackOff, kApproachSpeed, LegUntil::kDone, result));
    if (lines_.pressed()) {
      return fail(ErrorCode::kEndStopStuck, "the end stop stays pressed after backing off:\tcheck its switch");
    }
  }
  return {};
}

Status LinuxZStage::find_end_stop() {
  StepLegResult result;
  PLUMBLINE_TRY(run_leg(kBackOff + kOvertravel, mechanics_.find_speed, LegUntil::kPressed, result));
  if (result.end != StepLegEnd::kSwitched) {
    return fail(ErrorCode::kEndStopNotFound, "the end stop switched once but not again:\tcheck the switch");
  }
  const std::scoped_lock lock(mutex_);
  if (was_homed_) steps_lost_ = height_of(result.switched) - limits().end_stop;
  reference_ = limits().end_stop - distance_of(result.switched);
  began_at_height_ = height_of(homed_from_);
  return {};
}

}  // namespace plumbline::inline hal::inline linux_board
