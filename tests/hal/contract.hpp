#pragma once
/// Base of the contract tests, which run against each rig of rigs.cpp.

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "tests/hal/rig.hpp"

namespace plumbline {

class Contract : public testing::TestWithParam<RigMaker> {
 protected:
  void SetUp() override {
    rig_ = GetParam().make();
    ASSERT_NE(rig_, nullptr);
  }

  void home() {
    const auto homed = rig_->machine().stage.home();
    ASSERT_TRUE(homed) << homed.error().message();
    forget_events();
  }
  void show_a_mask() {
    auto mask = rig_->machine().mask.lend();
    ASSERT_TRUE(mask);
    mask->image().clear();
    mask->image().set(3, 5);
    const auto shown = rig_->machine().mask.present(std::move(*mask));
    ASSERT_TRUE(shown) << shown.error().message();
  }
  void forget_events() {
    while (rig_->machine().events.next_event(TimePoint())->has_value()) {
    }
  }
  /// The kinds of all events in the next `time`.
  std::vector<EventKind> events_in(nanoseconds time) {
    std::vector<EventKind> kinds;
    const TimePoint end = rig_->machine().clock.now() + time;
    while (const auto event = rig_->machine().events.next_event(end).value()) kinds.push_back(event->kind);
    return kinds;
  }

  std::unique_ptr<Rig> rig_;
};

template <class Result>
testing::AssertionResult failed_with(const Result& result, ErrorCode code) {
  if (result) return testing::AssertionFailure() << "it succeeded";
  if (result.error().code() == code) return testing::AssertionSuccess();
  return testing::AssertionFailure() << to_string(result.error().code()) << ": " << result.error().message();
}

inline const auto kRigName = [](const testing::TestParamInfo<RigMaker>& info) { return std::string(info.param.name); };

}  // namespace plumbline
