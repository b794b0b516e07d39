#include <fcntl.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <vector>

#include "firmware/cli/commands.hpp"
#include "firmware/cli/options/accepted_values.hpp"
#include "firmware/cli/options/grey_option.hpp"
#include "firmware/cli/options/help_format.hpp"
#include "firmware/cli/options/shared_options.hpp"
#include "firmware/cli/reports/issues_file.hpp"
#include "firmware/cli/reports/printed_part.hpp"
#include "firmware/cli/terminal_job.hpp"
#include "firmware/io/hash64.hpp"
#include "firmware/io/progress_lines.hpp"
#include "firmware/io/scan_files.hpp"
#include "firmware/machine/back_end.hpp"
#include "firmware/messages/told_text.hpp"
#include "firmware/print/job/machine_record.hpp"
#include "firmware/print/print_session.hpp"
#include "firmware/print/print_summary.hpp"
#include "firmware/print/status/print_lines.hpp"
#include "firmware/print/truth/rrep_surface.hpp"
#include "firmware/print/truth/truth_mesh.hpp"
#include "firmware/settings/print_values.hpp"
#include "firmware/slice/issue_report.hpp"
#include "firmware/slice/job_report.hpp"
#include "slicer/core/resin/outline_move.hpp"

namespace plumbline::firmware {
namespace {

/// Virtual time that a print waits for an absent user.
constexpr nanoseconds kNobodyComes = std::chrono::hours(1);
/// The same that it takes to fill the tank.
constexpr nanoseconds kToFill = std::chrono::minutes(1);

constexpr const char* kPrintFooter =
    "\nExamples:\n"
    "  plumbline print bust.ply --printer sim2k                     hours of printing in seconds\n"
    "  plumbline print bust.ply --printer sim2k --keep-part part    and keep the part that came of it\n"
    "  plumbline print bust.stl --printer sim2k --truth bust.stl    and say how far it is off\n"
    "  plumbline print bust.sl1 --printer sim2k                     what another slicer has made for this panel\n"
    "  plumbline print bust.zip --printer sim2k --set exposure_time=3   with another exposure than it says\n"
    "  plumbline print bars.stl --printer sim2k --exposure-test 1.6s,2s,2.4s   which of them the resin needs\n"
    "  plumbline print bust.ply --printer sim2k --fault temperature.lamp_hot@layer=40,for=5s   it waits and goes on\n"
    "  plumbline print bust.ply --printer sim2k --state job --fault power.cut@layer=40\n"
    "  plumbline print --resume --printer sim2k --state job         go on after the power cut\n"
    "\n"
    "Output: what will be done, each value with its source (profile, archive, person), the checks, a line that shows\n"
    "progress, and at the end time, resin and what went wrong. firmware/README.md explains the codes of faults;\n"
    "hal/sim/README.md lists those that can be simulated.\n"
    "\n"
    "Exit status: 0 printed, 1 a fault or an error, 2 wrong command line, 130 cancelled.\n";

void add_simulation_options(CLI::App& app, PrintOptions& print) {
  constexpr const char* kSimulation = "Simulation";
  SimulationOptions& simulation = print.simulation;
  app.add_flag("--simulate", simulation.simulate, "Simulate the printer even if it is a real one")->group(kSimulation);
  auto* speedup = app.add_option("--speedup", simulation.speedup,
                                 "Simulated seconds per second, 0.1 to 1000000 [as fast as this machine can]")
                      ->type_name("N")
                      ->check(number_from(0.1, 1e6))
                      ->group(kSimulation);
  app.add_flag_callback(
         "--realtime", [&simulation] { simulation.speedup = 1; }, "Same as --speedup 1")
      ->excludes(speedup)
      ->group(kSimulation);
  app.add_option("--fault", simulation.faults, "What goes wrong, such as lamp.stuck_on@layer=40; may be repeated")
      ->type_name("FAULT")
      ->take_all()
      ->group(kSimulation);
  app.add_option("--lamp-line", simulation.lamp_line,
                 "Line that plumbline-keeper switches together with the simulated lamp; file:PATH records the changes. "
                 "Needs --speedup or --realtime")
      ->type_name("LINE")
      ->group(kSimulation);
  app.add_option("--keep-part", print.keep_part,
                 "Write the part as the simulated printer made it: layers, preview and manifest")
      ->type_name("DIR")
      ->group(kSimulation);
  app.add_option(
         "--truth", print.truth,
         "Measure the part against this closed mesh, in the coordinates of the scan [with --keep-part: what was "
         "sliced]")
      ->type_name("MESH")
      ->excludes("--resume")
      ->group(kSimulation);
}

struct Printer {
  BoardFile board;
  MachineFile machine;
  PrintProfile profile;
};

Expected<Printer> read_printer(const PrintOptions& options) {
  Printer printer;
  auto board = read_board_file(options.job.printer);
  PLUMBLINE_TRY(board);
  printer.board = std::move(*board);
  auto machine = machine_of(printer.board, printer.board.path);
  PLUMBLINE_TRY(machine);
  printer.machine = std::move(*machine);
  const std::string& name = options.profile.empty() ? printer.machine.profile : options.profile;
  auto profile = read_print_profile(name, printer.board.path);
  PLUMBLINE_TRY(profile);
  printer.profile = std::move(*profile);
  printer.profile.checks = options.checks.over(printer.profile.checks);
  PLUMBLINE_TRY(choose_grey(options.grey, printer.board, printer.machine, printer.profile));
  set_values(printer.profile, options.by_person(), ValueSource::kPerson);
  printer.profile.adaptive = options.is_adaptive();
  printer.profile.exposure_test = options.exposure_test;
  return printer;
}

/// An archive is printed as it is: it can't be turned, scaled or supported any more.
Status check_archive_options(const PrintOptions& options) {
  const JobOptions& job = options.job;
  if (!options.truth.empty()) {
    return fail(ErrorCode::kBadSetting,
                "%s: an archive does not say where the mesh lies in its layers.\tLeave out --truth",
                job.scans[0].c_str());
  }
  const bool turned = job.orient || job.rotate_degrees != decltype(job.rotate_degrees){};
  const bool read_otherwise = job.units != Units::kMillimetres || job.as != ReadAs::kAuto ||
                              job.base != BaseChoice::kAuto || job.floor != FloorChoice() || job.keep_all;
  const bool supported = options.supports != SupportChoice();
  const bool moved = job.absolute_correction_mm.has_value();
  if (job.scale == 1 && !job.fit && !job.size && !turned && !read_otherwise && !supported && !moved) return {};
  return fail(ErrorCode::kBadSetting,
              "%s: is sliced already, so it is printed as it is.\tLeave out the options that place, read or support a "
              "scan",
              job.scans[0].c_str());
}

struct OpenArchive {
  Descriptor file;
  std::uint64_t hash = 0;
};

/// Copies an archive into the store. Without a store, hashes it where it is.
Expected<OpenArchive> open_archive(const std::string& path, JobStore* store, TerminalJob& terminal) {
  auto source = FileSource::open(path);
  PLUMBLINE_TRY(source);
  const auto advance = [&](double fraction) -> Status {
    if (terminal.progress().advance(Stage::kRead, fraction)) return {};
    return fail(ErrorCode::kCancelled, "interrupted while the archive was read");
  };
  if (store != nullptr) {
    auto received = store->receive(*source, advance);
    PLUMBLINE_TRY(received);
    return OpenArchive{std::move(received->file), received->hash};
  }
  OpenArchive archive;
  Hash64 hash;
  std::vector<std::byte> block(65536);
  for (;;) {
    PLUMBLINE_TRY(advance(0));
    const auto got = source->read(block);
    PLUMBLINE_TRY(got);
    if (*got == 0) break;
    hash.add(std::span(block).first(*got));
  }
  archive.hash = hash.value();
  archive.file = Descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!archive.file.is_open()) return fail(ErrorCode::kCannotOpen, "%s: %s", path.c_str(), std::strerror(errno));
  return archive;
}

/// What an archive does not say is printed only if somebody has said it, or accepts what the profile has; a scan whose points lie off its masks
/// only if somebody accepts that.
Status accept_doubts(const Contract& contract, const std::string& name, const PrintOptions& options,
                     TerminalJob& terminal) {
  std::string all;
  for_each_doubt(contract, name, [&](const Told&, std::string_view sentence) {
    if (options.checks.accept) return terminal.warn(std::string(sentence));
    all.append(all.empty() ? "" : "; ").append(sentence);
  });
  if (all.empty()) return {};
  std::string advice = "Add --accept to print it so";
  if (contract.doubts_about(Doubt::kExposure)) {
    advice += ", or --set exposure_time=SECONDS --set initial_exposure_time=SECONDS";
  }
  if (contract.doubts_about(Doubt::kLayerHeight)) advice += ", or --layer-height MM";
  return fail(ErrorCode::kBadSetting, "%s.\t%s", all.c_str(), advice.c_str());
}

/// Reports what the checks found in the masks, and draws it if asked.
void tell_issues(const PrintOptions& options, const std::string& name, const StackFindings& findings,
                 const PrintGrid& grid, const RRep& rrep, const Supports& supports, const CheckPolicy& policy,
                 TerminalJob& terminal) {
  for_each_issue(findings, grid, policy,
                 [&](IssueKind, CheckAction, std::string_view sentence) { terminal.warn(sentence); });
  if (rrep.first.empty()) return;
  const auto written = write_issues_file(options.issues, {name, grid, findings}, rrep, supports, terminal.arena());
  if (!written) terminal.warn("no picture of the issues: " + std::string(written.error().message()));
}

/// @param printer  its profile gets the archive's values, and above them the person's
Expected<Printable> read_archive(const PrintOptions& options, const JobSetup& setup, Printer& printer, JobStore* store,
                                 TerminalJob& terminal) {
  PrintProfile& profile = printer.profile;
  const std::string& path = options.job.scans[0];
  PLUMBLINE_TRY(check_archive_options(options));
  auto archive = open_archive(path, store, terminal);
  PLUMBLINE_TRY(archive);
  Arena& arena = terminal.arena();
  const std::string name = path.substr(path.rfind('/') + 1);
  const ArchiveTarget target{printer_volume(printer.board), static_cast<double>(setup.placement.layer_height_mm),
                             profile.peel, printer.machine.panel.grey.has_grey()};
  const int file = archive->file.get();
  const auto sliced = check_archive(file, name, target, arena, &terminal.progress());
  PLUMBLINE_TRY(sliced);
  for_each_remark(*sliced,
                  [&](const Told& told, std::string_view remark) { terminal.warn(at_terminal(told, remark).view()); });
  auto with_archives = profile_of(profile, sliced->settings, name, options.by_person());
  PLUMBLINE_TRY(with_archives);
  profile = std::move(*with_archives);
  tell_issues(options, name, sliced->findings, sliced->grid, sliced->rrep, Supports{}, profile.checks, terminal);
  arena.release_bottom(sliced->layers_end);
  PLUMBLINE_TRY(judge(sliced->findings, sliced->grid, profile.checks));
  const auto contract = contract_of(*sliced, profile, printer.machine);
  PLUMBLINE_TRY(contract);
  PLUMBLINE_TRY(accept_doubts(*contract, name, options, terminal));
  return printable_of(*sliced, name, profile.name, *contract, std::move(archive->file), archive->hash);
}

bool is_archive(const PrintOptions& options) {
  return options.job.scans.size() == 1 && is_archive_name(options.job.scans[0]);
}

Expected<Printable> slice_scan(const PrintOptions& options, const JobSetup& setup, const Printer& printer,
                               TerminalJob& terminal) {
  const auto supports = options.supports.over(printer.profile.supports_enable, printer.profile.supports);
  PLUMBLINE_TRY(supports);
  const auto scan = ScanFiles::open(options.job.scans);
  PLUMBLINE_TRY(scan);
  const SliceSettings settings = slice_settings(setup, *supports, &printer.profile);
  auto printable = slice_printable(scan->sources(), settings, printer.profile, printer.machine, terminal.arena(),
                                   &terminal.progress());
  PLUMBLINE_TRY(printable);
  PLUMBLINE_TRY(accept_doubts(printable->facts.contract, scan->title(), options, terminal));
  for_each_remark(printable->slice,
                  [&](const Told& told, std::string_view remark) { terminal.warn(at_terminal(told, remark).view()); });
  const MaskParts& parts = printable->parts;
  if (*supports && !terminal.silent()) {
    const auto stand = stand_text(**supports, printable->support_counts, parts.rrep.grid.layer_height_mm);
    write_line("stands     " + std::string(stand.view()));
  }
  tell_issues(options, scan->title(), *printable->findings, parts.rrep.grid, parts.rrep, parts.supports,
              printer.profile.checks, terminal);
  return printable;
}

Status make_ready(const PrintOptions& options, const JobSetup& setup, Printer& printer, JobStore* store,
                  PrintSession& session, TerminalJob& terminal) {
  if (options.resume) return session.load();
  auto printable = is_archive(options) ? read_archive(options, setup, printer, store, terminal)
                                       : slice_scan(options, setup, printer, terminal);
  PLUMBLINE_TRY(printable);
  return session.take(std::move(*printable));
}

Status write_results(const PrintOptions& options, const PrintOutcome& outcome) {
  if (!options.report.empty()) {
    auto file = OutputFile::create(options.report.c_str());
    PLUMBLINE_TRY(file);
    JsonWriter json(*file);
    write_print_report(json, outcome);
    PLUMBLINE_TRY(json.finish());
    PLUMBLINE_TRY(file->close());
  }
  OutputFile out = OutputFile::standard_output();
  if (options.job.json) {
    JsonWriter json(out);
    write_print_report(json, outcome);
    return json.finish();
  }
  if (options.job.quiet) return {};
  std::string look_at = options.report;
  if (!options.keep_part.empty()) {
    look_at = options.keep_part + "/preview.png, " + options.keep_part + "/comparison.png" +
              (look_at.empty() ? "" : ", " + look_at);
  }
  return write_print_summary(out, outcome, look_at, options.job.verbose);
}

/// A real printer with a state folder prints onto a plate that somebody says is empty.
Status check_plate(const PrintOptions& options, bool simulated, MachineRecord& record) {
  if (options.plate_empty) return record.confirm_empty();
  if (record.plate_is_empty() || options.resume || simulated) return {};
  return fail(ErrorCode::kBadSetting,
              "nobody has said that the plate is empty since the last print.\tTake off what is on it, then add "
              "--plate-empty");
}

/// What is written when the print has ended.
struct Outputs {
  std::optional<JobDirectory> part;  ///< of --keep-part
  std::optional<TruthMesh> truth;    ///< that the part is measured against
};

/// Refuses outputs that can't be written, and a truth that can't be used, before the minutes of slicing and the hours of printing.
Expected<Outputs> open_outputs(const PrintOptions& options, const Printer& printer) {
  Outputs outputs;
  for (const std::string* file : {&options.report, &options.issues}) {
    if (!file->empty()) PLUMBLINE_TRY(check_can_create(file->c_str()));
  }
  if (options.keep_part.empty() && options.truth.empty()) return outputs;
  if (!printer.machine.simulated && !options.simulation.simulate) {
    return fail(ErrorCode::kBadSetting,
                "%s is about the part that a simulated printer makes, and %s is a real one.\tLeave it out, or add "
                "--simulate",
                options.keep_part.empty() ? "--truth" : "--keep-part", printer.board.name.c_str());
  }
  if (!options.truth.empty()) {
    auto truth = TruthMesh::read(options.truth);
    PLUMBLINE_TRY(truth);
    outputs.truth.emplace(std::move(*truth));
  }
  if (options.keep_part.empty()) return outputs;
  auto part = JobDirectory::open(options.keep_part);
  PLUMBLINE_TRY(part);
  outputs.part.emplace(std::move(*part));
  return outputs;
}

/// Fills the tank of a simulated printer when the print asks for it. On a board a person does.
class SimulatedUser final : public PrintObserver {
 public:
  /// @param witness  null: on a board
  SimulatedUser(PrintObserver& lines, Witness* witness) : lines_(lines), witness_(witness) {}

