#include <CLI/CLI.hpp>
#include <array>
#include <cmath>

#include "firmware/cli/commands.hpp"
#include "firmware/cli/options/shared_options.hpp"
#include "firmware/cli/terminal_job.hpp"
#include "firmware/io/fixed_text.hpp"
#include "firmware/io/json_writer.hpp"
#include "firmware/io/output_file.hpp"
#include "firmware/io/scan_files.hpp"
#include "firmware/pictures/orientation_picture.hpp"
#include "firmware/pictures/preview.hpp"
#include "slicer/preparation.hpp"

namespace plumbline {
namespace {

constexpr const char* kOrientFooter =
    "\nExamples:\n"
    "  plumbline orient bust.ply --picture ways.png\n"
    "  plumbline slice bust.ply -o out --rotate-x 25 --rotate-y -10   use one of them\n"
    "  plumbline slice bust.ply -o out --orient auto                  use the first\n"
    "\n"
    "Output: how the scan lies now and the best four ways up, each with the area that needs supports, the space below\n"
    "it, the area of the largest layer (which must be peeled off the film), the height, and the area of scars that\n"
    "supports leave, counted more where the scanner saw the surface better. Units are mm.\n";

struct Found {
  Orientation now;
  std::array<Orientation, kBestOrientations> best;
  double unit_mm = 1;  ///< mm of the print in the unit of the scan
};

using Line = FixedText<200>;

Line options_of(const Orientation& o) {
  Line text;
  text.add("--rotate-x %.4g --rotate-y %.4g", o.degrees[0], o.degrees[1]);
  return text;
}

Line cost_text(const OrientationCost& cost, double mm) {
  Line text;
  text.add("supports %.3g cm2, %.3g ml below; peel %.3g cm2; height %.4g mm; scars %.3g cm2",
           cost.support_area * mm * mm / 100, cost.support_volume * mm * mm * mm / 1000, cost.peel_area * mm * mm / 100,
           cost.height * mm, cost.scar_area * mm * mm / 100);
  return text;
}

Status draw(const PreparedScan& scan, const SurfaceSamples& samples, const Found& found, const std::string& title,
            const std::string& path, Arena& arena) {
  std::array<std::array<Line, 4>, kBestOrientations> texts;
  std::array<OrientationView, kBestOrientations> views;
  const double mm = found.unit_mm;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Orientation& o = found.best[i];
    // A line each, so that none is cut: somebody will type them.
    texts[i][0].add("--rotate-x %.4g", o.degrees[0]);
    texts[i][1].add("--rotate-y %.4g", o.degrees[1]);
    texts[i][2].add("supports %.3g cm2, %.3g ml", o.cost.support_area * mm * mm / 100,
                    o.cost.support_volume * mm * mm * mm / 1000);
    texts[i][3].add("peel %.3g cm2, %.4g mm high", o.cost.peel_area * mm * mm / 100, o.cost.height * mm);
    views[i] = {o.degrees, {texts[i][0].view(), texts[i][1].view(), texts[i][2].view(), texts[i][3].view()}};
  }
  auto encoder = PngEncoder::for_pictures(kPreviewColumns, kPreviewRows);
  PLUMBLINE_TRY(encoder);
  const float spacing = std::sqrt(samples.area / static_cast<float>(scan.cloud.size));
  const auto png = encode_orientations(scan.cloud, spacing, title, views, arena, *encoder);
  PLUMBLINE_TRY(png);
  return write_file(path.c_str(), *png);
}

void write_cost(JsonWriter& json, const Orientation& o, double mm) {
  json.begin_object(JsonWriter::Layout::kOneLine);
  json.member("rotate_x_deg", o.degrees[0]);
  json.member("rotate_y_deg", o.degrees[1]);
  json.member("cost", o.cost.total);
  json.member("support_mm2", o.cost.support_area * mm * mm);
  json.member("support_mm3", o.cost.support_volume * mm * mm * mm);
  json.member("peel_mm2", o.cost.peel_area * mm * mm);
  json.member("height_mm", o.cost.height * mm);
  json.member("scar_mm2", o.cost.scar_area * mm * mm);
  json.end_object();
}

Status write_proposals_json(OutputFile& out, const Found& found) {
  JsonWriter json(out);
  json.begin_object();
  json.key("now");
  write_cost(json, found.now, found.unit_mm);
  json.key("best");
  json.begin_array();
  for (const Orientation& o : found.best) write_cost(json, o, found.unit_mm);
  json.end_array();
  json.end_object();
  return json.finish();
}

Status write_proposals(OutputFile& out, const Found& found, const OrientOptions& options) {
  FixedText<2 * kMaxPath> text;
  text.add("as it lies   %s\n", cost_text(found.now.cost, found.unit_mm).c_str());
  for (const Orientation& o : found.best) {
    text.add("%s\n             %s\n", options_of(o).c_str(), cost_text(o.cost, found.unit_mm).c_str());
  }
  if (!options.picture.empty()) text.add("look at      %s\n", options.picture.c_str());
  return out.write(text.view());
}

}  // namespace

CLI::App* add_orient_command(CLI::App& app, OrientOptions& options) {
  auto* command = app.add_subcommand("orient", "Find the best ways up to print a scan or a mesh");
  command->footer(kOrientFooter);
  add_look_options(*command, options.job, options.picture, "Draw the best four ways up");
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
  Found found;
  const auto look = [&](const PreparedScan& prepared) -> Status {
    const auto samples = sample_surface(prepared.cloud, arena);
    PLUMBLINE_TRY(samples);
    found.now = {{0, 0}, cost_of(*samples, {0, 0})};
    const auto best = best_orientations(*samples, {});
    found.best = *best;
    Box3d box;
    for (const SurfaceSample& patch : samples->patches) box.extend(patch.position.cast<double>());
    const PlacementSettings placing = heed_header(settings.placement, report.scan.header);
    const double unit_mm = millimetres_per(units_of(box, placing));
    found.unit_mm = unit_mm * scale_of(box.size() * unit_mm, placing);
    return options.picture.empty() ? Status() : draw(prepared, *samples, found, scan->title(), options.picture, arena);
  };
  const auto done = prepare_normals(scan->sources(), settings, arena, &terminal.progress(), report, look);
  if (!done) return report_error(done.error());
  if (options.job.quiet && !options.job.json) return ExitCode::kDone;
  OutputFile out = OutputFile::standard_output();
  const auto written = options.job.json ? write_proposals_json(out, found) : write_proposals(out, found, options);
  return written ? ExitCode::kDone : report_error(written.error());
}

}  // namespace plumbline
