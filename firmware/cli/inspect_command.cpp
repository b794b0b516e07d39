#include <CLI/CLI.hpp>

#include "firmware/cli/commands.hpp"
#include "firmware/cli/inspect_report.hpp"
#include "firmware/cli/print_time.hpp"
#include "firmware/cli/shared_options.hpp"
#include "firmware/io/interrupt.hpp"
#include "firmware/io/job_progress.hpp"
#include "firmware/io/progress_lines.hpp"
#include "firmware/io/scan_files.hpp"

namespace plumbline {
namespace {

constexpr const char* kFooter =
    "\nExamples:\n"
    "  plumbline inspect bust.ply\n"
    "  plumbline inspect bust.ply --printer mono2k --rotate-x 90\n"
    "  plumbline inspect bust.ply --picture seen.png\n"
    "\n"
    "Output: size, points and normals, noise, what the scanner did not see, and whether it fits the printer. For what "
    "the\n"
    "scanner did not see the scan is read a second time and sliced coarsely. Only the picture is written to disk.\n";

/// Fills outlook.look, or says why not. A scan that has no surface has no look either, which is no error here.
Status look(const InspectOptions& options, const JobSetup& setup, ScanOutlook& outlook, Arena& arena) {
  const double longest = outlook.scan.bounds.size().maxCoeff() * outlook.unit_mm();
  auto scan = ScanFiles::open(options.job.scans);
  PLUMBLINE_TRY(scan);
  for (const ByteSource* source : scan->sources()) {
    if (source->size()) continue;
    outlook.no_look.add("a pipe cannot be read twice; 'plumbline slice' tells it");
    return {};
  }
  if (!(longest > 0)) {
    outlook.no_look.add("all points are one place");
    return {};
  }
  SliceSettings settings;
  settings.placement = setup.placement;
  settings.placement.units = outlook.units;
  settings.base = setup.base;
  settings.keep_all = setup.keep_all;
  settings.threads = setup.threads;
  JobProgress progress(nullptr);
  const auto looked = look_at_scan(scan->sources(), settings, longest, options.picture, arena, &progress);
  if (looked) {
    outlook.look = *looked;
    return {};
  }
  const ErrorCode code = looked.error().code();
  const bool of_the_scan = code == ErrorCode::kNoSurface || code == ErrorCode::kOutOfMemory;
  if (!of_the_scan || !options.picture.empty()) return tl::unexpected<Error>(looked.error());
  outlook.no_look.add("%s", looked.error().message());
  return {};
}

/// In words; empty where nobody knows.
std::string print_time_of(const ScanOutlook& outlook, const std::optional<BoardFile>& board) {
  if (!board || !outlook.placed) return {};
  const PrintGrid& grid = outlook.placed->grid;
  const auto time = estimate_print_time(*board, grid.layers, static_cast<double>(grid.layer_height_mm));
  return time ? time->text() : std::string();
}

}  // namespace

CLI::App* add_inspect_command(CLI::App& app, InspectOptions& options) {
  auto* command = app.add_subcommand("inspect", "Show what is in a scan and whether it fits the printer");
  command->footer(kFooter);
  command->add_option("--picture", options.picture, "Draw what the scanner saw and what it did not")->type_name("PNG");
  add_job_options(*command, options.job);
  add_program_options(*command, options.job);
  return command;
}

ExitCode run_inspect(const InspectOptions& inspect_options, std::span<std::byte> arena_block) {
  const JobOptions& options = inspect_options.job;
  const auto setup = set_up(options, arena_block);
  if (!setup) return report_error(setup.error());
  catch_interrupts();
  const auto scan = ScanFiles::open(options.scans);
  if (!scan) return report_error(scan.error());
  const bool silent = options.quiet || options.json;
  ProgressLines lines(options.verbose);
  JobProgress progress(silent ? nullptr : &lines);
  Arena arena(setup->arena_block);
  InspectSettings settings;
  settings.placement = setup->placement;
  settings.keep_all = setup->keep_all;
  settings.threads = setup->threads;
  InspectReport report;
  const auto done = inspect(scan->sources(), settings, arena, &progress, report);
  if (!done) return report_error(done.error());
  ScanOutlook outlook = make_outlook(report, setup->placement, arena.capacity(), setup->threads);
  outlook.scan_name = scan->title();
  outlook.scan_names = scan->names();
  outlook.printer_name = setup->printer_name;
  const auto looked = look(inspect_options, *setup, outlook, arena);
  if (!looked) return report_error(looked.error());
  if (!silent && outlook.look && !outlook.look->sentence().view().empty()) {
    FixedText<256> line;
    line.add("plumbline: warning: %s%s%s\n", outlook.look->sentence().c_str(),
             inspect_options.picture.empty() ? ". --picture FILE draws where" : ": see ",
             inspect_options.picture.c_str());
    write_to_stderr(line.view());
  }
  if (options.quiet && !options.json) return ExitCode::kDone;
  OutputFile out = OutputFile::standard_output();
  JsonWriter json(out);
  if (options.json) write_outlook(json, outlook);
  const auto written =
      options.json ? json.finish() : write_outlook(out, outlook, print_time_of(outlook, setup->board), options.verbose);
  return written ? ExitCode::kDone : report_error(written.error());
}

}  // namespace plumbline
