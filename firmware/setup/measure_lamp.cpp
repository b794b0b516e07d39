#include <algorithm>
#include <cmath>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/settings/setting_words.hpp"
#include "firmware/setup/bench.hpp"

namespace plumbline::firmware {
namespace {

void draw_white(BitImage mask) {
  for (std::uint32_t row = 0; row < mask.rows(); ++row) {
    for (auto& word : mask.row(row)) word = ~std::uint64_t{0};
    mask.row(row).back() &= mask.last_word_mask();
  }
}

}  // namespace

Irradiance irradiance_of(const PrintProfile& resin, double thickness_mm, std::chrono::duration<double> lit) {
  return Irradiance(resin.critical_energy * std::exp(thickness_mm / resin.penetration_depth) / lit.count());
}

Status measure_lamp(Dialogue& dialogue, BoardDraft& draft, const OpenMachine& open, const PrintProfile& profile) {
  std::string how;
  PLUMBLINE_TRY(
      dialogue.ask({"lamp.how",
                    "how to measure the lamp.\n  meter: one for 405 nm lies on the panel\n  sheet: resin is cured on "
                    "the film, and you measure how thick it gets",
                    "meter, sheet, or skip to keep " + draft.value("lamp", "power_mw_cm2") + " mW/cm2", "skip"},
                   [&](const std::string& answer) -> Status {
                     how = answer;
                     if (how == "meter" || how == "sheet" || how == "skip") return {};
                     return fail(ErrorCode::kBadSetting, "answer meter, sheet or skip");
                   }));
  if (how == "skip") return {};
  const auto board = draft.board();
  PLUMBLINE_TRY(board);
  auto bench = Bench::open(dialogue, *board, open);
  PLUMBLINE_TRY(bench);
  PLUMBLINE_TRY((*bench)->show(draw_white));
  Witness* const witness = (*bench)->witness();
  const auto not_measured = [&]() -> Status {
    dialogue.say("  Not measured: the lamp stays at " + draft.value("lamp", "power_mw_cm2") + " mW/cm2.");
    return {};
  };
  const auto take = [&](double power) {
    FixedText<32> digits;  // as many as a meter has
    digits.add("%.3g", power);
    return draft.set("lamp", "power_mw_cm2", digits.c_str(), kMeasured);
  };
  if (how == "meter") {
    dialogue.say(
        "\nTake the tank out and lay the meter's sensor on the middle of the panel, where you can read its peak.");
    const auto lit = (*bench)->flash(kMeterFlash, "lamp.light", " on the meter");
    PLUMBLINE_TRY(lit);
    if (!*lit) return not_measured();
    if (witness != nullptr)
      dialogue.say("  (simulated: it reads " + number(witness->irradiance().value()) + " mW/cm2)");
    return dialogue.ask({"lamp.reading", "what the meter read", "mW/cm2, from 0.1 to 100", ""},
                        [&](const std::string& answer) -> Status {
                          const auto value = number_in(answer, 0.1, 100, "mW/cm2");
                          PLUMBLINE_TRY(value);
                          return take(*value);
                        });
  }
  dialogue.say("\nFill some mm of the resin of profile " + profile.name +
               " into the tank, and leave the plate out. The whole panel cures a sheet on the film.");
  double seconds = 0;
  const Question how_long{"lamp.seconds", "how long to cure it", "s, from 1 to " + number(kLongestSheetS), "10"};
  const auto asked = dialogue.ask(how_long, [&](const std::string& answer) -> Status {
    const auto value = number_in(answer, 1, kLongestSheetS, "s");
    PLUMBLINE_TRY(value);
    seconds = *value;
    return {};
  });
  PLUMBLINE_TRY(asked);
  const nanoseconds cure =
      std::min(nanoseconds(std::llround(seconds * 1e9)), (*bench)->machine().lamp.limits().longest_exposure);
  const auto lit = (*bench)->flash(cure, "lamp.light", " to cure the sheet");
  PLUMBLINE_TRY(lit);
  if (!*lit) return not_measured();
  if (witness != nullptr) {
    const double dose = witness->irradiance().value() * std::chrono::duration<double>(cure).count();
    dialogue.say("  (simulated: it is " + number(std::max(0.0, cure_depth_mm(profile, dose))) + " mm thick)");
  }
  return dialogue.ask(
      {"lamp.thickness", "take the sheet off the film, dab it dry, and measure it with a caliper", "mm", ""},
      [&](const std::string& answer) -> Status {
        const auto value = number_in(answer, 0.01, 10, "mm");
        PLUMBLINE_TRY(value);
        return take(irradiance_of(profile, *value, cure).value());
      });
}

}  // namespace plumbline::firmware
