#include "tests/slicer/support/leave_one_out.hpp"

namespace plumbline {
namespace {

TEST(LeaveOneOutSlow, ThePrintedBunnyLiesBetweenItsViews) {
  leave_one_out::expect_prints_between_the_views("bunny_raw");
}

}  // namespace
}  // namespace plumbline
