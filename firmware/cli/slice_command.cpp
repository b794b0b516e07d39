#include "firmware/cli/commands.hpp"
#include "firmware/io/interrupt.hpp"
#include "firmware/io/json_writer.hpp"
#include "firmware/io/progress_lines.hpp"
#include "firmware/slice/job_summary.hpp"
#include "firmware/slice/manifest.hpp"
#include "firmware/slice/slice_job.hpp"

namespace plumbline {
namespace {

Status write_result(const JobReport& report, const SliceOptions& options) {
  OutputFile out = OutputFile::standard_output();
  if (options.job.json) {
    JsonWriter json(out);
    write_manifest(json, report, {});
    return json.finish();
  }
  return write_summary(out, report, options.output.c_str());
}

void write_warnings(const JobWarnings& warnings) {
  for (const auto& warning : warnings.all()) {
    FixedText<512> line;
    line.add("plumbline: warning: %s\n", warning.c_str());
    write_to_stderr(line.view());
  }
}

}  // namespace

ExitCode run_slice(const SliceOptions& options, std::span<std::byte> arena_block) {
  const auto setup = set_up(options.job, arena_block);
  if (!setup) return report_error(setup.error());
  SliceJobSettings settings;
  settings.scan_paths = options.job.scans;
  settings.output_path = options.output;
  settings.printer_name = setup->printer_name;
  settings.slice.placement = setup->placement;
  settings.slice.base = setup->base;
  settings.slice.keep_all = setup->keep_all;
  settings.slice.threads = setup->threads;
  settings.preview = options.preview;
  settings.supports = options.supports;
  catch_interrupts();
  Arena arena(setup->arena_block);
  auto job = SliceJob::prepare(settings, arena);
  if (!job) return report_error(job.error());
  const bool silent = options.job.quiet || options.job.json;
  ProgressLines lines;
  JobProgress progress(silent ? nullptr : &lines);
  const auto done = job->run(progress);
  if (!done) {
    if (done.error().code() == ErrorCode::kDoesNotFit) {
      return report_error(done.error().with_prefix(job->report().scan_name));
    }
    if (done.error().code() != ErrorCode::kCancelled) return report_error(done.error());
    return report_error(Error::format(ErrorCode::kCancelled, "interrupted; nothing of this job was left in %s",
                                      options.output.c_str()));
  }
  if (!silent) write_warnings(job->report().warnings);
  if (options.job.quiet && !options.job.json) return ExitCode::kDone;
  const auto written = write_result(job->report(), options);
  return written ? ExitCode::kDone : report_error(written.error());
}

}  // namespace plumbline
