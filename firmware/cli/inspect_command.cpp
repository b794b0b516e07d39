#include <fcntl.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstring>

#include "firmware/cli/commands.hpp"
#include "firmware/cli/options/shared_options.hpp"
#include "firmware/cli/reports/archive_report.hpp"
#include "firmware/cli/reports/inspect_report.hpp"
#include "firmware/cli/reports/issues_file.hpp"
#include "firmware/cli/reports/print_time.hpp"
#include "firmware/cli/terminal_job.hpp"
#include "firmware/io/descriptor.hpp"
#include "firmware/io/scan_files.hpp"
#include "firmware/messages/told_text.hpp"
#include "firmware/print/job/sliced_archive.hpp"
#include "firmware/slice/issue_report.hpp"
#include "firmware/slice/proof_report.hpp"
#include "slicer/checks/stack_checker.hpp"
#include "slicer/layers/layer_stream.hpp"

namespace plumbline::firmware {
namespace {

constexpr const char* kInspectFooter =
    "\nExamples:\n"
    "  plumbline inspect bust.ply\n"
    "  plumbline inspect bust.ply --printer mono2k --rotate-x 90\n"
    "  plumbline inspect bust.ply --picture seen.png --issues issues.png\n"
    "\n"
    "Output: size, points and normals, noise, what the scanner did not see, and whether it fits the printer. The scan "
    "is\n"
    "sliced coarsely to see this, without supports. Only the pictures are written to disk.\n";

/// @returns the time in words; empty if it is unknown
std::string print_time_of(const ScanOutlook& outlook, const JobSetup& setup) {
  if (!setup.board || !outlook.scan.placement) return {};
  const auto time = estimate_print_time(*setup.board, outlook.scan.placement->grid.layers,
                                        static_cast<double>(setup.placement.layer_height_mm));
  return time ? time->text() : std::string();
}

/// What a coarse slice can show of its issues: the large ones.
constexpr std::array kShownCoarsely = {IssueKind::kFreePiece, IssueKind::kTear, IssueKind::kResinTrap,
                                       IssueKind::kSuctionCup};

/// Checks the coarse masks, without supports.
Expected<StackFindings> check_coarsely(const RRep& rrep, const PeelSettings& peel, Arena& arena) {
  const ArenaScope scope(arena);
  const std::size_t bottom = arena.bottom_mark();
  auto stream = LayerStream::create(rrep, arena);
  PLUMBLINE_TRY(stream);
  auto checker = StackChecker::create(rrep.grid, coarse_limits(rrep.grid, peel), arena);
  PLUMBLINE_TRY(checker);
  for (std::uint32_t k = 0; k < rrep.grid.layers; ++k) checker->next(stream->mask(k));
  arena.release_bottom(bottom);
  const StackFindings all = checker->finish();
  StackFindings large = all;
  large.groups = {};
  for (const IssueKind kind : kShownCoarsely) large.of(kind) = all.of(kind);
  return large;
}

ExitCode inspect_archive(const InspectOptions& options, const JobSetup& setup) {
  const std::string& path = options.job.scans[0];
  if (!options.picture.empty() || !options.issues.empty()) {
    return report_error(Error::format(ErrorCode::kBadSetting,
                                      "%s: is sliced already.\tLeave out --picture and --issues; 'plumbline check "
                                      "--picture' draws where its layers have issues",
                                      path.c_str()));
  }
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file.is_open()) {
    return report_error(
        Error::format(ErrorCode::kCannotOpen, "%s: cannot be opened: %s", path.c_str(), std::strerror(errno)));
  }
  const std::string name = path.substr(path.rfind('/') + 1);
  auto archive = LayerArchive::open(file.get(), name);
  if (!archive) return report_error(archive.error());
  std::string refusal;
  if (setup.board) {
    const auto fits = check_panel(*archive, name, printer_volume(*setup.board));
    if (!fits) refusal = at_terminal(fits.error()).c_str();
  }
  if (options.job.quiet && !options.job.json) return ExitCode::kDone;
  OutputFile out = OutputFile::standard_output();
  JsonWriter json(out);
  if (options.job.json) write_archive_report(json, *archive, name, setup, refusal);
  const auto written = options.job.json ? json.finish() : write_archive_report(out, *archive, name, setup, refusal);
  return written ? ExitCode::kDone : report_error(written.error());
}

}  // namespace

