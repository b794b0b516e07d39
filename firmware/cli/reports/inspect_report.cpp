#include "firmware/cli/reports/inspect_report.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "firmware/io/progress_lines.hpp"
#include "firmware/io/text/fixed_text.hpp"
#include "firmware/io/version.hpp"
#include "firmware/messages/told_text.hpp"
#include "firmware/slice/issue_report.hpp"
#include "firmware/slice/job_report.hpp"
#include "firmware/slice/manifest.hpp"
#include "firmware/slice/proof_report.hpp"
#include "slicer/core/numbers/mib.hpp"
#include "slicer/core/words/plural.hpp"
#include "slicer/plan/mesh_plan.hpp"
#include "slicer/reader/formats/format_probe.hpp"
#include "slicer/source_checks.hpp"

namespace plumbline::firmware {
namespace {

using Text = FixedText<2 * kMaxPath>;

std::uint64_t missing_normals(const ScanSummary& scan) { return scan.header.has_normals ? 0 : scan.points; }

/// Adds each remark as a line.
auto remarks_in(Text& text) {
  return [&text](const Told& told, std::string_view sentence) {
    text.add("           %s\n", at_terminal(told, sentence).c_str());
  };
}

void add_scan(Text& text, const ScanOutlook& o) {
  const ScanSummary& scan = o.scan.scan;
  if (o.scan.mesh) {
    text.add("mesh       %s: %s\n", o.scan_name.c_str(), mesh_text(*o.scan.mesh).c_str());
    if (o.scan.mesh->not_finite > 0) {
      text.add("           %llu triangle%s left out: not finite\n", big(o.scan.mesh->not_finite),
               plural_s(o.scan.mesh->not_finite));
    }
    return;
  }
  text.add("scan       %s: %llu point%s %s\n", o.scan_name.c_str(), big(scan.points), plural_s(scan.points),
           scan.header.has_normals ? "with normals" : "without normals, which are estimated");
  for (std::size_t i = 0; o.scan_names.size() > 1 && i < std::min(o.scan_names.size(), o.scan.scans.count); ++i) {
    text.add("           %.60s: %llu point%s, %s\n", o.scan_names[i].c_str(), big(o.scan.scans.each[i].points),
             plural_s(o.scan.scans.each[i].points),
             o.scan.scans.each[i].header.has_normals ? "with normals" : "without normals");
  }
  for_each_dropped(scan, [&](const char* sentence) { text.add("           %s\n", sentence); });
  for_each_scan_remark(o.scan, o.mm(o.scan.lengths.averaged_noise), o.unit_mm() * o.scale(), remarks_in(text));
}

/// Size and layers, whether they fit, and how long they take: the lines that `plumbline slice` prints, before slicing.
void add_print(Text& text, const ScanOutlook& o, std::string_view print_time) {
  const std::string& printer = o.printer_name;
  if (o.scan.placement) {
    text.add("print      %s%s%s\n", size_text(*o.scan.placement).c_str(), printer.empty() ? "" : " on ",
             printer.c_str());
  } else {
    const Vec3d mm = o.scan.bounds.size() * o.unit_mm() * o.scale();
    text.add("size       %.2f x %.2f x %.2f mm\n", mm[0], mm[1], mm[2]);
    text.add("fits       no: %s\n", at_terminal(o.scan.placement.error()).c_str());
  }
  if (o.largest_scale)
    text.add("%s up to scale %.4g\n", o.scan.placement ? "fits       yes," : "          ", *o.largest_scale);
  const double longest = o.scan.bounds.size().maxCoeff();
  if (o.scan.ignored_units) {
    text.add("units      %s\n",
             at_terminal(PrinterCode::kUnitsIgnored, ignored_units_warning(*o.scan.ignored_units).view()).c_str());
  } else if (o.placement.units == Units::kAuto && !o.placement.size) {
    text.add(
        "units      %s, a guess: the scan is %.4g units long, so it is %.4g mm. Give --units or --height to be sure\n",
        to_string(o.guess), longest, longest * millimetres_per(o.guess));
  } else if (o.guess != o.scan.units && !o.placement.size) {
    text.add("units      %s; a size of %.4g units suggests %s (%.4g mm). Give --units to be sure\n",
             to_string(o.scan.units), longest, to_string(o.guess), longest * millimetres_per(o.guess));
  }
  if (!print_time.empty()) text.add("time       %.*s\n", static_cast<int>(print_time.size()), print_time.data());
}

void add_coverage(Text& text, const ScanOutlook& o) {
  if (o.scan.mesh) return;
  if (o.coverage) {
    text.add("proven     %s\n", proven_text(o.scan.coarse.proof).c_str());
    text.add("scanned    %s\n", scanned_text(Unseen::of(o.coverage->shares)).c_str());
  } else {
    text.add("scanned    unknown: %s\n", at_terminal(o.scan.sliced.error()).c_str());
  }
  if (o.scan.turned) {
    text.add("turned     to its best orientation: --rotate-x %.4g --rotate-y %.4g\n", o.scan.turned->degrees[0],
             o.scan.turned->degrees[1]);
  }
  remark_on_orientation(o.scan, remarks_in(text));
}

void add_issues(Text& text, const ScanOutlook& o) {
  if (!o.findings) return;
  bool any = false;
  for (std::size_t i = 0; i < kIssueKindCount; ++i) {
    const auto kind = static_cast<IssueKind>(i);
    if (o.findings->count(kind) == 0) continue;
    text.add("%-10s %s%s\n", any ? "" : "issues", issue_sentence(kind, *o.findings, o.coarse_grid).c_str(),
             kind == IssueKind::kFreePiece || kind == IssueKind::kTear ? ", without supports" : "");
    any = true;
  }
  if (!any) text.add("issues     none seen in a coarse slice\n");
}

/// Writes what the file holds and the grid that it goes into.
void add_details(Text& text, const ScanOutlook& o) {
  const ScanSummary& scan = o.scan.scan;
  text.add("file       %s %s, %.1f MB\n", to_string(scan.header.format), scan.header.encoding,
           static_cast<double>(scan.bytes) / 1e6);
  if (o.scan.mesh) {
    text.add(
        "faces      %llu with %llu vertices; %llu of %llu rays of a coarse slice do not leave as often as they enter\n",
        big(o.scan.mesh->faces), big(o.scan.mesh->vertices), big(o.scan.mesh->broken_rays), big(o.scan.mesh->rays));
  }
  if (scan.header.has_normals) text.add("normals    of length zero: %llu\n", big(scan.without_normal));
  if (o.scan.stated_views.count > 0) {
    text.add("views      %u; where the scanner stood is known of %u\n", o.scan.stated_views.count,
             o.scan.stated_views.scanners);
  }
  const Vec3d size = o.scan.bounds.size();
  const Vec3d whole = o.scan.bounds_with_noise.size();
  text.add("extent     %.6g x %.6g x %.6g in the file's units, %.6g x %.6g x %.6g with outliers; 1 unit is 1 %s\n",
           size[0], size[1], size[2], whole[0], whole[1], whole[2], to_string(o.scan.units));
  if (o.scan.placement) {
    const PrintGrid& grid = o.scan.placement->grid;
    text.add("grid       %u x %u px of %.4g x %.4g mm, at scale %.4g\n", grid.columns, grid.rows,
             static_cast<double>(grid.pitch_x_mm), static_cast<double>(grid.pitch_y_mm), o.scale());
  }
  if (o.placement.printer) {
    const PrinterVolume& v = *o.placement.printer;
    text.add("printer    %s: %.2f x %.2f x %.2f mm\n", o.printer_name.c_str(),
             v.columns * static_cast<double>(v.pitch_x_mm), v.rows * static_cast<double>(v.pitch_y_mm),
             static_cast<double>(v.travel_mm));
  }
}

void add_surface(Text& text, const ScanOutlook& o) {
  if (o.scan.mesh) return;
  const InspectReport& s = o.scan;
  text.add("spacing    %.3g mm to the nearest point (median); epsilon %.3g mm\n", o.mm(s.spacing),
           o.mm(s.lengths.epsilon));
  text.add("noise      %.3g mm, standard deviation off the surface; %.3g mm off the plane of %u neighbours (median)\n",
           o.mm(s.lengths.noise), o.mm(s.roughness), kPlaneNeighbours);
  text.add("points     %s\n", classes_text(s.clustering.points).c_str());
}

void add_plan(Text& text, const ScanOutlook& o) {
  const InspectReport& s = o.scan;
  if (s.mesh) {
    // A mesh takes the same room whatever its number of triangles.
  } else if (s.averaged_points > 0) {
    text.add("thinning   from %llu to %u points: one for each cell of %.3g mm; the arena has room for %u\n",
             big(s.scan.points), s.cloud_points, o.mm(s.lengths.thinning_cell), s.cloud_capacity);
  } else {
    text.add("thinning   none: the arena has room for %u points\n", s.cloud_capacity);
  }
  if (!o.plan) {
    text.add("arena      %s\n", o.plan.error().message());
    return;
  }
  FixedText<32> points;
  if (!s.mesh) points.add(" for %u points", o.plan->points);
  text.add("arena      %.1f of %.0f MiB%s with %u thread%s; by stage:\n", mib(o.plan->peak()), mib(o.arena_bytes),
           points.c_str(), o.threads, plural_s(o.threads));
  for (std::size_t i = 0; i < kStageCount; ++i) {
    if (o.plan->bytes[i] == 0) continue;
    const std::string_view name = to_string(static_cast<Stage>(i));
    text.add("  %-11.*s %9.1f MiB\n", static_cast<int>(name.size()), name.data(), mib(o.plan->bytes[i]));
  }
}

void write_scan(JsonWriter& json, const ScanOutlook& o) {
  const ScanSummary& scan = o.scan.scan;
  json.begin_object("scan");
  json.member("name", o.scan_name);
  write_fields(json, kScanFields, scan);
  json.begin_object("normals", kOneLine);
  json.member("have", scan.points - std::max(scan.without_normal, missing_normals(scan)));
  json.member("missing", missing_normals(scan));
  json.member("zero_length", scan.header.has_normals ? scan.without_normal : 0);
  json.end_object();
  write_fields(json, kNormalFields, o.scan.normals);
  json.begin_object("views", kOneLine);
  json.member("stated", o.scan.stated_views.count);
  json.member("scanners_known", o.scan.stated_views.scanners);
  json.end_object();
  write_files(json, o.scan_names, o.scan.scans);
  json.end_object();
}

void write_fit(JsonWriter& json, const ScanOutlook& o) {
  const auto& placement = o.scan.placement;
  json.member("printer", o.placement.printer ? std::optional(o.printer_name) : std::nullopt);
  json.member("fits", placement.has_value());
  if (!placement) json.member("fits_not_because", at_terminal(placement.error()));
  json.member("largest_scale", o.largest_scale);
  json.key("grid");
  if (!placement) return json.null();
  write_object(json, kGridFields, placement->grid);
}

void write_plan(JsonWriter& json, const ScanOutlook& o) {
  json.begin_object("thinning", kOneLine);
  json.member("cell_mm", o.mm(o.scan.lengths.thinning_cell));
  json.member("points_left", o.scan.cloud_points);
  json.member("room_for_points", o.scan.cloud_capacity);
  json.end_object();
  json.begin_object("averaging", kOneLine);
  json.member("times", o.scan.averagings);
  json.member("noise_mm", o.mm(o.scan.lengths.averaged_noise));
  json.end_object();
  json.begin_object("arena");
  json.member("bytes", o.arena_bytes);
  json.member("threads", o.threads);
  json.key("planned_bytes");
  if (o.plan) {
    json.begin_object(kOneLine);
    for (std::size_t i = 0; i < kStageCount; ++i) json.member(to_string(static_cast<Stage>(i)), o.plan->bytes[i]);
    json.end_object();
  } else {
    json.null();
  }
  json.end_object();
}

void write_unseen(JsonWriter& json, const std::optional<CoveragePreview>& coverage) {
  json.key("never_seen");
  if (!coverage) return json.null();
  json.begin_object(kOneLine);
  json.member("underside", coverage->underside_unseen());
  json.member("underside_share", coverage->shares.of(Evidence::kBase));
  json.member("rest_share", Unseen::of(coverage->shares).elsewhere);
  json.member("encloses_nothing", coverage->outside);
  json.end_object();
}

}  // namespace

ScanOutlook make_outlook(const InspectReport& scan, const PlacementSettings& placement, std::size_t arena_bytes,
                         std::uint32_t threads) {
  ScanOutlook o;
  o.scan = scan;
  o.placement = heed_header(placement, scan.scan.header);
  o.arena_bytes = arena_bytes;
  o.threads = threads;
  o.guess = scan.scan.header.is_in_mm ? Units::kMillimetres : guess_units(scan.came.maxCoeff());
  std::optional<PrintGrid> grid;
  if (placement.printer) {
    grid = panel_grid(*placement.printer, placement.layer_height_mm);
    PlacementSettings fitted = placement;
    fitted.fit = true;
    if (const auto largest = place(scan.bounds, o.unit_mm(), fitted)) o.largest_scale = largest->scale / o.unit_mm();
  } else if (o.scan.placement) {
    grid = o.scan.placement->grid;
  }
  if (scan.mesh) {
    // Without a place on the printer there is nothing to plan.
    o.plan = scan.placement ? plan_mesh(need_of(*scan.mesh, *scan.placement), threads) : MemoryPlan{};
    return o;
  }
  o.plan = largest_plan(arena_bytes, scan.cloud_points, grid, threads, {.confidence = true});
  return o;
}

Status write_outlook(OutputFile& out, const ScanOutlook& outlook, std::string_view print_time, bool verbose) {
  Text text;
  add_scan(text, outlook);
  add_print(text, outlook, print_time);
  add_coverage(text, outlook);
  add_issues(text, outlook);
  if (verbose) {
    add_details(text, outlook);
    add_surface(text, outlook);
    add_plan(text, outlook);
  }
  return out.write(text.view());
}

void write_outlook(JsonWriter& json, const ScanOutlook& outlook) {
  const InspectReport& s = outlook.scan;
  json.begin_object();
  json.begin_object("plumbline", kOneLine);
  json.member("version", kVersion);
  json.end_object();
  write_scan(json, outlook);
  write_mesh(json, s.mesh);
  json.member("extent_scan_units", s.bounds.size());
  json.member("extent_with_noise_scan_units", s.bounds_with_noise.size());
  json.begin_object("units", kOneLine);
  json.member("used", s.units);
  json.member("guess", outlook.guess);
  json.end_object();
  json.member("size_mm", Vec3d(s.bounds.size() * outlook.unit_mm() * outlook.scale()));
  json.member("spacing_mm", outlook.mm(s.spacing));
  json.member("epsilon_mm", outlook.mm(s.lengths.epsilon));
  json.member("noise_mm", outlook.mm(s.lengths.noise));
  json.member("roughness_mm", outlook.mm(s.roughness));
  json.begin_object("points", kOneLine);
  write_by<PointClass>(json, s.clustering.points.counts);
  json.end_object();
  write_position(json, s);
  write_proof(json, s.coarse.proof);
  write_unseen(json, outlook.coverage);
  write_issues(json, outlook.findings, outlook.coarse_grid, {});
  write_fit(json, outlook);
  write_plan(json, outlook);
  json.end_object();
}

}  // namespace plumbline::firmware
