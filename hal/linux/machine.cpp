#include "hal/linux/machine.hpp"

#include <algorithm>

#include "hal/linux/keeper/gpio_keeper_lines.hpp"
#include "hal/process/process_memory.hpp"

namespace plumbline::inline hal::inline linux_board {

Expected<BoardLines> BoardLines::find(const Wiring& wiring) {
  BoardLines found;
  LineRegistry registry;
  Status problem;
  for_each_line(wiring, [&](const LineRole& role, const LineSettings& settings) {
    if (problem && (role.required || settings.given())) problem = found.add(role, settings, registry);
  });
  PLUMBLINE_TRY(problem);
  return found;
}

Status BoardLines::add(const LineRole& role, const LineSettings& settings, LineRegistry& registry) {
  if (!settings.given()) return fail(ErrorCode::kBadSetting, "the board file gives no line for %s", role.use);
  auto place = find_line(settings, role.use);
  PLUMBLINE_TRY(place);
  PLUMBLINE_TRY(registry.claim(*place, role.use));
  all_.push_back({&settings, role.use, std::move(*place)});
  return {};
}

const BoardLines::Line* BoardLines::of(const LineSettings& settings) const {
  const auto line = std::find_if(all_.begin(), all_.end(), [&](const Line& one) { return one.settings == &settings; });
  return line == all_.end() ? nullptr : &*line;
}

/// Adapts the stage, which is no EventSource.
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
  const auto& lamp = *lines.of(settings.wiring.lamp);
  const auto* const cover = lines.of(settings.wiring.cover);
  LampKeeper::Settings keeper{.program = settings.keeper,
                              .line = line_option(lamp.place, *lamp.settings),
                              .cover = cover == nullptr ? "" : line_option(cover->place, *cover->settings),
                              .watchdog = settings.wiring.watchdog.device,
                              .watchdog_timeout = std::chrono::seconds(settings.wiring.watchdog.timeout_s),
                              .limits = {settings.lamp.longest_exposure, settings.lamp.per_minute}};
  auto watch = LampWatch::start(std::move(keeper), queue_);
  if (!watch) {
    // The keeper writes the reason to standard error. Usually it is the line, for which this gives a better message.
    auto tried = output(lamp, false);
    return tl::unexpected<Error>(tried ? watch.error() : tried.error());
  }
  watch_ = std::move(*watch);
  lamp_ = std::make_unique<LinuxUvLamp>(settings.lamp, *watch_, interlock_, clock_);
  events_.add(*watch_);
  return {};
}

Status LinuxMachine::open_stage(const LinuxSettings& settings, const BoardLines& lines) {
  auto step = output(*lines.of(settings.wiring.step), false);
  PLUMBLINE_TRY(step);
  auto direction = output(*lines.of(settings.wiring.direction), true);
  PLUMBLINE_TRY(direction);
  std::optional<OutputLine> enable;
  if (const auto* const line = lines.of(settings.wiring.enable)) {
    auto opened = output(*line, false);
    PLUMBLINE_TRY(opened);
    enable.emplace(std::move(*opened));
  }
  auto end_stop = input(*lines.of(settings.wiring.end_stop));
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
    if (const auto* const line = lines.of(settings.wiring.lights[i])) {
      auto opened = output(*line, false);
      PLUMBLINE_TRY(opened);
      outputs.lights[i].emplace(std::move(*opened));
    }
  }
  if (const auto* const line = lines.of(settings.wiring.buzzer)) {
    auto opened = output(*line, false);
    PLUMBLINE_TRY(opened);
    outputs.buzzer.emplace(std::move(*opened));
  }
  panel_ = std::make_unique<LinuxFrontPanel>(std::move(outputs), *watch_, interlock_);
  events_.add(*panel_);
  for (const auto& [button, kind] : {std::pair{&settings.wiring.start_button, EventKind::kStartPressed},
                                     {&settings.wiring.pause_button, EventKind::kPausePressed},
                                     {&settings.wiring.cancel_button, EventKind::kCancelPressed}}) {
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
  const auto lines = BoardLines::find(settings.wiring);
  PLUMBLINE_TRY(lines);
  std::unique_ptr<LinuxMachine> machine(new LinuxMachine());
  machine->events_.add(machine->shutdown_);
  machine->memory_locked_ = lock_memory(Untouched::kLeave);
  reserve_heap();
  PLUMBLINE_TRY(machine->open_lamp(settings, *lines));
  PLUMBLINE_TRY(machine->open_stage(settings, *lines));
  PLUMBLINE_TRY(machine->open_panel(settings, *lines));
  auto thermals = LinuxThermals::open(settings.wiring.thermals, settings.sysfs);
  PLUMBLINE_TRY(thermals);
  machine->thermals_ = std::make_unique<LinuxThermals>(std::move(*thermals), machine->interlock_);
  auto display = KmsPanel::open(settings.wiring.display, settings.panel.mode_width(), settings.panel.mode_height());
  PLUMBLINE_TRY(display);
  const CardInUse card = display->card();
  machine->mask_ =
      std::make_unique<LinuxMaskDisplay>(settings.panel, std::move(*display), settings.settling, machine->interlock_);
  if (settings.wiring.screen.given()) {
    auto screen = LinuxStatusScreen::open(settings.wiring.screen, card, machine->clock_);
    PLUMBLINE_TRY(screen);
    machine->screen_ = std::move(*screen);
  }
  machine->stick_ = std::make_unique<LinuxStickPort>(settings.wiring.stick, settings.mount_socket, machine->queue_,
                                                     machine->interlock_);
  PLUMBLINE_TRY(machine->stick_->open());
  machine->events_.add(*machine->stick_);
  machine->events_.discard_pending();
  return machine;
}

/// Turns the lamp off before the panel shows the console again.
LinuxMachine::~LinuxMachine() {
  if (lamp_) lamp_->turn_off();
}

Machine LinuxMachine::machine() {
  return {.clock = clock_,
          .events = events_,
          .mask = *mask_,
          .lamp = *lamp_,
          .stage = *stage_,
          .stick = *stick_,
          .panel = *panel_,
          .thermals = *thermals_,
          .screen = screen_.get()};
}

}  // namespace plumbline::inline hal::inline linux_board