CLI::App* add_inspect_command(CLI::App& app, InspectOptions& options) {
  auto* command = app.add_subcommand(
      "inspect", "Show what is in a scan, a mesh or a sliced archive, and whether it fits the printer");
  command->footer(kInspectFooter);
  add_look_options(*command, options.job, options.picture, "Draw what the scanner saw and what it did not");
  command->add_option("--issues", options.issues, "Draw where the checks find something, if they do")->type_name("PNG");
  return command;
}

ExitCode run_inspect(const InspectOptions& inspect_options, std::span<std::byte> arena_block) {
  const JobOptions& options = inspect_options.job;
  const auto setup = set_up(options, arena_block.size());
  if (!setup) return report_error(setup.error());
  for (const std::string* picture : {&inspect_options.picture, &inspect_options.issues}) {
    if (picture->empty()) continue;
    if (const auto possible = check_can_create(picture->c_str()); !possible) return report_error(possible.error());
  }
  if (options.scans.size() == 1 && is_archive_name(options.scans[0])) return inspect_archive(inspect_options, *setup);
  TerminalJob terminal(options, *setup, arena_block, WholeProgress(Stage::kRRep));
  Arena& arena = terminal.arena();
  const auto scan = ScanFiles::open(options.scans);
  if (!scan) return report_error(scan.error());
  SliceSettings settings = slice_settings(*setup);
  settings.supports = SupportSettings();  // so that it turns the object as 'plumbline slice' does
  InspectReport report;
  std::optional<CoveragePreview> coverage;
  std::optional<StackFindings> findings;
  PrintGrid coarse_grid;
  const auto see = [&](const RRep& rrep, const SliceReport& coarse) -> Status {
    if (!coarse.mesh) {
      const auto previewed = preview_coverage(rrep, coarse, scan->title(), inspect_options.picture, arena);
      PLUMBLINE_TRY(previewed);
      coverage = *previewed;
    }
    const auto checked = check_coarsely(rrep, setup->peel, arena);
    PLUMBLINE_TRY(checked);
    findings = *checked;
    coarse_grid = rrep.grid;
    return write_issues_file(inspect_options.issues, {scan->title(), rrep.grid, *findings}, rrep, Supports{}, arena);
  };
  const auto done = inspect(scan->sources(), settings, arena, &terminal.progress(), report, see);
  if (!done) return report_error(done.error());
  const bool wants_picture = !inspect_options.picture.empty() || !inspect_options.issues.empty();
  if (!report.sliced && wants_picture) return report_error(report.sliced.error());
  if (report.mesh && !inspect_options.picture.empty()) {
    return report_error(Error::format(ErrorCode::kBadSetting,
                                      "%s: is a mesh, so there is nothing that a scanner did not see.\tLeave out "
                                      "--picture; 'plumbline slice' draws a preview",
                                      scan->title().c_str()));
  }
  ScanOutlook outlook = make_outlook(report, settings.placement, arena.capacity(), setup->threads);
  outlook.coverage = coverage;
  outlook.findings = findings;
  outlook.coarse_grid = coarse_grid;
  outlook.scan_name = scan->title();
  outlook.scan_names = scan->names();
  outlook.printer_name = setup->printer_name;
  if (outlook.coverage && !outlook.coverage->sentence().view().empty()) {
    FixedText<256> line;
    line.add("%s%s%s", outlook.coverage->sentence().c_str(),
             inspect_options.picture.empty() ? ". --picture FILE draws where" : ": see ",
             inspect_options.picture.c_str());
    terminal.warn(line.view());
  }
  if (const PointProof& proof = report.coarse.proof; outlook.coverage && proof.is_doubtful()) {
    terminal.warn(points_off_warning(proof).view());
  }
  if (options.quiet && !options.json) return ExitCode::kDone;
  OutputFile out = OutputFile::standard_output();
  JsonWriter json(out);
  if (options.json) write_outlook(json, outlook);
  const auto written =
      options.json ? json.finish() : write_outlook(out, outlook, print_time_of(outlook, *setup), options.verbose);
  return written ? ExitCode::kDone : report_error(written.error());
}

}  // namespace plumbline::firmware
