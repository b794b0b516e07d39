/// `plumbline setup` on simulated printers that are built otherwise than the board file says which it begins with.

#include "firmware/setup/setup.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <csignal>
#include <fstream>
#include <map>
#include <random>

#include "firmware/io/interrupt.hpp"
#include "firmware/setup/panel_look.hpp"
#include "firmware/setup/stage_trial.hpp"

namespace plumbline::firmware {
namespace {

using ::testing::HasSubstr;
using Mirror = PanelLayout::Mirror;

const std::string kBoards = PLUMBLINE_SOURCE_DIR "/board/";

/// Whoever sets up a simulated printer: looks at its panel, holds a caliper to its plate, a meter to its lamp.
class SetterUp final : public Dialogue {
 public:
  void say(std::string_view text) override { said += std::string(text) + "\n"; }

  std::map<std::string, std::string> answers;
  std::function<std::string()> look, caliper;
  std::function<void(const std::string& question)> before;
  std::vector<std::string> asked;
  std::string said;
  std::string refused;

 private:
  Expected<std::string> answer(const Question& question) override {
    asked.push_back(question.name);
    if (before) before(question.name);
    if (watch) PLUMBLINE_TRY(watch());
    if (question.name == "look.corners" && look && answers.count(question.name) == 0) return look();
    if (question.name.starts_with("move.") && question.name != "move.ready") return caliper();
    const auto found = answers.find(question.name);
    return found == answers.end() ? question.fallback : found->second;
  }
  Status refuse(const Question& question, const Error& reason) override {
    refused = reason.message();
    return fail(ErrorCode::kBadSetting, "%s: %s", question.name.c_str(), reason.message());
  }
};

/// Counts the squares that somebody sees, each a patch of light, in each corner clockwise from the back left.
std::string squares_seen(const Sight& sight) {
  const ConstBitImage image = sight.image();
  std::vector<bool> visited(std::size_t{sight.columns} * sight.rows);
  std::array<int, 4> squares{};
  for (std::uint32_t y = 0; y < sight.rows; ++y) {
    for (std::uint32_t x = 0; x < sight.columns; ++x) {
      if (!image.at(x, y) || visited[std::size_t{y} * sight.columns + x]) continue;
      const bool right = x > sight.columns / 2, front = y > sight.rows / 2;
      ++squares[front ? (right ? 2 : 3) : (right ? 1 : 0)];
      std::vector<std::pair<std::uint32_t, std::uint32_t>> edge{{x, y}};
      while (!edge.empty()) {
        const auto [c, r] = edge.back();
        edge.pop_back();
        if (c >= sight.columns || r >= sight.rows || !image.at(c, r)) continue;
        if (visited[std::size_t{r} * sight.columns + c]) continue;
        visited[std::size_t{r} * sight.columns + c] = true;
        for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
          edge.emplace_back(c + static_cast<std::uint32_t>(dx), r + static_cast<std::uint32_t>(dy));
        }
      }
    }
  }
  std::string text;
  for (const int one : squares) text += std::to_string(one) + " ";
  return text;
}

/// The events of a machine. The first wait in which the lamp is lit begins with a signal.
class InterruptedEvents final : public Events {
 public:
  InterruptedEvents(Machine& machine, int signal) : machine_(machine), signal_(signal) {}
  std::optional<TimePoint> raised_at;
  TimePoint returned_at;  ///< from the last wait

 private:
  Expected<std::optional<Event>> do_next_event(TimePoint until) override {
    if (!raised_at && machine_.lamp.lit()) {
      raised_at = machine_.clock.now();
      std::raise(signal_);
    }
    auto event = machine_.events.next_event(until);
    returned_at = machine_.clock.now();
    return event;
  }

