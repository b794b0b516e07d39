#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "firmware/cli/commands.hpp"
#include "firmware/cli/options/shared_options.hpp"
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
    "  plumbline orient bust.ply --picture ways.png\n"
    "  plumbline slice bust.ply -o out --rotate-x 25 --rotate-y -10   use one of them\n"
    "  plumbline slice bust.ply -o out --orient auto                  use the first\n"
    "\n"
    "Output: how the scan lies now and the best four orientations. For each: the area that needs supports, the space\n"
    "below it, the area of the largest layer (which must be peeled off the film), the height, and the area of the\n"
    "scars that supports leave, counted more where the scanner saw the surface better. Units are mm.\n";

using OrientLine = FixedText<200>;

OrientLine options_of(const Proposal& o) {
  OrientLine text;
  text.add("--rotate-x %.4g --rotate-y %.4g", o.degrees[0], o.degrees[1]);
  return text;
}

OrientLine cost_text(const Proposal& cost) {
  OrientLine text;
  text.add("supports %.3g cm2, %.3g ml below; peel %.3g cm2; height %.4g mm; scars %.3g cm2", cost.support_mm2 / 100,
           cost.support_mm3 / 1000, cost.peel_mm2 / 100, cost.height_mm, cost.scar_mm2 / 100);
  return text;
}

Status draw(const PreparedScan& scan, const SurfaceSamples& samples, const Proposals& found, const std::string& title,
            const std::string& path, Arena& arena) {
  std::array<std::array<OrientLine, 6>, kBestOrientations> texts;
  std::array<OrientationView, kBestOrientations> views;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Proposal& o = found[i + 1];
    // A line each, so that none is cut: somebody will type them.
    texts[i][0].add("--rotate-x %.4g", o.degrees[0]);
    texts[i][1].add("--rotate-y %.4g", o.degrees[1]);
    texts[i][2].add("%.3g cm2 need supports,", o.support_mm2 / 100);
    texts[i][3].add("with %.3g ml of room below", o.support_mm3 / 1000);
    texts[i][4].add("peels %.3g cm2 at most", o.peel_mm2 / 100);
    texts[i][5].add("%.4g mm high", o.height_mm);
    views[i].degrees = o.degrees;
    std::ranges::transform(texts[i], views[i].lines.begin(), &OrientLine::view);
  }
  auto encoder = PictureEncoder::create(kPageBytes);
  PLUMBLINE_TRY(encoder);
  const float spacing = std::sqrt(samples.area / static_cast<float>(scan.cloud.size));
  const auto png = encode_orientations(scan.cloud, spacing, title, views, arena, *encoder);
  PLUMBLINE_TRY(png);
  return write_file(path.c_str(), *png);
}

void write_cost(JsonWriter& json, const Proposal& o) {
  json.begin_object(JsonWriter::Layout::kOneLine);
  json.member("rotate_x_deg", o.degrees[0]);
  json.member("rotate_y_deg", o.degrees[1]);
  json.member("cost", o.cost);
  json.member("support_mm2", o.support_mm2);
  json.member("support_mm3", o.support_mm3);
  json.member("peel_mm2", o.peel_mm2);
  json.member("height_mm", o.height_mm);
  json.member("scar_mm2", o.scar_mm2);
  json.end_object();
}

Status write_proposals_json(OutputFile& out, const Proposals& found) {
  JsonWriter json(out);
  json.begin_object();
  json.key("now");
  write_cost(json, found[0]);
  json.begin_array("best");
  for (const Proposal& o : std::span(found).subspan(1)) write_cost(json, o);
  json.end_array();
  json.end_object();
  return json.finish();
}

Status write_proposals(OutputFile& out, const Proposals& found, const OrientOptions& options) {
  FixedText<2 * kMaxPath> text;
  text.add("as it lies   %s\n", cost_text(found[0]).c_str());
  for (const Proposal& o : std::span(found).subspan(1)) {
    text.add("%s\n             %s\n", options_of(o).c_str(), cost_text(o).c_str());
  }
  if (!options.picture.empty()) text.add("look at      %s\n", options.picture.c_str());
  return out.write(text.view());
}

}  // namespace

CLI::App* add_orient_command(CLI::App& app, OrientOptions& options) {
  auto* command = app.add_subcommand("orient", "Find the best orientations to print a scan or a mesh in");
  command->footer(kOrientFooter);
  add_look_options(*command, options.job, options.picture, "Draw the best four orientations");
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
  TerminalJob terminal(options.job, *setup, arena_block);
  Arena& arena = terminal.arena();
  const auto scan = ScanFiles::open(options.job.scans);
  if (!scan) return report_error(scan.error());
  const SliceSettings settings = set_threads(slice_settings(*setup));
  PreparationReport report;
  Proposals found;
  const auto look = [&](const PreparedScan& prepared, const SurfaceSamples& samples) -> Status {
    const auto proposals = propose_orientations(samples, report.scan.header, settings.placement, {});
    PLUMBLINE_TRY(proposals);
    found = *proposals;
    return options.picture.empty() ? Status() : draw(prepared, samples, found, scan->title(), options.picture, arena);
  };
  const auto done = prepare_normals(scan->sources(), settings, arena, &terminal.progress(), report, look);
  if (!done) return report_error(done.error());
  if (options.job.quiet && !options.job.json) return ExitCode::kDone;
  OutputFile out = OutputFile::standard_output();
  const auto written = options.job.json ? write_proposals_json(out, found) : write_proposals(out, found, options);
  return written ? ExitCode::kDone : report_error(written.error());
}

}  // namespace plumbline::firmware
