/// Contract of every back end: cover, lights, buzzer, temperatures and fans.

#include <gmock/gmock.h>

#include "tests/hal/contract.hpp"

namespace plumbline {
namespace {

using namespace std::chrono_literals;

using PanelContract = Contract;

TEST_P(PanelContract, PanelReportsAnOpenCover) {
  const Machine machine = rig_->machine();
  EXPECT_FALSE(machine.panel.cover_open());
  rig_->open_cover(0ns);
  EXPECT_THAT(events_in(100ms), testing::ElementsAre(EventKind::kCoverOpened));
  EXPECT_TRUE(machine.panel.cover_open());
  for (const auto light : {PanelLight::kReady, PanelLight::kPrinting, PanelLight::kAttention, PanelLight::kFault}) {
    EXPECT_TRUE(machine.panel.set_light(light, LightState::kBlinking));
  }
  EXPECT_TRUE(machine.panel.beep(10ms));
}

TEST_P(PanelContract, TemperaturesArePlausible) {
  const Machine machine = rig_->machine();
  for (const auto site : {TemperatureSite::kLamp, TemperatureSite::kResin, TemperatureSite::kBoard}) {
    const auto read = machine.thermals.temperature(site);
    ASSERT_TRUE(read);
    EXPECT_GT(read->value(), 0);
    EXPECT_LT(read->value(), 90);
  }
  for (const auto fan : {Fan::kLamp, Fan::kChamber}) {
    EXPECT_TRUE(machine.thermals.set_fan(fan, 1));
    EXPECT_NE(machine.thermals.fan_health(fan), FanHealth::kStalled);
  }
}

INSTANTIATE_TEST_SUITE_P(Hal, PanelContract, testing::ValuesIn(rig_makers()), kRigName);

}  // namespace
}  // namespace plumbline
