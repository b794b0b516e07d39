/// The card of lights and buzzer in board/README.md, against what the front panel is told in each state.

#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <string>

#include "firmware/print/status/print_state.hpp"

namespace plumbline::firmware {
namespace {

/// Writes down a row of the card: "| on | - | blinks | - | - |".
class CardPanel final : public FrontPanel {
 public:
  explicit CardPanel(Interlock& interlock) : FrontPanel(interlock) {}
  std::string row() const {
    std::string text = "|";
    for (const LightState light : lights_) {
      text += light == LightState::kOn ? " on |" : light == LightState::kBlinking ? " blinks |" : " - |";
    }
    return text + (beep_ == std::chrono::seconds(1) ? " 1 s |" : beep_ == nanoseconds() ? " - |" : " another |");
  }

 private:
  bool do_cover_open() const override { return false; }
  Status do_set_light(PanelLight light, LightState state) override {
    lights_.at(static_cast<std::size_t>(light)) = state;
    return {};
  }
  Status do_beep(nanoseconds time) override {
    beep_ = time;
    return {};
  }

  std::array<LightState, kPanelLightCount> lights_{};
  nanoseconds beep_{};
};

TEST(StateLights, AreThoseOfTheCard) {
  std::ifstream file(PLUMBLINE_SOURCE_DIR "/board/README.md");
  ASSERT_TRUE(file);
  std::string card;
  for (std::string line; std::getline(file, line);) card += line + "\n";
  for (std::size_t i = 0; i < kPrintStateCount; ++i) {
    const auto state = static_cast<PrintState>(i);
    Interlock interlock;
    CardPanel panel(interlock);
    show_on_panel(panel, state);
    const std::size_t at = card.find(panel.row());
    ASSERT_NE(at, std::string::npos) << panel.row() << " for " << to_string(state);
    const std::string line = card.substr(at, card.find('\n', at) - at);
    EXPECT_NE(line.find("`" + std::string(to_string(state)) + "`"), std::string::npos)
        << to_string(state) << ": " << line;
  }
}

}  // namespace
}  // namespace plumbline::firmware
