#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <span>

#include "firmware/cli/commands.hpp"
#include "firmware/cli/options/shared_options.hpp"
#include "firmware/cli/reports/print_time.hpp"
#include "firmware/cli/terminal_job.hpp"
#include "firmware/io/output_file.hpp"
#include "firmware/io/scan_files.hpp"
#include "firmware/io/text/fixed_text.hpp"
#include "firmware/io/text/json_writer.hpp"
#include "firmware/pictures/orientation_picture.hpp"
#include "firmware/pictures/preview/preview.hpp"
#include "firmware/slice/orientation_proposals.hpp"
#include "slicer/preparation.hpp"

namespace plumbline::firmware {
namespace {

constexpr const char* kOrientFooter =
    "\nExamples:\n"
    "  plumbline orient bust.ply --height 80mm --picture ways.png\n"
    "  plumbline orient bust.ply --keep-clean -y                       its face, which looks to -y, gets no scars\n"
    "  plumbline slice bust.ply -o out --rotate-x 25 --rotate-y -10   use one of them\n"
    "  plumbline slice bust.ply -o out --orient auto                  use the best\n"
    "\n"
    "Output: the scan as it came and the best four orientations that differ from it by 20 degrees or more, and from "
    "each\n"
    "other by 30. All are of one size: --height and its like are those of the scan as it came. For each:\n"
    "  height of the object, mm; layers of the print, with the lift on supports; its time, with --printer\n"
    "  tips: places that supports hold; the area where they touch the object, mm2; supports and raft, ml. They are "
    "found\n"
    "  as for a print, with the usual supports, on a model of 128 voxels along its longest side\n"
    "  peel: area of the largest layer, which must be peeled off the film, cm2\n"
    "The best one, marked *, costs least; --json has what is weighed.\n";

using OrientLine = FixedText<200>;

OrientLine options_of(const Proposal& o) {
  OrientLine text;
  text.add("--rotate-x %.4g --rotate-y %.4g", o.degrees[0], o.degrees[1]);
  return text;
}

/// How long a print takes; empty without a printer or a time.
std::string time_of(const Proposal& o, const JobSetup& setup) {
  if (!setup.board) return {};
  const auto time = estimate_print_time(*setup.board, o.layers, static_cast<double>(setup.placement.layer_height_mm));
  return time ? time->text() : std::string();
}

OrientLine figures_of(const Proposal& o, const JobSetup& setup) {
  OrientLine text;
  text.add("%.4g mm high, %u layers", o.height_mm, o.layers);
  if (const std::string time = time_of(o, setup); !time.empty()) text.add(", %s", time.c_str());
  if (o.counted != 0) {
    text.add("; %u tips, scars %.3g mm2, supports %.3g ml", o.tips, o.tip_scars_mm2, o.supports_mm3 / 1000);
  }
  text.add("; peel %.3g cm2", o.peel_mm2 / 100);
  return text;
}

Status draw(const PreparedScan& scan, const Proposals& found, const std::string& title, const std::string& path,
            Arena& arena) {
  std::array<std::array<OrientLine, 6>, kBestOrientations> texts;
  std::array<OrientationView, kBestOrientations> views;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Proposal& o = found[i + 1];
    // A line each, so that none is cut: somebody will type them.
    texts[i][0].add("--rotate-x %.4g", o.degrees[0]);
    texts[i][1].add("--rotate-y %.4g", o.degrees[1]);
    texts[i][2].add("%.4g mm high, %u layers", o.height_mm, o.layers);
    if (o.counted != 0) {
      texts[i][3].add("%u tips, scars of %.3g mm2", o.tips, o.tip_scars_mm2);
      texts[i][4].add("%.3g ml of supports", o.supports_mm3 / 1000);
    } else {
      texts[i][3].add("%.3g cm2 need supports,", o.support_mm2 / 100);
      texts[i][4].add("with %.3g ml of room below", o.support_mm3 / 1000);
    }
    texts[i][5].add("peels %.3g cm2 at most", o.peel_mm2 / 100);
    views[i].degrees = o.degrees;
    std::ranges::transform(texts[i], views[i].lines.begin(), &OrientLine::view);
  }
  auto encoder = PictureEncoder::create(kPageBytes);
  PLUMBLINE_TRY(encoder);
  const auto png = encode_orientations(scan.cloud, title, views, arena, *encoder);
  PLUMBLINE_TRY(png);
  return write_file(path.c_str(), *png);
}

void write_proposal(JsonWriter& json, const Proposal& o) {
  const auto if_counted = [&](auto value) { return o.counted != 0 ? std::optional(value) : std::nullopt; };
  json.begin_object(JsonWriter::Layout::kOneLine);
  json.member("rotate_x_deg", o.degrees[0]);
  json.member("rotate_y_deg", o.degrees[1]);
  json.member("cost", o.cost);
  json.member("support_mm2", o.support_mm2);
  json.member("support_mm3", o.support_mm3);
  json.member("peel_mm2", o.peel_mm2);
  json.member("height_mm", o.height_mm);
  json.member("scar_mm2", o.scar_mm2);
  json.member("layers", o.layers);
  json.member("tips", if_counted(o.tips));
  json.member("tip_scars_mm2", if_counted(o.tip_scars_mm2));
  json.member("supports_mm3", if_counted(o.supports_mm3));
  json.end_object();
}

Status write_proposals_json(OutputFile& out, const Proposals& found) {
  JsonWriter json(out);
  json.begin_object();
  json.key("now");
  write_proposal(json, found[0]);
  json.begin_array("best");
  for (const Proposal& o : std::span(found).subspan(1)) write_proposal(json, o);
  json.end_array();
  json.member("cheapest", static_cast<std::uint32_t>(best_of(found)));
  json.end_object();
  return json.finish();
}

Status write_proposals(OutputFile& out, const Proposals& found, const OrientOptions& options, const JobSetup& setup) {
  FixedText<2 * kMaxPath> text;
  for (std::size_t i = 0; i < found.size(); ++i) {
    text.add("%c %s\n             %s\n", i == best_of(found) ? '*' : ' ',
             i == 0 ? "as it came" : options_of(found[i]).c_str(), figures_of(found[i], setup).c_str());
  }
  if (!options.picture.empty()) text.add("  look at    %s\n", options.picture.c_str());
  return out.write(text.view());
}

}  // namespace

