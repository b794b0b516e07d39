#include "firmware/daemon/daemon_command_line.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>

#include "firmware/daemon/printer_daemon.hpp"
#include "firmware/daemon/service/service_events.hpp"
#include "firmware/daemon/service/service_manager.hpp"
#include "firmware/daemon/service/service_status.hpp"
#include "firmware/io/interrupt.hpp"
#include "firmware/io/progress_lines.hpp"
#include "firmware/io/token_bucket.hpp"
#include "firmware/io/version.hpp"
#include "firmware/io/wall_clock.hpp"
#include "firmware/machine/back_end.hpp"
#include "firmware/pictures/png.hpp"
#include "firmware/print/job/kept_prints.hpp"
#include "firmware/print/job/machine_record.hpp"
#include "firmware/print/print_summary.hpp"
#include "firmware/print/status/print_lines.hpp"
#include "firmware/screen/screen_server.hpp"
#include "firmware/settings/job_options.hpp"
#include "firmware/settings/settings_folders.hpp"
#include "firmware/state/picture_line.hpp"
#include "firmware/state/socket_place.hpp"
#include "hal/process/process_memory.hpp"

namespace plumbline::firmware {
namespace {

constexpr const char* kAbout =
    "The printer's daemon: waits for a stick, prints its job, reports, and waits for the next.\n"
    "\n"
    "A stick's job is its job.toml, the only scan on it, or the scan that the user chooses with the buttons.\n"
    "It is printed when start is pressed, or by 'plumbline ctl start'. After a print the daemon waits until start is\n"
    "pressed for the empty plate. 'plumbline status' shows what it is doing.\n"
    "The journal is kept in --state: after a power cut the print resumes when start is pressed.\n";

constexpr const char* kFooter =
    "\nExamples:\n"
    "  plumblined --printer board/sim2k.toml --state state --stick stick      creating the folder plugs the stick in\n"
    "  plumbline status --socket state/state                                  what it is doing, and what it waits for\n"
    "  plumbline ctl start --socket state/state                               print what is on the stick\n"
    "\n"
    "SIGTERM ends it in order: the lamp goes dark, the part is lifted, and the print can resume later.\n";

struct DaemonOptions {
  std::string printer;
  std::string state = "/var/lib/plumbline";
  std::string socket;      ///< of the printer's state; empty: see socket_path()
  std::uint32_t jobs = 0;  ///< end after this many prints; 0: never
  SimulationOptions simulation;
};

bool is_folder(const std::string& path) {
  struct stat facts {};
  return !path.empty() && ::stat(path.c_str(), &facts) == 0 && S_ISDIR(facts.st_mode);
}

/// Where the printer's state is served. A simulated printer needs no folder that only root can make.
std::string socket_path(const DaemonOptions& options, const MachineFile& machine) {
  if (!options.socket.empty()) return options.socket;
  const bool named = !machine.state_socket.empty() && !options.simulation.simulate;
  if (named) return machine.state_socket;
  if (machine.simulated || options.simulation.simulate) return options.state + "/state";
  return kStateSocket;
}

std::string report_path(const DaemonOptions& options) { return options.state + "/report.json"; }

/// Logs to standard error and the service manager, writes reports, and plugs the simulated stick in and out.
class DaemonLog final : public DaemonObserver {
 public:
  /// @param prints   gets the report of each print
  /// @param record   has the preview
  /// @param encoder  for a preview
  DaemonLog(const DaemonOptions& options, BackEnd& back_end, ServiceManager& manager, KeptPrints& prints,
            const PrinterRecord& record, PictureEncoder encoder)
      : options_(options),
        back_end_(back_end),
        witness_(back_end.witness()),
        manager_(manager),
        prints_(prints),
        record_(record),
        encoder_(std::move(encoder)) {}

