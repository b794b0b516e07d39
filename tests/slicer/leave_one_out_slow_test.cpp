#include "tests/slicer/support/leave_one_out.hpp"

namespace plumbline {
namespace {

TEST(LeaveOneOutSlow, ThePrintedBunnyLiesBetweenItsViews) {
  leave_one_out::expect_prints_between_the_views("bunny_raw");
}

// Its range images come in pieces to the search for views, which once slid 0.5 mm along the surface.
TEST(LeaveOneOutSlow, ThePrintedDragonLiesBetweenItsViewsWithoutOneOfThem) {
  leave_one_out::expect_prints_between_the_views("dragon_raw", 13);
}

}  // namespace
}  // namespace plumbline