  Machine& machine_;
  int signal_;
};

/// A simulated machine with such events, which tells at its end how it was left.
class InterruptedBackEnd final : public BackEnd {
 public:
  struct End {
    std::optional<TimePoint> raised_at;
    TimePoint last_wait_at;
    bool light = false;
    Distance height;
  };
  InterruptedBackEnd(std::unique_ptr<BackEnd> back_end, int signal, std::function<void(const End&)> ended)
      : back_end_(std::move(back_end)),
        events_(back_end_->machine(), signal),
        machine_(with_events(back_end_->machine(), events_)),
        ended_(std::move(ended)) {}
  ~InterruptedBackEnd() override {
    Witness& witness = *back_end_->witness();
    ended_({events_.raised_at, events_.returned_at, witness.light(), witness.plate_height()});
  }
  Machine& machine() override { return machine_; }
  Witness* witness() override { return back_end_->witness(); }
  std::optional<StepFigures> take_step_figures() override { return std::nullopt; }

 private:
  static Machine with_events(const Machine& machine, Events& events) {
    return {.clock = machine.clock,
            .events = events,
            .mask = machine.mask,
            .lamp = machine.lamp,
            .stage = machine.stage,
            .stick = machine.stick,
            .panel = machine.panel,
            .thermals = machine.thermals,
            .screen = machine.screen};
  }

  std::unique_ptr<BackEnd> back_end_;
  InterruptedEvents events_;
  Machine machine_;
  std::function<void(const End&)> ended_;
};

/// A printer and whoever sets it up. `built` says how it is, the draft begins as board/`like`.
class SetUp : public testing::Test {
 protected:
  void begin(const std::string& like, const BoardFile& built) {
    auto draft = BoardDraft::like(kBoards + like + ".toml");
    ASSERT_TRUE(draft) << draft.error().message();
    draft_.emplace(std::move(*draft));
    built_ = built;
    const auto profile = read_print_profile(kBoards + "profiles/standard.toml");
    ASSERT_TRUE(profile) << profile.error().message();
    profile_ = *profile;
    open_ = [this](const BoardFile& board) {
      SimulationOptions options;
      options.simulate = true;
      options.computing = 0;
      options.built = built_;
      options.faults = faults_;
      auto back_end = open_back_end(board, *board.machine, profile_, options);
      witness_ = back_end ? (*back_end)->witness() : nullptr;
      if (witness_ != nullptr) height_ = witness_->plate_height();
      return back_end;
    };
    person_.look = [this] { return squares_seen(witness_->panel_from_above()); };
    person_.caliper = [this] {
      // A caliper's tenth, read again each time.
      const double moved = (witness_->plate_height() - height_).millimetres();
      return std::to_string(std::round(moved * 10) / 10);
    };
    person_.answers["move.ready"] = "yes";
  }
  /// From now on the first light is interrupted.
  void interrupt_in_light(int signal) {
    was_lit_ = false;
    open_ = [this, plain = open_, signal](const BoardFile& board) -> Expected<std::unique_ptr<BackEnd>> {
      auto back_end = plain(board);
      PLUMBLINE_TRY(back_end);
      const auto note = [this](const InterruptedBackEnd::End& end) {
        was_lit_ = end.raised_at.has_value();
        interrupted_at_ = end.raised_at.value_or(TimePoint());
        noticed_at_ = end.last_wait_at;
        light_at_end_ = end.light;
        height_at_end_ = end.height;
      };
      return std::make_unique<InterruptedBackEnd>(std::move(*back_end), signal, note);
    };
  }
  static BoardFile board(const std::string& name) {
    auto read = read_board_file(kBoards + name + ".toml");
    EXPECT_TRUE(read) << read.error().message();
    return *read;
  }

