#include "firmware/commands.hpp"
#include "firmware/inspect_report.hpp"
#include "firmware/interrupt.hpp"
#include "firmware/job_progress.hpp"
#include "firmware/progress_lines.hpp"
#include "firmware/scan_files.hpp"

namespace plumbline {

ExitCode run_inspect(const JobOptions& options, std::span<std::byte> arena_block) {
  const auto setup = set_up(options, arena_block);
  if (!setup) return report_error(setup.error());
  catch_interrupts();
  const auto scan = ScanFiles::open(options.scans);
  if (!scan) return report_error(scan.error());
  const bool silent = options.quiet || options.json;
  ProgressLines lines;
  JobProgress progress(silent ? nullptr : &lines);
  Arena arena(setup->arena_block);
  InspectSettings settings;
  settings.placement = setup->placement;
  settings.keep_all = setup->keep_all;
  settings.threads = setup->threads;
  InspectReport report;
  const auto done = inspect(scan->sources(), settings, arena, &progress, report);
  if (!done) return report_error(done.error());
  if (options.quiet && !options.json) return ExitCode::kDone;

  ScanOutlook outlook = make_outlook(report, setup->placement, arena.capacity(), setup->threads);
  outlook.scan_name = scan->title();
  outlook.scan_names = scan->names();
  outlook.printer_name = setup->printer_name;
  OutputFile out = OutputFile::standard_output();
  JsonWriter json(out);
  if (options.json) write_outlook(json, outlook);
  const auto written = options.json ? json.finish() : write_outlook(out, outlook);
  return written ? ExitCode::kDone : report_error(written.error());
}

}  // namespace plumbline