  bool update(const PrintStatus& status) override {
    const bool asks = witness_ != nullptr && status.state == PrintState::kFeedMe;
    if (!asks) asked_at_.reset();
    if (asks && !asked_at_) asked_at_ = status.now;
    if (asks && status.now - *asked_at_ >= kToFill) {
      asked_at_ = status.now;
      witness_->press(EventKind::kStartPressed);
    }
    return lines_.update(status);
  }
  void checked(Check check, const CheckResult& result) override { lines_.checked(check, result); }

 private:
  PrintObserver& lines_;
  Witness* witness_;
  std::optional<TimePoint> asked_at_;
};

/// Measures the part against the mesh of --truth, or else against the R-Rep.
std::optional<MeasuredSurface> measure(const std::optional<TruthMesh>& truth, const Printable& printable,
                                       const Witness& witness) {
  const Placement& placement = printable.slice.placement;
  if (placement.grid.layers == 0) return std::nullopt;  // an archive, or a print from its store
  // The R-Rep of an adaptive print has the heights of its layers, not those of the surface.
  if (!truth && !printable.support_counts.steps.all_one()) return std::nullopt;
  const auto& bleed = printable.support_counts.bleed;
  MeasuredSurface surface{
      truth ? truth->surface(placement) : surface_samples(printable.parts.rrep, bleed ? bleed->model : CureModel()),
      {}};
  leave_out_supports(printable.parts.supports, placement.grid, surface.points);
  const SizeCorrections& sizes = printable.facts.contract.sizes;
  if (!truth) {  // what was sliced has its outlines moved, to from where they are true
    for (OrientedPoint& p : surface.points) p.at -= outline_move(p.normal, static_cast<float>(sizes.absolute_mm));
  }
  // No resin of a simulated printer shrinks: its part is as large as the masks.
  std::vector<OrientedPoint> before_shrinking = surface.points;
  const Vec3f masks = sizes.relative().cast<float>();
  for (OrientedPoint& point : before_shrinking) point.at = point.at.cwiseProduct(masks);
  surface.deviations_mm = witness.deviations_mm(before_shrinking);
  return surface;
}

ExitCode exit_code(PrintState state) {
  if (state == PrintState::kFinished) return ExitCode::kDone;
  return state == PrintState::kCancelled ? ExitCode::kInterrupted : ExitCode::kWorldError;
}

}  // namespace