  SetterUp person_;
  std::optional<BoardDraft> draft_;
  BoardFile built_;
  std::vector<std::string> faults_;
  PrintProfile profile_;
  OpenMachine open_;
  Witness* witness_ = nullptr;
  Distance height_;
  bool was_lit_ = false, light_at_end_ = false;
  TimePoint interrupted_at_, noticed_at_;
  Distance height_at_end_;
};

TEST_F(SetUp, FindsEachWayAPanelCanShowAPicture) {
  for (const std::uint32_t degrees : {0U, 90U, 180U, 270U}) {
    for (const Mirror mirror : {Mirror::kNone, Mirror::kX, Mirror::kY}) {
      BoardFile built = board("rig");
      built.pixel_pitch_x_mm = 0.08;
      const bool sideways = degrees % 180 != 0;
      if (sideways) std::swap(built.columns, built.rows);
      if (sideways) std::swap(built.pixel_pitch_x_mm, built.pixel_pitch_y_mm);
      built.machine->panel = {built.columns, built.rows, degrees, mirror, false};
      begin("rig", built);
      ASSERT_TRUE(draft_->set("panel", "pixel_pitch_x_mm", "0.08", ""));
      const Status done = measure_panel(person_, *draft_, open_);
      ASSERT_TRUE(done) << done.error().message();
      const auto found = draft_->board();
      ASSERT_TRUE(found) << found.error().message();
      EXPECT_EQ(found->columns, built.columns);
      EXPECT_EQ(found->pixel_pitch_x_mm, built.pixel_pitch_x_mm);
      // Two layouts are the same if they send each pixel to the same place.
      for (const PanelLayout::Pixel pixel : {PanelLayout::Pixel{0, 0}, {3, 0}, {0, 5}}) {
        EXPECT_EQ(found->machine->panel.sent(pixel), built.machine->panel.sent(pixel))
            << degrees << " degrees, mirror " << static_cast<int>(mirror) << "; found "
            << found->machine->panel.rotation_deg << ", " << static_cast<int>(found->machine->panel.mirror);
      }
    }
  }
}

TEST_F(SetUp, EndsWithTheBoardFileOfThePrinterAsItIsBuilt) {
  // Mirrored, turned, a stage that goes the other way with other steps, a brighter lamp.
  BoardFile built = board("rig");
  std::swap(built.columns, built.rows);
  MachineFile& machine = *built.machine;
  machine.panel = {built.columns, built.rows, 90, Mirror::kX, false};
  machine.microsteps = 8;
  machine.wiring.direction.active_low = true;
  machine.power_mw_cm2 = 6.25;
  begin("rig", built);
  person_.answers["z_stage.microsteps"] = "16";
  person_.answers["lamp.how"] = "meter";
  person_.answers["lamp.light"] = "yes";
  ASSERT_TRUE(ask_about_printer(person_, *draft_, "mine"));
  ASSERT_TRUE(measure_panel(person_, *draft_, open_));
  const Status stage = measure_stage(person_, *draft_, open_);
  ASSERT_TRUE(stage) << stage.error().message() << person_.said;
  person_.answers["lamp.reading"] = "6,25";
  ASSERT_TRUE(measure_lamp(person_, *draft_, open_, profile_));

  const auto found = draft_->board();
  ASSERT_TRUE(found) << found.error().message() << "\n" << draft_->text();
  EXPECT_EQ(found->name, "mine");
  EXPECT_EQ(found->columns, built.columns);
  EXPECT_EQ(found->rows, built.rows);
  EXPECT_EQ(found->machine->panel.rotation_deg, 90U);
  EXPECT_EQ(found->machine->panel.mirror, Mirror::kX);
  EXPECT_EQ(found->machine->microsteps, 8U);
  EXPECT_EQ(found->machine->rotation_distance_mm, machine.rotation_distance_mm);
  EXPECT_TRUE(found->machine->wiring.direction.active_low);
  EXPECT_EQ(found->machine->power_mw_cm2, 6.25);
  // The rest is the rig's: nothing is lost on the way through questions and file.
  const std::string mine = draft_->text();
  auto rig = BoardDraft::like(kBoards + "rig.toml");
  for (const auto& [table, key] : {std::pair{"z_stage", "travel_mm"},
                                   {"display", "connector"},
                                   {"lamp_line", "chip"},
                                   {"watchdog", "timeout_s"},
                                   {"lamp_sensor", "file"},
                                   {"print", "start"}}) {
    EXPECT_EQ(draft_->value(table, key), rig->value(table, key)) << table << ' ' << key;
  }
  EXPECT_THAT(mine, HasSubstr("microsteps = 8                 # measured by plumbline setup"));
}

TEST_F(SetUp, FindsAgainWhatItHasFound) {
  BoardFile built = board("rig");
  std::swap(built.columns, built.rows);
  built.machine->panel = {built.columns, built.rows, 270, Mirror::kNone, false};
  begin("rig", built);
  for (int time = 0; time < 2; ++time) {  // the second time it begins with a panel that is turned
    const Status done = measure_panel(person_, *draft_, open_);
    ASSERT_TRUE(done) << done.error().message();
    EXPECT_EQ(draft_->values().columns, built.columns);
    EXPECT_EQ(draft_->value("panel", "rotation_deg"), "270");
  }
}

TEST_F(SetUp, FindsStepsThatAreFarOff) {
  struct Case {
    double lead;
    std::uint32_t microsteps;
    bool reversed;
  };
  for (const Case& one : {Case{4, 256, false}, {4, 1, true}, {5, 16, true}, {8, 16, false}, {2.5, 16, false}}) {
    BoardFile built = board("rig");
    built.machine->rotation_distance_mm = one.lead;
    built.machine->microsteps = one.microsteps;
    built.machine->wiring.direction.active_low = one.reversed;
    begin("rig", built);
    ASSERT_TRUE(draft_->set("z_stage", "microsteps", "16", ""));
    // Room for the longest jog: steps that are sixteen times as long as the draft says take a jog of 1 mm 16 mm far.
    ASSERT_TRUE(draft_->set("z_stage", "end_stop_height_mm", "150", ""));
    built_.machine->end_stop_height_mm = 150;
    const Status done = measure_stage(person_, *draft_, open_);
    ASSERT_TRUE(done) << done.error().message() << person_.said;
    const auto found = draft_->board();
    ASSERT_TRUE(found) << found.error().message();
    EXPECT_NEAR(found->machine->step_mm() / built.machine->step_mm(), 1, 1e-9)
        << one.lead << " mm, " << one.microsteps << "\n"
        << person_.said;
    EXPECT_EQ(found->machine->wiring.direction.active_low, one.reversed);
  }
}

TEST_F(SetUp, MeasuresTheLampByACuredSheet) {
  BoardFile built = board("rig");
  built.machine->power_mw_cm2 = 2.2;
  begin("rig", built);
  person_.answers = {{"lamp.how", "sheet"}, {"lamp.seconds", "20"}, {"lamp.light", "yes"}};
  person_.before = [this](const std::string& question) {
    if (question != "lamp.thickness") return;
    const double dose = 2.2 * 20;
    const double mm = profile_.penetration_depth * std::log(dose / profile_.critical_energy);
    person_.answers["lamp.thickness"] = std::to_string(std::round(mm * 100) / 100);
  };
  const Status done = measure_lamp(person_, *draft_, open_, profile_);
  ASSERT_TRUE(done) << done.error().message();
  EXPECT_NEAR(draft_->values().machine->power_mw_cm2, 2.2, 0.1);
}

TEST_F(SetUp, LightsNothingWithoutAYesAndNeverForLong) {
  begin("rig", board("rig"));
  person_.answers = {{"lamp.how", "meter"}, {"lamp.light", "no"}};
  person_.before = [this](const std::string& question) {
    if (question == "look.corners" || question == "lamp.light") {
      EXPECT_FALSE(witness_->light());
    }
  };
  ASSERT_TRUE(measure_panel(person_, *draft_, open_));
  ASSERT_TRUE(measure_lamp(person_, *draft_, open_, profile_));
  EXPECT_EQ(draft_->values().machine->power_mw_cm2, 3.5) << "not measured, so as before";
  // A person who keeps asking for light gets single flashes with a question each, and an end.
  person_.answers = {{"look.corners", "light"}, {"look.light", "yes"}};
  const Status lit = measure_panel(person_, *draft_, open_);
  EXPECT_FALSE(lit);
  EXPECT_EQ(lit.error().code(), ErrorCode::kCancelled);
  EXPECT_EQ(std::count(person_.asked.begin(), person_.asked.end(), "look.light"), 10);
}

TEST_F(SetUp, StopsForAButton) {
  begin("rig", board("rig"));
  person_.before = [this](const std::string& question) {
    if (question == "look.corners") witness_->press(EventKind::kCancelPressed);
  };
  const Status stopped = measure_panel(person_, *draft_, open_);
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code(), ErrorCode::kCancelled);
  EXPECT_THAT(stopped.error().message(), HasSubstr("cancel pressed"));
  EXPECT_EQ(draft_->value("panel", "mirror"), "none") << "nothing was taken over";
}