  void say(const PrintableText& text) override {
    FixedText<PrintableText::kCapacity + 16> line;
    if (log_bound_.takes_line(std::chrono::steady_clock::now())) {
      if (const unsigned left_out = log_bound_.take_left_out(); left_out > 0) {
        line.add("plumblined: %u lines are left out", left_out);
        write_line(line.view());
        line.clear();
      }
      line.add("plumblined: %s", text.c_str());
      write_line(line.view());
    }
    manager_.status(text.view() == "ready" ? "ready: waiting for a stick" : text);
  }
  bool update(const PrintStatus& status) override {
    look_around();
    static_cast<void>(lines_.update(status));
    manager_.status(status_text(status).view());
    return true;
  }
  void checked(Check check, const CheckResult& result) override { lines_.checked(check, result); }
  void begins(const Contract& contract) override {
    for_each_contract_line(contract, [](std::string_view line) { write_line(line); });
  }
  void printed(const PrintReport& report, const PrintSession& session, const PrintProfile& profile) override {
    lines_.clear();
    manager_.status(service_status(report).view());
    std::vector<std::string> objections;
    if (witness_ != nullptr) {
      if (report.state == PrintState::kFinished || report.state == PrintState::kCancelled)
        witness_->conclude(report.state == PrintState::kFinished);
      objections = witness_->objections();
      // Those of earlier prints are in their reports.
      objections.erase(objections.begin(), objections.begin() + static_cast<std::ptrdiff_t>(objections_told_));
      objections_told_ += objections.size();
    }
    const PrintOutcome outcome{report,
                               session,
                               profile,
                               objections,
                               back_end_.take_step_figures(),
                               witness_ != nullptr ? std::optional(witness_->part_figures()) : std::nullopt};
    OutputFile out = OutputFile::standard_output();
    // The part is on the plate, so a report that can't be written is only logged.
    if (const auto told = write_print_summary(out, outcome, report_path(options_), false); !told)
      say(told.error().message());
    const auto write = [&outcome](TextSink& to) {
      JsonWriter json(to);
      write_print_report(json, outcome);
      return json.finish();
    };
    if (const auto kept = write_whole_file(report_path(options_).c_str(), write); !kept) say(kept.error().message());
    if (const auto kept = keep(outcome, write); !kept) say(kept.error().message());
    if (++jobs_ == options_.jobs) end();
  }
  void idle() override { look_around(); }
  void plate_emptied() override {
    if (witness_ != nullptr) witness_->take_part_off();
  }
  /// Ends the daemon if a signal has asked for it.
  void look_for_signals() {
    if (interrupted()) end();
  }
  void slicing(Stage stage, double fraction) override {
    look_around();
    const auto name = to_string(stage);
    FixedText<60> text;
    text.add("slicing: %.*s, %.0f %%", static_cast<int>(name.size()), name.data(), 100 * fraction);
    manager_.status(text.view());
  }

 private:
  /// Keeps the report and the preview with those of the prints before.
  /// @param write  writes the report
  Status keep(const PrintOutcome& outcome, FunctionRef<Status(TextSink&)> write) {
    KeptPrint print;
    print.result = static_cast<std::uint32_t>(outcome.report.state);
    print.layers = outcome.report.layers;
    print.layers_done = outcome.report.next_layer;
    print.scan = outcome.session.printable().facts.scan;
    print.profile = outcome.session.printable().facts.profile;
    print.ended_at = wall_clock_s();
    print.resin_ml = outcome.report.resin_ml;
    std::span<const std::byte> png;
    if (record_.pictures != nullptr && record_.pictures->preview.there()) {
      const PreviewPicture& preview = record_.pictures->preview;
      png = encoder_.encode(preview.bytes(), preview.columns, preview.rows, PreviewPicture::kChannels);
      if (png.size() > PictureLine::kMostPng) png = {};
    }
    return prints_.keep(print, write, png);
  }
  void look_around() {
    look_for_signals();
    if (witness_ == nullptr) return;
    const bool there = is_folder(options_.simulation.stick);
    if (there == plugged_) return;
    plugged_ = there;
    if (there) {
      witness_->plug_stick(options_.simulation.stick);
    } else {
      witness_->pull_stick();
    }
  }
  void end() {
    if (ended_) return;
    ended_ = true;
    if (witness_ != nullptr) {
      witness_->press(EventKind::kShutdownRequested);
    } else {
      static_cast<void>(::kill(::getpid(), SIGTERM));  // on a board, SIGTERM becomes the same event
    }
  }

