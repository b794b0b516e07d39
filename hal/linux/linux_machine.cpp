#include "hal/linux/linux_machine.hpp"

#include <algorithm>

#include "hal/linux/events/real_time.hpp"
#include "hal/linux/lamp/gpio_keeper_lines.hpp"

namespace plumbline {

std::vector<BoardLines::Line> lines_of(const LinuxSettings& settings) {
  std::vector<BoardLines::Line> lines;
  const auto add = [&](const LineSettings& line, const char* use) { lines.push_back({&line, use, {}}); };
  add(settings.lamp_line, "the lamp");
  add(settings.cover, "the cover");
  add(settings.step, "the stage's step");
  add(settings.direction, "the stage's direction");
  add(settings.enable, "the stage's enable");
  add(settings.end_stop, "the end stop");
  add(settings.start_button, "the start button");
  add(settings.pause_button, "the pause button");
  add(settings.cancel_button, "the cancel button");
  constexpr std::array kLights = {"the ready light", "the printing light", "the attention light", "the fault light"};
  for (std::size_t i = 0; i < kPanelLightCount; ++i) add(settings.lights[i], kLights[i]);
  add(settings.buzzer, "the buzzer");
  return lines;
}

Expected<BoardLines> BoardLines::find(const LinuxSettings& settings) {
  BoardLines found;
  LineRegistry registry;
  for (auto& line : lines_of(settings)) {
    if (!line.settings->given()) {
      for (const auto* needed : {&settings.lamp_line, &settings.step, &settings.direction, &settings.end_stop}) {
        if (line.settings == needed) {
          return fail(ErrorCode::kBadSetting, "the board file gives no line for %s", line.use.c_str());
        }
      }
      continue;
    }
    auto place = find_line(*line.settings, line.use);
    PLUMBLINE_TRY(place);
    line.place = std::move(*place);
    PLUMBLINE_TRY(registry.claim(line.place, line.use));
    found.all.push_back(std::move(line));
  }
  return found;
}

const BoardLines::Line* BoardLines::of(const LineSettings& settings) const {
  const auto line = std::find_if(all.begin(), all.end(), [&](const Line& one) { return one.settings == &settings; });
  return line == all.end() ? nullptr : &*line;
}

/// A ZStage is no EventSource, but has news.
class LinuxMachine::StageSource final : public EventSource {
 public:
  StageSource(LinuxZStage& stage, EventQueue& queue) : stage_(stage), queue_(queue) {}
  int descriptor() const override { return stage_.descriptor(); }
  void drain(std::chrono::nanoseconds /*now*/) override { stage_.drain(queue_); }