TEST_F(SetUp, StopsForAButtonInAMoveAndInLight) {
  begin("rig", board("rig"));
  faults_ = {"button.cancel@t=0.5s"};
  const Status moved = measure_stage(person_, *draft_, open_);
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().code(), ErrorCode::kCancelled) << moved.error().message();
  EXPECT_EQ(person_.asked.back(), "end_stop.right") << "it ended in the first jog";
  faults_ = {"button.cancel@t=5s"};
  person_.answers = {{"lamp.how", "sheet"}, {"lamp.seconds", "20"}, {"lamp.light", "yes"}};
  const Status lit = measure_lamp(person_, *draft_, open_, profile_);
  ASSERT_FALSE(lit);
  EXPECT_EQ(lit.error().code(), ErrorCode::kCancelled) << lit.error().message();
  EXPECT_EQ(person_.asked.back(), "lamp.light");
}

TEST_F(SetUp, TurnsTheLampOffAtOnceWhenInterrupted) {
  for (const int signal : {SIGINT, SIGTERM}) {
    SCOPED_TRACE(signal);
    catch_interrupts();
    begin("rig", board("rig"));
    interrupt_in_light(signal);
    person_.answers = {{"lamp.how", "sheet"}, {"lamp.seconds", "20"}, {"lamp.light", "yes"}};
    const Status lit = measure_lamp(person_, *draft_, open_, profile_);
    ASSERT_FALSE(lit);
    EXPECT_EQ(lit.error().code(), ErrorCode::kCancelled);
    EXPECT_THAT(lit.error().message(), HasSubstr("interrupted: the lamp is dark, the plate stands"));
    EXPECT_TRUE(was_lit_) << "the signal came while the lamp was lit";
    EXPECT_FALSE(light_at_end_);
    EXPECT_LE(noticed_at_ - interrupted_at_, std::chrono::milliseconds(10));
    EXPECT_EQ(height_at_end_, height_);
    EXPECT_EQ(person_.asked.back(), "lamp.light") << "nothing was asked after it";
  }
  catch_interrupts();
}

