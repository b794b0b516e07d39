#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <system_error>

#include "firmware/archive/layer_archive.hpp"
#include "firmware/cli/commands.hpp"
#include "firmware/cli/options/grey_option.hpp"
#include "firmware/cli/options/help_format.hpp"
#include "firmware/cli/options/shared_options.hpp"
#include "firmware/cli/reports/print_time.hpp"
#include "firmware/cli/terminal_job.hpp"
#include "firmware/io/output_file.hpp"
#include "firmware/io/scan_names.hpp"
#include "firmware/io/text/json_writer.hpp"
#include "firmware/settings/print_profile.hpp"
#include "firmware/slice/job_summary.hpp"
#include "firmware/slice/manifest.hpp"
#include "firmware/slice/slice_job.hpp"
#include "slicer/reader/formats/foreign_formats.hpp"
#include "slicer/reader/stream/words.hpp"

namespace plumbline::firmware {
namespace {

constexpr const char* kSliceFooter =
    "\nExamples:\n"
    "  plumbline slice bust.ply -o out --printer mono2k         centred on the printer's plate\n"
    "  plumbline slice bust.ply -o out --printer mono2k --fit   as large as the printer can\n"
    "  plumbline slice bust.ply -o out --supports none          without supports, even if something falls\n"
    "  plumbline slice bust.ply -o out --rotate-x 90            a scan whose y points up; --depth 80mm is its height\n"
    "  plumbline slice front.ply back.ply -o out                one scan in two files\n"
    "  plumbline slice part.stl -o out --printer mono2k         a mesh: STL, OBJ, PLY, OFF or 3MF\n"
    "  plumbline slice part.stl -o part.sl1 --printer mono2k    an archive that PrusaSlicer and UVtools open\n"
    "\n"
    "Output:\n"
    "  OUT/layers/00000.png ...  a mask per layer, lowest first: 1-bit greyscale, white cures, row 0 has the smallest "
    "y;\n"
    "                            with grey pixels 8-bit, a level is the share of the dose\n"
    "  OUT/preview.png           the print from the front, the side and above\n"
    "  OUT/coverage.png          which parts of the surface were scanned, and which were closed; not of a mesh\n"
    "  OUT/manifest.json         grid, hashes, figures; written last, so a job that has it is complete\n"
    "An older job in OUT is replaced. A folder that holds anything else is refused.\n"
    "If OUT ends in .sl1 or .sl1s: one archive of the same masks, with thumbnails, and with exposures from the "
    "printer's\n"
    "profile in config.ini and prusaslicer.ini. An older file is replaced.\n"
    "\n"
    "Exit status: 0 done, 1 file, scan or disk error, 2 wrong command line, 130 interrupted.\n";

Status write_result(const JobReport& report, const SliceOptions& options, const JobSetup& setup) {
  OutputFile out = OutputFile::standard_output();
  if (options.job.json) {
    JsonWriter json(out);
    write_manifest(json, report, {});
    return json.finish();
  }
  std::optional<PrintTime> time;
  if (setup.board) {
    time = estimate_print_time(*setup.board, report.slice.placement.grid.layers,
                               static_cast<double>(setup.placement.layer_height_mm));
  }
  return write_summary(out, report, options.output.c_str(), time ? time->text() : std::string(), options.job.verbose);
}

}  // namespace

CLI::App* add_slice_command(CLI::App& app, SliceOptions& options) {
  auto* command = app.add_subcommand("slice", "Slice a scan or a mesh into layer masks");
  command->footer(kSliceFooter);
  command
      ->add_option("-o,--output", options.output,
                   "Folder for the layers, created if it is missing; or an archive, OUT.sl1")
      ->required()
      ->type_name("OUT");
  command->add_flag_callback(
      "--no-preview", [&options] { options.preview = false; },
      "Don't draw preview.png and coverage.png, nor an archive's thumbnails");
  add_slicing_options(*command, options.job, options.supports, options.checks);
  add_grey_option(*command, options.grey)->group(kPrinterGroup);
  show_basic(*command, {"--output", "--printer", "--layer-height", "--units", "--height", "--fit", "--orient",
                        "--rotate-x", "--supports", "--accept", "--verbose", "--json"});
  return command;
}

namespace {

Expected<ArchiveOutput> archive_output(const JobSetup& setup, const std::string& output) {
  if (!setup.board) {
    return fail(ErrorCode::kBadSetting,
                "%s: an .sl1 archive is made for a printer's panel.\tName the printer with --printer, or give a folder",
                output.c_str());
  }
  const BoardFile& board = *setup.board;
  const auto machine = machine_of(board, board.path);
  PLUMBLINE_TRY(machine);
  auto profile = read_print_profile(machine->profile, board.path);
  PLUMBLINE_TRY(profile);
  const auto seconds = [board](const PrintGrid& machine_grid) {
    const auto time =
        estimate_print_time(board, machine_grid.layers, static_cast<double>(machine_grid.layer_height_mm));
    return time ? std::chrono::duration<double>(time->time).count() : 0;
  };
  return ArchiveOutput{board, std::move(*profile), seconds};
}

struct ShownGrey {
  Grey grey = Grey::kOff;
  CureModel model;  ///< how the light of grey pixels cures; not known if the masks have none
};
/// @param grey  of --grey
Expected<ShownGrey> grey_of(const JobSetup& setup, const std::string& grey) {
  const bool is_asked_for = !grey.empty() && grey != kGreyWords[static_cast<std::size_t>(Grey::kOff)];
  if (!is_asked_for && (!setup.board || !setup.board->machine)) return ShownGrey();
  if (!setup.board) {
    return fail(ErrorCode::kBadSetting,
                "--grey %s: grey is made for a printer's panel.\tName the printer with --printer, or leave out --grey",
                grey.c_str());
  }
  const BoardFile& board = *setup.board;
  const auto machine = machine_of(board, board.path);
  PLUMBLINE_TRY(machine);
  PrintProfile profile = profile_or_defaults(setup.board);
  if (is_asked_for) {
    auto read = read_print_profile(machine->profile, board.path);
    PLUMBLINE_TRY(read);
    profile = std::move(*read);
  }
  PLUMBLINE_TRY(choose_grey(grey, board, *machine, profile));
  const CureModel model = grey_model(profile, *machine);
  return ShownGrey{model.is_known() ? shown_grey(profile, *machine) : Grey::kOff, model};
}

}  // namespace

/// Refuses names that say they are files, unless there is such a folder: a new folder part.ctb is nothing that a printer or a
/// slicer opens.
Status check_output_name(const std::string& output) {
  std::error_code unknown;
  if (is_sl1_name(output) || std::filesystem::is_directory(output, unknown)) return {};
  const bool is_file = foreign_format(in_lower_case(output)) != nullptr || is_archive_name(output) ||
                       is_scan_file_name(output) || has_ending(output, ".png");
  if (!is_file) return {};
  return fail(ErrorCode::kBadSetting,
              "%s: files of this kind are not written.\tGive a folder, or an archive that ends in .sl1 or .sl1s; a "
              "folder of this name needs a slash at its end",
              output.c_str());
}

ExitCode run_slice(const SliceOptions& options, std::span<std::byte> arena_block) {
  if (const auto named = check_output_name(options.output); !named) return report_error(named.error());
  const auto setup = set_up(options.job, arena_block.size());
  if (!setup) return report_error(setup.error());
  SliceJobSettings settings;
  settings.scan_paths = options.job.scans;
  settings.output_path = options.output;
  if (is_sl1_name(options.output)) {
    auto archive = archive_output(*setup, options.output);
    if (!archive) return report_error(archive.error());
    settings.archive = std::move(*archive);
  }
  const auto grey = grey_of(*setup, options.grey);
  if (!grey) return report_error(grey.error());
  settings.grey = grey->model;
  settings.printer_name = setup->printer_name;
  settings.preview = options.preview;
  settings.slice = slice_settings(*setup, *options.supports.over(true, {}));  // checked when the arguments were parsed
  settings.slice.grey = grey->grey;
  settings.checks = options.checks.over(checks_of(setup->board));
  TerminalJob terminal(options.job, *setup, arena_block, WholeProgress(Stage::kLayers, true));
  auto job = SliceJob::prepare(settings, terminal.arena());
  if (!job) return report_error(job.error());
  const auto done = job->run(terminal.progress());
  if (!done) {
    if (done.error().code() == ErrorCode::kDoesNotFit) {
      return report_error(done.error().with_prefix(job->report().scan_name));
    }
    if (done.error().code() != ErrorCode::kCancelled) return report_error(done.error());
    return report_error(Error::format(ErrorCode::kCancelled, "interrupted; nothing of this job was left in %s",
                                      options.output.c_str()));
  }
  for (const auto& warning : job->report().warnings.all()) terminal.warn(warning.view());
  if (options.job.quiet && !options.job.json) return ExitCode::kDone;
  const auto written = write_result(job->report(), options, *setup);
  return written ? ExitCode::kDone : report_error(written.error());
}

}  // namespace plumbline::firmware
