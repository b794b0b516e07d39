#include "tests/slicer/support/leave_one_out.hpp"

namespace plumbline {
namespace {

// Fifteen prints take ten minutes.
TEST(LeaveOneOutLong, ThePrintedDragonLiesBetweenItsViews) {
  leave_one_out::expect_prints_between_the_views("dragon_raw");
}

}  // namespace
}  // namespace plumbline