TEST_F(SetUp, NeverSaysThatTheLampIsDarkWhileItIsLit) {
  catch_interrupts();
  begin("rig", board("rig"));
  interrupt_in_light(SIGINT);
  faults_ = {"lamp.stuck_on@t=0s"};
  person_.answers = {{"lamp.how", "sheet"}, {"lamp.seconds", "20"}, {"lamp.light", "yes"}};
  const Status lit = measure_lamp(person_, *draft_, open_, profile_);
  ASSERT_FALSE(lit);
  EXPECT_EQ(lit.error().code(), ErrorCode::kLampStuckOn) << lit.error().message();
  EXPECT_TRUE(was_lit_);
  catch_interrupts();
}

TEST_F(SetUp, AsksAgainWhatCannotBe) {
  begin("rig", board("rig"));
  const auto refusal = [&](const std::string& name, const std::string& answer) {
    person_.refused.clear();
    person_.answers = {{name, answer}};
    EXPECT_FALSE(ask_about_printer(person_, *draft_, "mine")) << name;
    return person_.refused;
  };
  EXPECT_EQ(refusal("panel.columns", "0"), "found an integer 0, allowed is an integer from 1 to 16384 pixels");
  EXPECT_THAT(refusal("panel.columns", "9\nrows = 5"), HasSubstr("one line"));
  EXPECT_THAT(refusal("panel.packing", "bgr"), HasSubstr("one of the strings none or rgb"));
  EXPECT_THAT(refusal("z_stage.end_stop_height_mm", "2"), HasSubstr("at least travel_mm + 1"));
  EXPECT_THAT(refusal("z_stage.travel_mm", "\"20\" # tall"), HasSubstr("a number from 1 to 2000 mm"));
  EXPECT_THAT(refusal("step_line", "GPIO17 up"), HasSubstr("GPIO17 low pull-up"));
  EXPECT_THAT(refusal("step_line", "none"), HasSubstr("no printer works without it"));
  EXPECT_THAT(refusal("step_line", "chip 2000"), HasSubstr("from 0 to 1023"));
  EXPECT_THAT(refusal("resin_sensor", "lm75"), HasSubstr("hwmon NAME"));
  EXPECT_THAT(refusal("printer.language", "fr"), HasSubstr("one of the strings en or de"));
  EXPECT_THAT(refusal("screen", "HDMI-A-1"), HasSubstr("SPI-1 320x240 90 16-bit"));
  EXPECT_THAT(refusal("screen", "HDMI-A-1 DSI-1 800x480"), HasSubstr("a screen is its connector and its size"));
  EXPECT_THAT(refusal("screen", "HDMI-A-1 100x480"), HasSubstr("320"));
  EXPECT_EQ(draft_->line("step_line"), "9030000.pl061 0") << "as before";
  EXPECT_THAT(refusal("print.profile", "none"), HasSubstr("none"));
  EXPECT_THAT(refusal("z_stage.travel_mm", "60"), HasSubstr("at least travel_mm + 1"))
      << "the end stop's height that is offered does not go with it";
}