  const DaemonOptions& options_;
  BackEnd& back_end_;
  Witness* witness_;  ///< the back end's
  ServiceManager& manager_;
  KeptPrints& prints_;
  const PrinterRecord& record_;
  PictureEncoder encoder_;
  PrintLines lines_{PrintLines::Show::kPrint, std::nullopt};
  /// A print has some dozens. Whoever gives commands without an end writes one a second.
  LogBound log_bound_{{.burst = 200, .a_second = 1}};
  bool plugged_ = false;
  bool ended_ = false;
  std::uint32_t jobs_ = 0;
  std::size_t objections_told_ = 0;  ///< of the witness's
};

ExitCode serve(const DaemonOptions& options, std::size_t largest_arena) {
  const auto board = read_board_file(options.printer);
  if (!board) return report_error(board.error());
  const auto machine = machine_of(*board, board->path);
  if (!machine) return report_error(machine.error());
  const auto profile = read_print_profile(machine->profile, board->path);
  if (!profile) return report_error(profile.error());
  JobOptions job;
  job.printer = options.printer;
  const auto setup = set_up(job, largest_arena);
  if (!setup) return report_error(setup.error());
  // Before anything is open, so that the child inherits nothing.
  auto child = SlicingChild::make(setup->arena_bytes, setup->threads, run_stick_task);
  if (!child) return report_error(child.error());
  auto store = JobStore::open(options.state);
  if (!store) return report_error(store.error());
  const bool simulated = machine->simulated || options.simulation.simulate;
  auto remembered = open_machine_record(options.state, *store, machine->tank_volume_ml, simulated);
  if (!remembered) return report_error(remembered.error());
  if (remembered->was_damaged()) {
    write_line("plumblined: what the printer remembers was damaged: the plate counts as in use, the resin as unknown");
  }
  auto prints = KeptPrints::open(options.state, [](std::string_view text) {
    FixedText<240> line;
    line.add("plumblined: %.*s", static_cast<int>(text.size()), text.data());
    write_line(line.view());
  });
  if (!prints) return report_error(prints.error());
  auto upload_store = UploadStore::open(options.state, std::uint64_t{machine->upload_mib} << 20U);
  if (!upload_store) return report_error(upload_store.error());
  auto encoder = PictureEncoder::create(sizeof(PreviewPicture::memory));
  if (!encoder) return report_error(encoder.error());
  const auto socket = StateSocket::open(socket_path(options, *machine));
  if (!socket) return report_error(socket.error());
  auto manager = ServiceManager::of_environment();
  if (!manager) return report_error(manager.error());
  SimulationOptions simulation = options.simulation;
  simulation.stick.clear();  // the log plugs it in when its folder is there
  // A damaged journal is reported when the user asks to resume.
  if (const auto progress = store->progress()) {
    simulation.layers_on_plate = progress->last.next_layer;
    simulation.height_on_plate = progress->last.height;
    simulation.plate_at = progress->last.stands;
  }
  auto back_end = open_back_end(*board, *machine, *profile, simulation);
  if (!back_end) return report_error(back_end.error());

  catch_interrupts();
  const DaemonSettings settings{*board,        *machine, board->path, profile_names(board->path), report_path(options),
                                setup->threads};
  Arena arena(child->arena_block());
  PrinterRecord record;
  record.prints = &*prints;
  Uploads uploads(std::move(*upload_store), record);
  DaemonLog log(options, **back_end, *manager, *prints, record, std::move(*encoder));
  const Machine& devices = (*back_end)->machine();
  ServiceEvents events(devices.events, devices.clock, *manager);
  events.at_each_look = [&log] { log.look_for_signals(); };
  Machine watched{.clock = devices.clock,
                  .events = events,
                  .mask = devices.mask,
                  .lamp = devices.lamp,
                  .stage = devices.stage,
                  .stick = devices.stick,
                  .panel = devices.panel,
                  .thermals = devices.thermals,
                  .screen = devices.screen};
  PrinterDaemon daemon(watched, settings, *child, arena, *store, *remembered, log, record, uploads);
  std::optional<ScreenServer> screen;
  if (watched.screen != nullptr) screen.emplace(*watched.screen, machine->language);
  events.serve(**socket, record, daemon.commands(), screen ? &*screen : nullptr, &uploads);
  reserve_heap();  // again: what has been made since the devices were opened has used up the first one
  if (const auto told = manager->ready(); !told) return report_error(told.error());
  const auto served = daemon.run();
  if (!served) return report_error(served.error());
  return daemon.fault() == FaultCode::kNone ? ExitCode::kDone : ExitCode::kWorldError;
}

}  // namespace

ExitCode run_daemon_command_line(int argc, char** argv, std::size_t largest_arena) {
  CLI::App app(kAbout, "plumblined");
  app.set_version_flag("--version", std::string("plumblined ") + kVersion);
  app.footer(kFooter);
  DaemonOptions options;
  options.simulation.speedup = 1;  // a stick is plugged in and out in real time
  app.add_option("--printer", options.printer, "Board file")->required()->type_name("TOML");
  app.add_option("--state", options.state,
                 "Folder for journal, job, the uploaded scan and the last reports [/var/lib/plumbline]")
      ->type_name("DIR");
  app.add_option(
         "--socket", options.socket,
         "Socket that serves the printer's state; beside it, with .command after its name, the one for commands\n"
         "[the board file's, else /run/plumbline/state; simulated: state in the folder --state]")
      ->type_name("PATH");
  app.add_option("--jobs", options.jobs, "End after N prints [never]")->type_name("N");
  constexpr const char* kSimulation = "Simulation";
  app.add_flag("--simulate", options.simulation.simulate, "Simulate the printer even if it is a real one")
      ->group(kSimulation);
  app.add_option("--stick", options.simulation.stick,
                 "Folder that plays the stick: plugged in while the folder exists. Folders named like it with .2, .3, "
                 "... are further partitions")
      ->type_name("DIR")
      ->group(kSimulation);
  app.add_option("--screen", options.simulation.screen,
                 "Folder for what the printer's screen shows: screen.png is the newest picture, 00001.png the first")
      ->type_name("DIR")
      ->group(kSimulation);
  app.add_option("--speedup", options.simulation.speedup, "Simulated seconds per second, 0.1 to 1000000 [1]")
      ->type_name("N")
      ->check(CLI::Range(0.1, 1e6).description(""))
      ->group(kSimulation);
  app.add_option("--lamp-line", options.simulation.lamp_line,
                 "Line that plumbline-keeper switches together with the simulated lamp; file:PATH records the changes")
      ->type_name("LINE")
      ->group(kSimulation);
  app.add_option("--fault", options.simulation.faults,
                 "What goes wrong, such as cover.opens@layer=40,for=5s; may be repeated")
      ->type_name("FAULT")
      ->take_all()
      ->group(kSimulation);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int status = app.exit(error);
    return status == 0 ? ExitCode::kDone : ExitCode::kUsageError;
  }
  return serve(options, largest_arena);
}

}  // namespace plumbline::firmware