CLI::App* add_orient_command(CLI::App& app, OrientOptions& options) {
  auto* command =
      app.add_subcommand("orient", "Find the best orientations to print a scan or a mesh in, with their supports");
  command->footer(kOrientFooter);
  add_look_options(*command, options.job, options.picture, "Draw the best four orientations");
  command->get_option("--keep-clean")->remove_needs(command->get_option("--orient"));
  command->callback([&options] {
    for (const double angle : options.job.rotate_degrees) {
      if (angle != 0)
        throw CLI::ValidationError("orient finds the rotation: leave out --rotate-x, --rotate-y and --rotate-z");
    }
  });
  return command;
}

ExitCode run_orient(const OrientOptions& options, std::span<std::byte> arena_block) {
  const auto setup = set_up(options.job, arena_block.size());
  if (!setup) return report_error(setup.error());
  TerminalJob terminal(options.job, *setup, arena_block, WholeProgress(Stage::kSupports));
  Arena& arena = terminal.arena();
  const auto scan = ScanFiles::open(options.job.scans);
  if (!scan) return report_error(scan.error());
  const SliceSettings settings = set_threads(slice_settings(*setup, SupportSettings()));
  PreparationReport report;
  Proposals found;
  const auto look = [&](const PreparedScan& prepared, const SurfaceSamples& samples) -> Status {
    const StageScope stage(Stage::kSupports, {arena, &terminal.progress(), report});
    const auto proposals = propose_orientations(prepared.cloud, samples, report.scan.header, settings, arena,
                                                {&terminal.progress(), Stage::kSupports});
    PLUMBLINE_TRY(proposals);
    found = *proposals;
    return options.picture.empty() ? Status() : draw(prepared, found, scan->title(), options.picture, arena);
  };
  const auto done = prepare_normals(scan->sources(), settings, arena, &terminal.progress(), report, look);
  if (!done) return report_error(done.error());
  if (options.job.quiet && !options.job.json) return ExitCode::kDone;
  OutputFile out = OutputFile::standard_output();
  const auto written =
      options.job.json ? write_proposals_json(out, found) : write_proposals(out, found, options, *setup);
  return written ? ExitCode::kDone : report_error(written.error());
}

}  // namespace plumbline::firmware