TEST_F(SetUp, TakesEachKindOfWiring) {
  begin("rig", board("rig"));
  person_.answers = {
      {"step_line", "GPIO17 low pull-up"}, {"start_button", "none"},
      {"lamp_sensor", "hwmon tmp102 2"},   {"board_sensor", "zone cpu-thermal"},
      {"lamp_fan", "pwm pwmchip0 0"},      {"screen", "320x240 SPI-1 /dev/input/by-path/touch-event 90 16-bit"}};
  ASSERT_TRUE(ask_about_printer(person_, *draft_, "mine")) << person_.refused;
  const auto found = draft_->board();
  ASSERT_TRUE(found) << found.error().message();
  const Wiring& wiring = found->machine->wiring;
  EXPECT_EQ(wiring.step.name, "GPIO17");
  EXPECT_TRUE(wiring.step.chip.empty());
  EXPECT_TRUE(wiring.step.active_low);
  EXPECT_EQ(wiring.step.bias, LineBias::kPullUp);
  EXPECT_FALSE(wiring.start_button.given());
  EXPECT_EQ(wiring.thermals.sensors[0].channel, 2U);
  EXPECT_EQ(wiring.thermals.sensors[2].thermal_zone, "cpu-thermal");
  EXPECT_EQ(wiring.thermals.fans[0].pwm_chip, "pwmchip0");
  EXPECT_EQ(wiring.thermals.fans[0].channel, 0U);
  EXPECT_EQ(wiring.screen.connector, "SPI-1");
  EXPECT_EQ(wiring.screen.columns, 320U);
  EXPECT_EQ(wiring.screen.rows, 240U);
  EXPECT_EQ(wiring.screen.rotation_deg, 90U);
  EXPECT_EQ(wiring.screen.bits, 16U);
  EXPECT_EQ(wiring.screen.touch, "/dev/input/by-path/touch-event");
  EXPECT_EQ(draft_->screen(), "SPI-1 320x240 90 16-bit /dev/input/by-path/touch-event");
  ASSERT_TRUE(draft_->set_screen("HDMI-A-1 800x480", "")) << "what the first had and this one lacks goes";
  EXPECT_EQ(draft_->screen(), "HDMI-A-1 800x480");
  ASSERT_TRUE(draft_->set_screen("none", ""));
  EXPECT_FALSE(draft_->values().machine->wiring.screen.given());
  EXPECT_TRUE(draft_->board());
}