CLI::App* add_print_command(CLI::App& app, PrintOptions& options) {
  constexpr const char* kPrint = "Print";
  auto* command = app.add_subcommand("print", "Print a scan, a mesh or a sliced archive");
  command->footer(kPrintFooter);
  auto* scan = add_job_options(*command, options.job)->required(false);
  command->get_option("--printer")->required()->description("A printer's name, such as sim2k, or its board file");
  add_support_options(*command, options.supports, "[as in the profile]");
  add_check_options(*command, options.checks);
  command
      ->add_option("--profile", options.profile,
                   "Resin and print settings: a name, such as draft, or a profile's file [the printer's]")
      ->type_name("NAME")
      ->group(kPrint);
  add_correction_option(*command, options.job);
  auto* state =
      command->add_option("--state", options.state, "Folder for the journal, to go on after a power cut [no journal]")
          ->type_name("DIR")
          ->group(kPrint);
  auto* resume = command->add_flag("--resume", options.resume, "Go on with the interrupted print in --state")
                     ->needs(state)
                     ->excludes(scan)
                     ->excludes("--supports")
                     ->group(kPrint);
  command
      ->add_flag("--plate-empty", options.plate_empty,
                 "The plate is empty: with --state, a real printer asks for it after each print")
      ->needs(state)
      ->excludes(resume)
      ->group(kPrint);
  for (const char* const name :
       {"--support-preset", "--support-stand", "--support-buildplate-only", "--absolute-correction"}) {
    resume->excludes(name);
  }
  for (const SupportField& field : kSupportFields) resume->excludes(option_name(field.key));
  for (const PlaceField& field : kPlaceFields) resume->excludes(option_name(field.key));
  resume->excludes(add_grey_option(*command, options.grey)->group(kPrint));
  command
      ->add_option_function<std::vector<std::string>>(
          "--set",
          [&options](const std::vector<std::string>& texts) {
            for (const std::string& text : texts) {
              if (const auto set = parse_assignment(text, options.set); !set) {
                throw CLI::ValidationError("--set: " + std::string(set.error().message()));
              }
            }
          },
          "Another value than the profile's or archive's, such as exposure_time=3 (s). May be repeated")
      ->type_name("KEY=VALUE")
      ->take_all()
      ->excludes(resume)
      ->group(kPrint);
  command
      ->add_option_function<std::string>(
          "--exposure-test",
          [&options](const std::string& text) {
            const auto test = parse_exposure_test(text);
            if (!test) throw CLI::ValidationError("--exposure-test: " + std::string(test.error().message()));
            options.exposure_test = *test;
          },
          "2 to 8 exposures instead of exposure_time, ascending, such as 1.6s,2s,2.4s: the object is divided along x "
          "in as many strips of equal width, the shortest first. Bottom layers are exposed as ever, faded ones as for "
          "the longest")
      ->type_name("TIMES")
      ->excludes(resume)
      ->group(kPrint);
  command->add_option("--report", options.report, "Write the report, with every exposure, as JSON")
      ->type_name("FILE")
      ->group(kPrint);
  command->add_option("--issues", options.issues, "Draw where the checks find something, if they do")
      ->type_name("PNG")
      ->excludes(resume)
      ->group(kPrint);
  add_simulation_options(*command, options);
  add_program_options(*command, options.job);
  command->callback([&options] {
    if (!options.resume && options.job.scans.empty()) throw CLI::RequiredError("a scan, or --resume with --state,");
  });
  show_basic(*command, {"--printer", "--profile", "--set", "--layer-height", "--units", "--height", "--fit", "--orient",
                        "--rotate-x", "--supports", "--accept", "--keep-part", "--verbose"});
  return command;
}

