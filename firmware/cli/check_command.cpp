#include <sys/stat.h>

#include <CLI/CLI.hpp>
#include <chrono>

#include "firmware/cli/commands.hpp"
#include "firmware/cli/options/help_format.hpp"
#include "firmware/cli/options/shared_options.hpp"
#include "firmware/cli/reports/issues_file.hpp"
#include "firmware/cli/terminal_job.hpp"
#include "firmware/io/interrupt.hpp"
#include "firmware/io/output_file.hpp"
#include "firmware/io/progress_lines.hpp"
#include "firmware/io/scan_files.hpp"
#include "firmware/io/version.hpp"
#include "firmware/messages/told_text.hpp"
#include "firmware/print/job/sliced_scan.hpp"
#include "firmware/settings/print_profile.hpp"
#include "firmware/slice/issue_report.hpp"
#include "firmware/slice/job_report.hpp"
#include "firmware/slice/manifest.hpp"
#include "firmware/slice/mask_stack.hpp"
#include "slicer/checks/stack_checker.hpp"
#include "slicer/checks/what_matters.hpp"

namespace plumbline::firmware {
namespace {

constexpr const char* kCheckFooter =
    "\nExamples:\n"
    "  plumbline check out                                           the job in out/\n"
    "  plumbline check peer --pixel-pitch 0.05 --layer-height 0.05   another slicer's layers, in a folder of PNG "
    "files\n"
    "  plumbline check peer --printer mono2k --picture issues.png    and where they have issues\n"
    "  plumbline check part.sl1 --printer mono2k                     a sliced archive\n"
    "  plumbline check bust.ply --printer mono2k                     a scan, without writing its layers\n"
    "  plumbline check out --check all=refuse                        fail if there is anything\n"
    "\n"
    "Finds what would go wrong: islands, overhangs, pieces that nothing holds, resin traps, suction cups, and the "
    "like.\n"
    "A folder's layers are its PNG files in the order of the last number in their names, 1 bit or grey.\n"
    "\n"
    "Exit status: 0 the print may start, 1 the checks refuse it, or an error, 2 wrong command line, 130 "
    "interrupted.\n";

bool is_folder(const std::string& path) {
  struct stat status = {};
  return ::stat(path.c_str(), &status) == 0 && S_ISDIR(status.st_mode);
}

/// What a stack's grid is: from the options, else from its manifest.
Expected<PrintGrid> grid_of(const MaskStack& stack, const JobOptions& job, const JobSetup& setup, CheckLimits& limits) {
  PrintGrid grid{.columns = stack.columns(), .rows = stack.rows(), .layers = stack.layers()};
  limits = check_limits(setup.placement, setup.peel, 0);
  limits.has_panel = true;
  const auto& known = stack.scale();
  const auto& printer = setup.placement.printer;
  if (!known && !printer && (!job.pixel_pitch_mm || !job.layer_height_mm)) {
    return fail(ErrorCode::kBadSetting,
                "%s: does not say how large a pixel and how high a layer is.\tGive --pixel-pitch and "
                "--layer-height, or --printer",
                job.scans[0].c_str());
  }
  grid.layer_height_mm = setup.placement.layer_height_mm;
  if (printer) {
    grid.pitch_x_mm = printer->pitch_x_mm;
    grid.pitch_y_mm = printer->pitch_y_mm;
    if (printer->columns != grid.columns || printer->rows != grid.rows) {
      return fail(ErrorCode::kDoesNotFit, "%s: the layers have %u x %u pixels, the panel of %s %u x %u",
                  job.scans[0].c_str(), grid.columns, grid.rows, setup.printer_name.c_str(), printer->columns,
                  printer->rows);
    }
  } else if (job.pixel_pitch_mm || !known) {
    grid.pitch_x_mm = grid.pitch_y_mm = setup.placement.pixel_pitch_mm;
  } else {
    grid.pitch_x_mm = static_cast<float>(known->pitch_x_mm);
    grid.pitch_y_mm = static_cast<float>(known->pitch_y_mm);
    limits.has_panel = known->has_panel;
  }
  if (known && !job.layer_height_mm) grid.layer_height_mm = static_cast<float>(known->layer_height_mm);
  return grid;
}

Expected<CheckedMasks> check_stack(const CheckOptions& options, const JobSetup& setup, TerminalJob& terminal) {
  Arena& arena = terminal.arena();
  auto stack = MaskStack::open(options.job.scans[0]);
  PLUMBLINE_TRY(stack);
  if (const auto& printer = setup.placement.printer) stack->turn_for(printer->columns, printer->rows);
  CheckLimits limits;
  const auto grid = grid_of(*stack, options.job, setup, limits);
  PLUMBLINE_TRY(grid);
  const ArenaScope scope(arena);
  const auto words = arena.take_top<std::uint64_t>(BitImage::words_needed(grid->columns, grid->rows), "checks");
  PLUMBLINE_TRY(words);
  const BitImage mask(*words, grid->columns, grid->rows);
  CheckedMasks checked{options.job.scans[0], *grid, {}, {}};
  {
    const ArenaScope scratch(arena);
    auto checker = StackChecker::create(*grid, limits, arena);
    PLUMBLINE_TRY(checker);
    ProgressBar bar;
    const auto start = std::chrono::steady_clock::now();
    for (std::uint32_t k = 0; k < stack->layers(); ++k) {
      if (interrupted()) return fail(ErrorCode::kCancelled, "interrupted at layer %u of %u", k, stack->layers());
      const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
      if (!terminal.silent())
        bar.update("checking the layers", static_cast<double>(k) / stack->layers(), taken.count());
      PLUMBLINE_TRY(stack->read(k, mask));
      checker->next(mask);
    }
    bar.clear();
    checked.findings = checker->finish();
    find_what_matters(checked.findings, *grid, {});
    checked.grey = stack->grey();
  }
  const auto mask_of = [&](std::uint32_t layer) -> Expected<ConstBitImage> {
    PLUMBLINE_TRY(stack->read(layer, mask));
    return ConstBitImage(mask);
  };
  PLUMBLINE_TRY(write_issues_file(options.picture, checked, mask_of, arena));
  return checked;
}

Expected<CheckedMasks> check_scan(const CheckOptions& options, const JobSetup& setup, TerminalJob& terminal) {
  Arena& arena = terminal.arena();
  const auto scan = ScanFiles::open(options.job.scans);
  PLUMBLINE_TRY(scan);
  const auto supports = options.supports.over(true, {});
  PLUMBLINE_TRY(supports);
  const SliceSettings settings = slice_settings(setup, *supports);
  start_threads(setup.threads);
  SliceReport report;
  const auto sliced = slice_for_print(scan->sources(), settings, arena, &terminal.progress(), report);
  PLUMBLINE_TRY(sliced);
  for_each_remark(report,
                  [&](const Told& told, std::string_view remark) { terminal.warn(at_terminal(told, remark).view()); });
  CheckedMasks checked{scan->title(), sliced->rrep.grid, sliced->findings, {}};
  PLUMBLINE_TRY(write_issues_file(options.picture, checked, sliced->rrep, sliced->supports, arena));
  return checked;
}

/// @param shows_grey  the printer's panel does
Status write_findings(const CheckedMasks& masks, bool shows_grey, const CheckOptions& options,
                      const CheckPolicy& policy) {
  OutputFile out = OutputFile::standard_output();
  const StackFindings& found = masks.findings;
  const PrintGrid& grid = masks.grid;
  const IssueScale scale(grid);
  FixedText<2 * kMaxPath> text;
  text.add("masks      %s: %u of %u x %u px, %.4g x %.4g x %.4g mm each; %.1f ml\n", masks.name.c_str(), grid.layers,
           grid.columns, grid.rows, static_cast<double>(grid.pitch_x_mm), static_cast<double>(grid.pitch_y_mm),
           static_cast<double>(grid.layer_height_mm), scale.ml(found.voxels));
  text.add("areas      first layer %.4g mm2, largest %.4g mm2 (layer %u), largest jump %.4g mm2 (layer %u)\n",
           scale.mm2(found.first_layer_pixels), scale.mm2(found.peel_pixels), found.peel_layer,
           scale.mm2(found.jump_pixels), found.jump_layer);
  if (masks.grey.grey > 0) {
    const double lost = static_cast<double>(masks.grey.lost) / static_cast<double>(masks.grey.lit);
    text.add("grey       %.1f %% of the area is neither black nor white", 100 * masks.grey.share());
    if (!shows_grey) {
      text.add(": %.1f %% becomes black, %.1f %% white", 100 * lost, 100 * (masks.grey.share() - lost));
    }
    text.add("\n");
  }
  text.add("found      %s\n", issue_counts(found).c_str());
  PLUMBLINE_TRY(out.write(text.view()));
  Status written;
  for_each_issue(found, grid, policy, [&](IssueKind kind, CheckAction action, std::string_view sentence) {
    FixedText<512> line;
    const std::string_view word = kCheckActionWords[static_cast<std::size_t>(action)];
    line.add("%-10.*s %.*s\n", static_cast<int>(word.size()), word.data(), static_cast<int>(sentence.size()),
             sentence.data());
    if (written) written = out.write(line.view());
    if (!options.job.verbose) return;
    for (const Issue& issue : found.of(kind).told_kept()) {
      line.clear();
      line.add("           layers %u to %u, x %.1f, y %.1f mm: %.4g mm2, %.4g ml\n", issue.first_layer,
               issue.last_layer, scale.x_mm(issue), scale.y_mm(issue), scale.mm2(issue.pixels), scale.ml(issue.voxels));
      if (written) written = out.write(line.view());
    }
  });
  PLUMBLINE_TRY(written);
  if (options.picture.empty() || !found.any()) return {};
  text.clear();
  text.add("look at    %s\n", options.picture.c_str());
  return out.write(text.view());
}

Status write_findings_json(const CheckedMasks& masks, const CheckPolicy& policy) {
  OutputFile out = OutputFile::standard_output();
  JsonWriter json(out);
  json.begin_object();
  json.begin_object("plumbline", kOneLine);
  json.member("version", kVersion);
  json.end_object();
  json.member("name", masks.name);
  json.key("grid");
  write_object(json, kGridFields, masks.grid);
  if (masks.grey.lit > 0) {
    json.begin_object("grey", kOneLine);
    json.member("lit_pixels", masks.grey.lit);
    json.member("grey_pixels", masks.grey.grey);
    json.member("lost_pixels", masks.grey.lost);
    json.end_object();
  }
  json.member("volume_ml", IssueScale(masks.grid).ml(masks.findings.voxels));
  write_issues(json, masks.findings, masks.grid, policy);
  json.end_object();
  return json.finish();
}

}  // namespace

CLI::App* add_check_command(CLI::App& app, CheckOptions& options) {
  auto* command = app.add_subcommand(
      "check", "Find what would go wrong with layers: of a scan or a mesh, or in a folder or an archive");
  command->footer(kCheckFooter);
  command->add_option("--picture", options.picture, "Draw where the issues are")->type_name("PNG");
  add_slicing_options(*command, options.job, options.supports, options.checks)
      ->type_name("STACK|SCAN")
      ->description(
          "A folder of layers as PNG files, an archive (.sl1, .sl1s, .zip, .cws, .uvj, .nanodlp), or the files of a "
          "scan or mesh");
  show_basic(*command, {"--printer", "--layer-height", "--pixel-pitch", "--units", "--height", "--orient", "--rotate-x",
                        "--supports", "--check", "--accept", "--picture", "--verbose", "--json"});
  return command;
}

ExitCode run_check(const CheckOptions& options, std::span<std::byte> arena_block) {
  const auto setup = set_up(options.job, arena_block.size());
  if (!setup) return report_error(setup.error());
  TerminalJob terminal(options.job, *setup, arena_block);
  const std::string& first = options.job.scans[0];
  const bool stack = options.job.scans.size() == 1 && (is_folder(first) || is_archive_name(first));
  const auto masks = stack ? check_stack(options, *setup, terminal) : check_scan(options, *setup, terminal);
  if (!masks) return report_error(masks.error());
  const CheckPolicy policy = options.checks.over(checks_of(setup->board));
  const auto& board = setup->board;
  const bool shows_grey = board && board->machine && board->machine->panel.grey.has_grey();
  if (options.job.json || !options.job.quiet) {
    const auto written =
        options.job.json ? write_findings_json(*masks, policy) : write_findings(*masks, shows_grey, options, policy);
    if (!written) return report_error(written.error());
  }
  const auto judged = judge(masks->findings, masks->grid, policy);
  return judged ? ExitCode::kDone : report_error(judged.error());
}

}  // namespace plumbline::firmware
