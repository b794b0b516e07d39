#include <algorithm>

#include "firmware/cli/commands.hpp"
#include "firmware/cli/printed_part.hpp"
#include "firmware/io/interrupt.hpp"
#include "firmware/io/job_progress.hpp"
#include "firmware/io/progress_lines.hpp"
#include "firmware/io/scan_files.hpp"
#include "firmware/machine/back_end.hpp"
#include "firmware/print/print_lines.hpp"
#include "firmware/print/print_session.hpp"
#include "firmware/print/print_summary.hpp"
#include "firmware/slice/job_report.hpp"

namespace plumbline {
namespace {

/// Virtual time that a print may wait for a user who is not there.
constexpr nanoseconds kNobodyComes = std::chrono::hours(1);

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
  auto machine = machine_of(printer.board, options.job.printer);
  PLUMBLINE_TRY(machine);
  printer.machine = std::move(*machine);
  const std::string& name = options.profile.empty() ? printer.machine.profile : options.profile;
  auto profile = read_print_profile(profile_path(name, options.job.printer));
  PLUMBLINE_TRY(profile);
  printer.profile = std::move(*profile);
  return printer;
}

Status make_ready(const PrintOptions& options, const JobSetup& setup, const Printer& printer, PrintSession& session,
                  bool silent) {
  if (options.resume) return session.load();
  const auto supports = options.supports.over(printer.profile.supports_enable, printer.profile.supports);
  PLUMBLINE_TRY(supports);
  const auto scan = ScanFiles::open(options.job.scans);
  PLUMBLINE_TRY(scan);
  SliceSettings settings;
  settings.placement = setup.placement;
  settings.base = setup.base;
  settings.keep_all = setup.keep_all;
  settings.threads = setup.threads;
  ProgressLines lines;
  JobProgress progress(silent ? nullptr : &lines);
  PLUMBLINE_TRY(session.slice_scan(scan->sources(), settings, *supports, printer.profile, &progress));
  if (silent) return {};
  for_each_remark(session.sliced(), [](std::string_view warning) {
    FixedText<512> line;
    line.add("plumbline: warning: %.*s\n", static_cast<int>(warning.size()), warning.data());
    write_to_stderr(line.view());
  });
  return {};
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
  return options.job.quiet ? Status() : write_print_summary(out, outcome);
}

ExitCode exit_code(PrintState state) {
  if (state == PrintState::kFinished) return ExitCode::kDone;
  return state == PrintState::kCancelled ? ExitCode::kInterrupted : ExitCode::kWorldError;
}

}  // namespace

ExitCode run_print(const PrintOptions& options, std::span<std::byte> arena_block) {
  const auto printer = read_printer(options);
  if (!printer) return report_error(printer.error());
  JobOptions job = options.job;
  if (!job.layer_height_mm) job.layer_height_mm = printer->profile.layer_height;
  const auto setup = set_up(job, arena_block);
  if (!setup) return report_error(setup.error());
  std::optional<JobStore> store;
  if (!options.state.empty()) {
    auto opened = JobStore::open(options.state);
    if (!opened) return report_error(opened.error());
    store.emplace(std::move(*opened));
  }
  catch_interrupts();
  Arena arena(setup->arena_block);
  const bool silent = job.quiet || job.json;
  PrintSession session(printer->board, printer->machine, arena, store ? &*store : nullptr);
  const auto ready = make_ready(options, *setup, *printer, session, silent);
  if (!ready) return report_error(ready.error());

  // After slicing: a simulated machine's time begins with its first use.
  SimulationOptions simulation = options.simulation;
  simulation.keep_part = !options.keep_part.empty();
  auto back_end = open_back_end(printer->board, printer->machine, printer->profile, simulation);
  if (!back_end) return report_error(back_end.error());
  Witness* const witness = (*back_end)->witness();
  PrintLines lines(!silent, witness != nullptr ? std::optional(kNobodyComes) : std::nullopt);
  const PrintReport& report = session.print((*back_end)->machine(), lines);
  lines.clear();
  if (lines.gave_up()) write_to_stderr("plumbline: the print waited an hour for its user and was cancelled\n");

  std::vector<std::string> objections;
  if (witness != nullptr) {
    witness->conclude(report.state == PrintState::kFinished);
    objections = witness->objections();
  }
  const auto written = write_results(
      options, {report, session, printer->profile, witness != nullptr, objections, (*back_end)->take_step_figures()});
  if (!written) return report_error(written.error());
  if (witness != nullptr && !options.keep_part.empty()) {
    const auto kept = write_printed_part(options.keep_part, *witness, session, arena);
    if (!kept) return report_error(kept.error());
  }
  return exit_code(report.state);
}

}  // namespace plumbline
