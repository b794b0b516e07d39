/// Contract of every back end: the panel.

#include "tests/hal/contract.hpp"

namespace plumbline {
namespace {

using namespace std::chrono_literals;

using MaskContract = Contract;

TEST_P(MaskContract, MaskIsLentOnceUntilReleased) {
  MaskDisplay& display = rig_->machine().mask;
  {
    const auto mask = display.lend();
    ASSERT_TRUE(mask);
    EXPECT_EQ(mask->image().columns(), display.columns());
    EXPECT_EQ(mask->image().rows(), display.rows());
    EXPECT_TRUE(failed_with(display.lend(), ErrorCode::kBusy));
  }
  EXPECT_TRUE(display.lend());
}

TEST_P(MaskContract, MaskOnThePanelCannotBeWritten) {
  MaskDisplay& display = rig_->machine().mask;
  auto first = display.lend();
  ASSERT_TRUE(first);
  const auto* const words = first->image().words().data();
  ASSERT_TRUE(display.present(std::move(*first)));
  EXPECT_EQ(first->image().columns(), 0U);
  const auto second = display.lend();
  ASSERT_TRUE(second);
  EXPECT_NE(second->image().words().data(), words);
}

TEST_P(MaskContract, MaskHasNoGreysWhenItIsLent) {
  MaskDisplay& display = rig_->machine().mask;
  for (int mask = 0; mask < 3; ++mask) {
    auto lent = display.lend();
    ASSERT_TRUE(lent);
    EXPECT_TRUE(lent->greys().empty());
    lent->image().clear();
    if (lent->greys().capacity() > 0) lent->greys().add(7, 100);
    MaskBuffer moved = std::move(*lent);
    if (mask == 0) continue;  // released
    ASSERT_TRUE(display.present(std::move(moved)));
  }
}

TEST_P(MaskContract, MaskIsPresentedUntilThePanelIsBlanked) {
  MaskDisplay& display = rig_->machine().mask;
  EXPECT_FALSE(display.presented());
  show_a_mask();
  EXPECT_TRUE(display.presented());
  ASSERT_TRUE(display.blank());
  EXPECT_FALSE(display.presented());
}

TEST_P(MaskContract, PanelDoesNotChangeUnderLight) {
  const Machine machine = rig_->machine();
  show_a_mask();
  auto next = machine.mask.lend();
  ASSERT_TRUE(next);
  auto exposure = machine.lamp.begin_exposure(1s);
  ASSERT_TRUE(exposure);
  EXPECT_TRUE(failed_with(machine.mask.present(std::move(*next)), ErrorCode::kLampLit));
  EXPECT_GT(next->image().columns(), 0U) << "a refused mask still belongs to the caller";
  EXPECT_TRUE(failed_with(machine.mask.blank(), ErrorCode::kLampLit));
  EXPECT_TRUE(machine.mask.presented());
  ASSERT_TRUE(exposure->finish());
  EXPECT_TRUE(machine.mask.present(std::move(*next)));
}

INSTANTIATE_TEST_SUITE_P(Hal, MaskContract, testing::ValuesIn(rig_makers()), kRigName);

}  // namespace
}  // namespace plumbline