 private:
  LinuxZStage& stage_;
  EventQueue& queue_;
};

namespace {

Expected<OutputLine> output(const BoardLines::Line& line, bool on) {
  return OutputLine::open(line.place, *line.settings, line.use, on);
}

Expected<InputLine> input(const BoardLines::Line& line) {
  return InputLine::open(line.place, *line.settings, line.use);
}

}  // namespace

Status LinuxMachine::open_lamp(const LinuxSettings& settings, const BoardLines& lines) {
  const auto& lamp = *lines.of(settings.lamp_line);
  const auto* const cover = lines.of(settings.cover);
  auto keeper = LampKeeper::start(settings.keeper, line_option(lamp.place, *lamp.settings),
                                  cover == nullptr ? "" : line_option(cover->place, *cover->settings));
  if (!keeper) {
    // It says on standard error why; most often the line is why, and that can be said better here.
    auto tried = output(lamp, false);
    return tl::unexpected<Error>(tried ? keeper.error() : tried.error());
  }
  // Held for good, should the keeper end: a line that nobody holds has no level.
  auto hold_dark = [place = lamp.place, wire = *lamp.settings, use = lamp.use,
                    held = std::make_shared<std::optional<OutputLine>>()] {
    auto line = OutputLine::open(place, wire, use, false);
    if (line) held->emplace(std::move(*line));
  };
  watch_ = std::make_unique<LampWatch>(std::move(*keeper), queue_, cover != nullptr, std::move(hold_dark));
  lamp_ = std::make_unique<LinuxUvLamp>(settings.lamp, *watch_, interlock_, clock_);
  events_.add(*watch_);
  return {};
}

Status LinuxMachine::open_stage(const LinuxSettings& settings, const BoardLines& lines) {
  auto step = output(*lines.of(settings.step), false);
  PLUMBLINE_TRY(step);
  auto direction = output(*lines.of(settings.direction), true);
  PLUMBLINE_TRY(direction);
  std::optional<OutputLine> enable;
  if (const auto* const line = lines.of(settings.enable)) {
    auto opened = output(*line, false);
    PLUMBLINE_TRY(opened);
    enable.emplace(std::move(*opened));
  }
  auto end_stop = input(*lines.of(settings.end_stop));
  PLUMBLINE_TRY(end_stop);
  stage_lines_ = std::make_unique<GpioStageLines>(std::move(*step), std::move(*direction), std::move(enable),
                                                  std::move(*end_stop));
  stage_ = std::make_unique<LinuxZStage>(settings.travel, settings.mechanics, *stage_lines_, interlock_);
  stage_source_ = std::make_unique<StageSource>(*stage_, queue_);
  events_.add(*stage_source_);
  return {};
}

Status LinuxMachine::open_panel(const LinuxSettings& settings, const BoardLines& lines) {
  LinuxFrontPanel::Lines outputs;
  for (std::size_t i = 0; i < kPanelLightCount; ++i) {
    if (const auto* const line = lines.of(settings.lights[i])) {
      auto opened = output(*line, false);
      PLUMBLINE_TRY(opened);
      outputs.lights[i].emplace(std::move(*opened));
    }
  }
  if (const auto* const line = lines.of(settings.buzzer)) {
    auto opened = output(*line, false);
    PLUMBLINE_TRY(opened);
    outputs.buzzer.emplace(std::move(*opened));
  }
  panel_ = std::make_unique<LinuxFrontPanel>(std::move(outputs), *watch_, interlock_);
  events_.add(*panel_);
  for (const auto& [button, kind] : {std::pair{&settings.start_button, EventKind::kStartPressed},
                                     {&settings.pause_button, EventKind::kPausePressed},
                                     {&settings.cancel_button, EventKind::kCancelPressed}}) {
    const auto* const line = lines.of(*button);
    if (line == nullptr) continue;
    auto opened = input(*line);
    PLUMBLINE_TRY(opened);
    buttons_.push_back(std::make_unique<Button>(std::move(*opened), kind, queue_));
    events_.add(*buttons_.back());
  }
  return {};
}

Expected<std::unique_ptr<LinuxMachine>> LinuxMachine::open(const LinuxSettings& settings) {
  PLUMBLINE_TRY(settings.panel.check());
  const auto lines = BoardLines::find(settings);
  PLUMBLINE_TRY(lines);
  std::unique_ptr<LinuxMachine> machine(new LinuxMachine());
  machine->events_.add(machine->shutdown_);
  machine->memory_locked_ = lock_memory();
  hold_heap();
  PLUMBLINE_TRY(machine->open_lamp(settings, *lines));
  PLUMBLINE_TRY(machine->open_stage(settings, *lines));
  PLUMBLINE_TRY(machine->open_panel(settings, *lines));
  auto thermals = LinuxThermals::open(settings.thermals, settings.sysfs);
  PLUMBLINE_TRY(thermals);
  machine->thermals_ = std::make_unique<LinuxThermals>(std::move(*thermals), machine->interlock_);
  auto display = KmsPanel::open(settings.display, settings.panel.mode_width(), settings.panel.mode_height());
  PLUMBLINE_TRY(display);
  machine->mask_ =
      std::make_unique<LinuxMaskDisplay>(settings.panel, std::move(*display), settings.settling, machine->interlock_);
  machine->stick_ = std::make_unique<LinuxStickPort>(settings.stick, machine->queue_, machine->interlock_);
  PLUMBLINE_TRY(machine->stick_->open());
  machine->events_.add(*machine->stick_);
  machine->events_.forget();
  return machine;
}

/// Dark before the panel goes back to the console.
LinuxMachine::~LinuxMachine() {
  if (lamp_) lamp_->darken();
}

Machine LinuxMachine::machine() {
  return {.clock = clock_,
          .events = events_,
          .mask = *mask_,
          .lamp = *lamp_,
          .stage = *stage_,
          .stick = *stick_,
          .panel = *panel_,
          .thermals = *thermals_};
}

}  // namespace plumbline