TEST_F(SetUp, AsksForLanguagePageScreenAndStartAndWritesWhatWasSaid) {
  begin("rpi4_dxq608", board("rpi4_dxq608"));
  ASSERT_TRUE(ask_about_printer(person_, *draft_, "mine")) << person_.refused;
  for (const char* const name : {"printer.language", "printer.page", "screen", "print.start"}) {
    EXPECT_THAT(person_.asked, ::testing::Contains(std::string(name)));
  }
  const std::string as_offered = draft_->text();
  EXPECT_THAT(as_offered, HasSubstr("\nlanguage = \"en\" "));
  EXPECT_THAT(as_offered, HasSubstr("\npage = \"off\" "));
  EXPECT_THAT(as_offered, HasSubstr("\nstart = \"on_request\" "));
  EXPECT_THAT(as_offered, Not(HasSubstr("[screen]")));
  person_.answers = {{"printer.language", "de"},
                     {"printer.page", "network"},
                     {"screen", "HDMI-A-1 800x480"},
                     {"print.start", "after_preview"}};
  ASSERT_TRUE(ask_about_printer(person_, *draft_, "mine")) << person_.refused;
  const auto found = draft_->board();
  ASSERT_TRUE(found) << found.error().message();
  EXPECT_EQ(found->machine->language, Language::kGerman);
  EXPECT_EQ(found->machine->page, PageChoice::kNetwork);
  EXPECT_EQ(found->machine->start, StartChoice::kAfterPreview);
  EXPECT_EQ(found->machine->wiring.screen.columns, 800U);
}

TEST_F(SetUp, KeepsALampMapOnTheWayThroughItsText) {
  const std::string path = testing::TempDir() + "sim2k.toml";
  auto text = read_settings_text(kBoards + "sim2k.toml", "a board file").value();
  std::ofstream(path) << text.replace(text.find("grey_levels"), 0, "lamp_map = [[3, 3.25, 3.5], [3.1, 3.4, 3]]\n");
  const auto draft = BoardDraft::like(path);
  ASSERT_TRUE(draft) << draft.error().message();
  EXPECT_THAT(draft->text(), HasSubstr("\nlamp_map = [[3, 3.25, 3.5], [3.1, 3.4, 3]] # as sim2k\n"));
  const auto again = draft->board();
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_THAT(again->machine->panel.lamp.all(), testing::ElementsAre(3, 3.25, 3.5, 3.1, 3.4, 3));
}