ExitCode run_print(const PrintOptions& options, std::span<std::byte> arena_block) {
  auto printer = read_printer(options);
  if (!printer) return report_error(printer.error());
  if (const auto possible = check_back_end(printer->board, printer->machine, options.simulation); !possible) {
    return report_error(possible.error());
  }
  JobOptions job = options.job;
  if (!job.layer_height_mm || options.is_adaptive()) job.layer_height_mm = finest_layer_mm(printer->profile);
  const auto setup = set_up(job, arena_block.size());
  if (!setup) return report_error(setup.error());
  std::optional<JobStore> store;
  std::optional<MachineRecord> record;
  const bool simulated = printer->machine.simulated || options.simulation.simulate;
  if (!options.state.empty()) {
    auto opened = JobStore::open(options.state);
    if (!opened) return report_error(opened.error());
    store.emplace(std::move(*opened));
    auto remembered = open_machine_record(options.state, *store, printer->machine.tank_volume_ml, simulated);
    if (!remembered) return report_error(remembered.error());
    record.emplace(std::move(*remembered));
    if (const auto checked = check_plate(options, simulated, *record); !checked) return report_error(checked.error());
  }
  auto outputs = open_outputs(options, *printer);
  if (!outputs) return report_error(outputs.error());
  TerminalJob terminal(job, *setup, arena_block);
  PrintSession session(printer->board, printer->machine, terminal.arena(), store ? &*store : nullptr);
  const auto ready = make_ready(options, *setup, *printer, store ? &*store : nullptr, session, terminal);
  if (!ready) return report_error(ready.error());

  if (outputs->part) {
    if (const auto room = check_room_for_part(*outputs->part, session); !room) return report_error(room.error());
  }

  // The machine is opened after slicing, because a simulated one's time begins with its first use.
  SimulationOptions simulation = options.simulation;
  simulation.keep_part = outputs->part || outputs->truth;
  if (options.resume) {
    const auto progress = store->progress();
    if (!progress) return report_error(progress.error());
    simulation.layers_on_plate = progress->last.next_layer;
    simulation.height_on_plate = progress->last.height;
    simulation.plate_at = progress->last.stands;
  }
  auto back_end = open_back_end(printer->board, printer->machine, printer->profile, simulation);
  if (!back_end) return report_error(back_end.error());
  Witness* const witness = (*back_end)->witness();
  const auto show = terminal.silent() ? PrintLines::Show::kNothing
                    : job.verbose     ? PrintLines::Show::kEverything
                                      : PrintLines::Show::kPrint;
  PrintLines lines(show, witness != nullptr ? std::optional(kNobodyComes) : std::nullopt);
  if (!terminal.silent()) {
    for_each_contract_line(session.contract(), [](std::string_view line) { write_line(line); });
  }
  SimulatedUser user(lines, witness);
  const PrintReport& report = session.print((*back_end)->machine(), user, record ? &*record : nullptr);
  lines.clear();
  if (lines.gave_up()) write_line("plumbline: the print waited an hour for its user and was cancelled");

  std::vector<std::string> objections;
  if (witness != nullptr) {
    witness->conclude(report.state == PrintState::kFinished);
    objections = witness->objections();
  }
  std::optional<PartFigures> part;
  if (witness != nullptr) part = witness->part_figures();
  std::optional<MeasuredSurface> measured;
  if (simulation.keep_part && report.state == PrintState::kFinished) {
    measured = measure(outputs->truth, session.printable(), *witness);
    if (measured) part->deviation = deviation_figures(measured->name, measured->points, measured->deviations_mm);
  }
  const auto written =
      write_results(options, {report, session, printer->profile, objections, (*back_end)->take_step_figures(), part});
  if (!written) return report_error(written.error());
  if (witness != nullptr && outputs->part) {
    const auto kept =
        write_printed_part(*outputs->part, *witness, session, measured ? &*measured : nullptr, terminal.arena());
    if (!kept) return report_error(kept.error());
  }
  return exit_code(report.state);
}

}  // namespace plumbline::firmware
