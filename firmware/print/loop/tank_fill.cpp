#include "firmware/print/loop/tank_fill.hpp"

#include <algorithm>
#include <cmath>

#include "firmware/messages/printer_code.hpp"

namespace plumbline::firmware {
namespace {

/// Share of a full tank that the plate does not reach. A trade-off: a smaller share risks layers without resin, a larger one asks too early.
constexpr double kOutOfReach = 0.05;
/// Of a print that needs more than a full tank: this much of one is enough to begin.
constexpr double kNearlyFull = 0.9;

}  // namespace

double usable_ml(std::optional<double> left_ml, double tank_ml) {
  return std::max(0.0, left_ml.value_or(0) - kOutOfReach * tank_ml);
}

double fill_to_ml(double needed_ml, double tank_ml) {
  constexpr double kTenths = 10;
  return std::min(tank_ml, std::ceil((needed_ml + kOutOfReach * tank_ml) * kTenths) / kTenths);
}

bool needs_filling(std::optional<double> left_ml, double needed_ml, double tank_ml) {
  return !left_ml || usable_ml(left_ml, tank_ml) < std::min(needed_ml, kNearlyFull * tank_ml);
}

Spoken fill_question(std::optional<double> left_ml, double fill_ml) {
  Spoken question;
  if (left_ml) {
    question.text.add("%.1f ml of resin are left", *left_ml);
    question.told = {PrinterCode::kRefillTank, {{PrinterFact::kLeftMl, *left_ml}, {PrinterFact::kFillMl, fill_ml}}};
  } else {
    question.text.add("nobody has said how much resin there is");
    question.told = {PrinterCode::kFillTank, {{PrinterFact::kFillMl, fill_ml}}};
  }
  question.text.add(": fill the tank to %.1f ml, close the cover, then press start", fill_ml);
  return question;
}

}  // namespace plumbline::firmware