TEST_F(SetUp, KeepsEveryBoardFileOnTheWayThroughItsText) {
  for (const char* const name : {"rpi4_dxq608", "pine64_ls055", "rig", "mono8k", "sim2k"}) {
    const auto draft = BoardDraft::like(kBoards + name + ".toml");
    ASSERT_TRUE(draft) << draft.error().message();
    const auto again = draft->board();
    ASSERT_TRUE(again) << again.error().message() << draft->text();
    BoardFile before = board(name), after = *again;
    const auto rules = board_rules(before, *before.machine);
    const auto others = board_rules(after, *after.machine);
    BoardDraft copy = *draft;
    for (const SettingRule& rule : rules) {
      EXPECT_EQ(copy.value(rule.table, rule.key), draft->value(rule.table, rule.key));
    }
    EXPECT_EQ(after.machine->wiring.lamp.name, before.machine->wiring.lamp.name);
    EXPECT_EQ(after.machine->wiring.end_stop.bias, before.machine->wiring.end_stop.bias);
    EXPECT_EQ(after.machine->wiring.display.refresh_hz, before.machine->wiring.display.refresh_hz);
    EXPECT_EQ(after.machine->step_mm(), before.machine->step_mm());
    EXPECT_EQ(after.pixel_pitch_x_mm, before.pixel_pitch_x_mm);
  }
}

TEST(WrittenAnswersFile, NamesFileAndLineOfWhatIsWrong) {
  const auto parsed = WrittenAnswers::parse("# mine\npanel.columns = 1440\n", "answers.txt");
  ASSERT_TRUE(parsed);
  const Question question{"panel.rows", "pixels along y", "an integer", ""};
  const auto asked = (*parsed)->ask(question, [](const std::string&) { return Status(); });
  ASSERT_FALSE(asked);
  EXPECT_STREQ(asked.error().message(), "answers.txt: no answer to panel.rows: pixels along y. Allowed is an integer");
  EXPECT_THAT((*parsed)->check_all_used().error().message(), HasSubstr("answers.txt:2: nobody asked panel.columns"));
  const Question columns{"panel.columns", "pixels along x", "", ""};
  const auto wrong =
      (*parsed)->ask(columns, [](const std::string&) -> Status { return fail(ErrorCode::kBadSetting, "too many"); });
  EXPECT_STREQ(wrong.error().message(), "answers.txt:2: panel.columns: too many");
  EXPECT_TRUE((*parsed)->check_all_used());
  EXPECT_THAT(WrittenAnswers::parse("a = 1\na = 2\n", "x").error().message(), HasSubstr("x:2: a is answered twice"));
  EXPECT_THAT(WrittenAnswers::parse("words", "x").error().message(), HasSubstr("x:1: expected a line such as"));
  EXPECT_TRUE(WrittenAnswers::parse("", "x"));
}

TEST(PanelLook, RefusesWhatNoPanelShows) {
  const PanelLayout sent{300, 200};
  int shown = 0;
  CornerSquares seen{1, 2, 3, 4};
  std::sort(seen.begin(), seen.end());
  do {
    if (layout_for(sent, seen)) ++shown;
  } while (std::next_permutation(seen.begin(), seen.end()));
  EXPECT_EQ(shown, 8);
  EXPECT_FALSE(layout_for(sent, {1, 1, 1, 1}));
}

TEST(StageTrial, ExplainsATravelByJumpersBeforeScrews) {
  const Drive drive{4, 200, 16, false};
  EXPECT_EQ(drive_for(drive, 5_mm, 5.1)->microsteps, 16U) << "a caliper's error";
  EXPECT_EQ(drive_for(drive, 5_mm, 10.2)->microsteps, 8U);
  EXPECT_EQ(drive_for(drive, 5_mm, -0.6)->microsteps, 128U);
  EXPECT_TRUE(drive_for(drive, 5_mm, -0.6)->direction_active_low);
  EXPECT_EQ(drive_for(drive, 5_mm, 6.3)->rotation_distance_mm, 5);
  EXPECT_EQ(drive_for(drive, 10_mm, 14.8)->rotation_distance_mm, 5.92) << "no usual lead: what was measured";
  EXPECT_FALSE(drive_for(drive, 5_mm, 0));
  EXPECT_FALSE(drive_for(drive, 5_mm, std::nan("")));
}

}  // namespace
}  // namespace plumbline::firmware
