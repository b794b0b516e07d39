#include "firmware/print/loop/layer_checks.hpp"

#include <gtest/gtest.h>

#include <string>

namespace plumbline::firmware {
namespace {

using namespace std::chrono_literals;

TEST(LayerChecks, TakeTemperaturesUpToTheBoardsLimitsAndNoFurther) {
  PrintSettings settings;
  settings.lamp_max = Celsius(65);
  settings.resin_min = Celsius(18);
  settings.resin_max = Celsius(40);
  settings.lamp_resume = Celsius(50);
  settings.board_max = Celsius(85);
  double board = 85;
  bool waits = false;
  const auto fault = [&](double lamp, double resin) {
    return check_temperatures({Celsius(lamp), Celsius(resin), Celsius(board)}, settings, waits).fault;
  };
  EXPECT_EQ(fault(65, 18), FaultCode::kNone);
  EXPECT_EQ(fault(65, 40), FaultCode::kNone);
  EXPECT_EQ(fault(65.1, 25), FaultCode::kLampTooHot);
  EXPECT_EQ(fault(30, 17.9), FaultCode::kResinTooCold);
  EXPECT_EQ(fault(30, 40.1), FaultCode::kResinTooWarm);
  EXPECT_EQ(fault(65.1, 17.9), FaultCode::kLampTooHot) << "the lamp first: it is turned off";
  board = 85.1;
  EXPECT_EQ(fault(65, 25), FaultCode::kBoardTooHot);
  // A print that waits goes on well within them.
  waits = true;
  board = 79.9;
  EXPECT_EQ(fault(49.9, 18.5), FaultCode::kNone);
  EXPECT_EQ(fault(50, 25), FaultCode::kLampTooHot);
  EXPECT_EQ(fault(30, 18.4), FaultCode::kResinTooCold);
  EXPECT_EQ(fault(30, 39.6), FaultCode::kResinTooWarm);
  board = 80;
  EXPECT_EQ(fault(30, 25), FaultCode::kBoardTooHot);
}

TEST(LayerChecks, EndAPrintWhoseDoseIsOffByOverATwentieth) {
  const auto fault = [](double share) {
    ExposureReport exposure;
    exposure.lit = 2s;
    exposure.dose = Dose(8 * share);
    return check_dose(exposure, Dose(8), 4);
  };
  for (const double share : {0.951, 1.0, 1.049}) EXPECT_EQ(fault(share).fault, FaultCode::kNone) << share;
  for (const double share : {0.0, 0.949, 1.051, 2.0}) EXPECT_EQ(fault(share).fault, FaultCode::kDoseOff) << share;
  EXPECT_EQ(std::string(fault(0.5).text.view()), "layer 5 got 4 mJ/cm2 in 2.00 s instead of 8 mJ/cm2");
}

}  // namespace
}  // namespace plumbline::firmware
