#include "firmware/slice/job_summary.hpp"

#include <algorithm>
#include <string_view>

#include "firmware/slice/job_archive.hpp"
#include "firmware/slice/proof_report.hpp"
#include "slicer/core/numbers/mib.hpp"
#include "slicer/core/words/plural.hpp"
#include "slicer/reader/formats/format_probe.hpp"

namespace plumbline::firmware {
namespace {

using Text = FixedText<3 * kMaxPath>;

double percent(double part, double whole) { return whole > 0 ? 100 * part / whole : 0; }

/// Lists the files if there are several.
void add_files(Text& text, std::span<const std::string> names, const ScanSummaries& scans) {
  if (names.size() < 2) return;
  for (std::size_t i = 0; i < std::min(names.size(), scans.count); ++i) {
    text.add("           %.60s: %llu point%s\n", names[i].c_str(), big(scans.each[i].points),
             plural_s(scans.each[i].points));
  }
  for (std::size_t i = scans.count; i < names.size(); ++i)
    text.add("           %.60s: their poses\n", names[i].c_str());
}

void add_scan(Text& text, const JobReport& report) {
  const SliceReport& s = report.slice;
  if (s.mesh) {
    text.add("mesh       %s: %llu face%s, %s, %s %s\n", report.scan_name.c_str(), big(s.mesh->faces),
             plural_s(s.mesh->faces), mesh_text(*s.mesh).c_str(), to_string(s.scan.header.format),
             s.scan.header.encoding);
    return;
  }
  text.add("scan       %s: %llu points, %s %s, %s\n", report.scan_name.c_str(), big(s.scan.points),
           to_string(s.scan.header.format), s.scan.header.encoding,
           s.scan.header.has_normals ? "with normals" : "without normals");
  add_files(text, report.scan_names, s.scans);
  for_each_dropped(s.scan, [&](const char* sentence) { text.add("           %s\n", sentence); });
  if (s.outliers > 0) {
    text.add("           %u point%s dropped: outliers, far from others and on no surface\n", s.outliers,
             plural_s(s.outliers));
  }
  if (s.evened_points > 0) {
    text.add("           %u point%s averaged along the lines that they lie in\n", s.evened_points,
             plural_s(s.evened_points));
  }
  if (s.averaged_points > 0) {
    text.add("thinned    to %u points: one for each cell of %.3g mm (room for %u)\n", s.cloud_points,
             static_cast<double>(s.lengths.thinning_cell.value), s.cloud_capacity);
  } else {
    text.add("thinned    no: all %u points fit (room for %u)\n", s.cloud_points, s.cloud_capacity);
  }
}

/// What a person needs to know before printing.
void add_print(Text& text, const JobReport& report, std::string_view print_time) {
  const SliceReport& s = report.slice;
  const std::string& printer = report.printer_name;
  text.add("print      %s: %s%s%s\n", report.scan_name.c_str(), size_text(s.placement).c_str(),
           printer.empty() ? "" : " on ", printer.c_str());
  if (s.turned) {
    text.add("turned     to its best orientation: --rotate-x %.4g --rotate-y %.4g\n", s.turned->degrees[0],
             s.turned->degrees[1]);
  }
  if (s.asked_size && s.turned_since) {
    text.add("sized      as it came, before it was turned: %s %.4g mm\n", to_string(s.asked_size->side),
             s.asked_size->mm);
  }
  if (report.sizes.any()) text.add("corrected  %s\n", report.sizes.text().c_str());
  text.add("resin      %s ml", three_digits(report.volume_mm3() / 1000).c_str());
  if (report.supports.all() > 0) {
    text.add(", %s ml of it in %u support%s", three_digits(report.support_volume_mm3() / 1000).c_str(),
             report.supports.all(), plural_s(report.supports.all()));
  }
  text.add("\n");
  if (report.support_settings) {
    text.add("stands     %s\n",
             stand_text(*report.support_settings, report.supports, s.placement.grid.layer_height_mm).c_str());
  }
  if (report.grey == Grey::kFull) text.add("grey       where the object begins and where walls pass through pixels\n");
  if (report.grey == Grey::kVertical) text.add("grey       where the object begins: undersides between layers\n");
  if (!print_time.empty()) {
    text.add("time       %.*s\n", static_cast<int>(print_time.size()), print_time.data());
  }
  if (s.mesh) text.add("mesh       %s\n", mesh_text(*s.mesh).c_str());
  if (s.proof.points > 0) text.add("proven     %s\n", proven_text(s.proof).c_str());
  if (report.coverage) text.add("scanned    %s\n", scanned_text(Unseen::of(*report.coverage)).c_str());
}

void add_look_at(Text& text, const JobReport& report, const char* output) {
  if (is_sl1_name(output)) {
    text.add("written    %s\n", output);
    return;
  }
  text.add("look at    ");
  if (report.has_preview) text.add("%s/preview.png, ", output);
  if (report.has_coverage) text.add("%s/coverage.png, ", output);
  if (report.has_issue_picture) text.add("%s/issues.png, ", output);
  text.add("%s/layers/00000.png to %05u.png\n", output, report.slice.placement.grid.layers - 1);
}

void add_grid(Text& text, const JobReport& report) {
  const SliceReport& s = report.slice;
  const PrintGrid& grid = s.placement.grid;
  text.add("grid       %u x %u px of %.4g x %.4g mm; scan units: %s%s, %.6g mm each\n", grid.columns, grid.rows,
           static_cast<double>(grid.pitch_x_mm), static_cast<double>(grid.pitch_y_mm), to_string(s.units),
           s.units_guessed ? ", guessed" : "", s.placement.scale);
}

void add_clusters(Text& text, const SliceReport& s) {
  if (s.mesh) return;
  text.add("points     %s\n", classes_text(s.clustering.points).c_str());
  if (s.lengths.views_moved.value > 0) {
    const bool runs = s.stated_views.count == 0;
    text.add("views      %u%s moved by %.3g mm to agree: points were %.3g mm off their surface, now %.3g mm\n",
             runs ? kRuns : s.stated_views.count, runs ? " parts of the file, in its order," : "",
             static_cast<double>(s.lengths.views_moved.value), static_cast<double>(s.lengths.views_before.value),
             static_cast<double>(s.lengths.views_after.value));
  }
  text.add("lengths    epsilon %.3g mm, width %.3g mm, noise %.3g mm\n", static_cast<double>(s.lengths.epsilon.value),
           static_cast<double>(s.width_mm), static_cast<double>(s.lengths.noise.value));
}

void add_rays(Text& text, const JobReport& report) {
  const SliceReport& s = report.slice;
  if (s.mesh) {
    text.add(
        "rays       %llu pass the mesh, %llu times; broken %.3f %%, decided by the winding number %.3f %%; %llu "
        "crossings\n",
        big(s.mesh->rays), big(s.mesh->hits),
        percent(static_cast<double>(s.mesh->broken_rays), static_cast<double>(s.mesh->rays)),
        percent(static_cast<double>(s.mesh->decided_rays), static_cast<double>(s.mesh->rays)), big(s.crossings));
    return;
  }
  text.add("rays       %llu shot:", big(s.rays.interested()));
  for (std::size_t i = 0; i < kRayDecisionCount; ++i) {
    const auto decision = static_cast<RayDecision>(i);
    text.add("%s %s %.2f %%", i == 0 ? "" : ",", to_string(decision), 100 * report.share_of_rays(decision));
  }
  text.add("; %llu crossings\n", big(s.crossings));
  if (!s.components.counted) return;
  text.add(
      "components solid: %u, cavities: %u; small solids removed: %u, small cavities filled: %u; voxels changed: %llu\n",
      s.components.solids, s.components.cavities, s.components.dropped_solids - s.components.floating_solids,
      s.components.filled_cavities - s.components.sealed_cavities, big(s.components.changed_voxels));
}

void add_evidence(Text& text, const JobReport& report) {
  if (!report.coverage) return;
  text.add("surface    ");
  for (std::size_t e = 0; e < kEvidenceCount; ++e) {
    text.add("%s%s %.2f %%", e == 0 ? "" : ", ", to_string(static_cast<Evidence>(e)),
             100 * report.coverage->surface[e]);
  }
  text.add("\n");
}

void add_bleed(Text& text, const std::optional<BleedCounts>& bleed) {
  if (!bleed) return;
  text.add("bleed      undersides raised by %.3f mm on average, %.3f mm at most: so much deeper their light cures\n",
           bleed->mean_mm, bleed->most_mm);
}

void add_supports(Text& text, const JobReport& report) {
  if (!report.support_settings) return;
  const SupportCounts& s = report.supports;
  text.add("supports   %u below islands, %u below overhangs; %u on the plate, %u on the object, %u on other supports\n",
           s.islands, s.overhangs, s.on_plate, s.on_object, s.on_supports);
  const std::uint32_t blocked = report.support_settings->blocked.count;
  if (s.added + blocked > 0) {
    text.add("           by hand: %u added, no others in %u area%s\n", s.added, blocked, plural_s(blocked));
  }
  if (s.specks > 0) {
    text.add("           left out: %u speck%s that a tip would cover, %.3f mm3 in all\n", s.specks, plural_s(s.specks),
             s.specks_mm3);
  }
  if (s.all() == 0) return;
  text.add(
      "           tips: %u light, %u medium, %u heavy; one carries at most %.1f mm2; %u brace%s, pillars free over "
      "%.1f mm at most\n",
      s.light, s.medium, s.heavy, s.largest_load_mm2, s.braces, plural_s(s.braces), s.longest_free_mm);
}

void add_stage(Text& text, std::string_view name, double seconds, std::size_t peak, std::size_t planned) {
  text.add("  %-11.*s %8.2f s %9.1f MiB", static_cast<int>(name.size()), name.data(), seconds, mib(peak));
  if (planned > 0) text.add(" %9.1f MiB", mib(planned));
  text.add("\n");
}

void add_stages(Text& text, const JobReport& report) {
  text.add("arena      %.1f of %.0f MiB at most; by stage: time, peak, planned\n", mib(report.peak_bytes()),
           mib(report.arena_bytes));
  for (std::size_t i = 0; i < kStageCount; ++i) {
    const auto stage = static_cast<Stage>(i);
    if (report.peak_bytes(stage) == 0) continue;  // a stage that had nothing to do
    add_stage(text, to_string(stage), report.seconds[i], report.peak_bytes(stage), report.slice.planned_bytes[i]);
  }
  if (report.has_preview || report.has_coverage)
    add_stage(text, "preview", report.preview_seconds, report.preview_peak_bytes, 0);
}

}  // namespace

Status write_summary(OutputFile& out, const JobReport& report, const char* output, std::string_view print_time,
                     bool verbose) {
  Text text;
  add_print(text, report, print_time);
  add_look_at(text, report, output);
  if (!verbose) return out.write(text.view());
  add_scan(text, report);
  add_grid(text, report);
  add_clusters(text, report.slice);
  add_rays(text, report);
  add_evidence(text, report);
  add_bleed(text, report.supports.bleed);
  add_supports(text, report);
  PLUMBLINE_TRY(out.write(text.view()));
  text.clear();
  add_stages(text, report);
  text.add("took       %.2f s with %u thread%s\n", report.total_seconds, report.threads, plural_s(report.threads));
  if (!is_sl1_name(output)) text.add("manifest   %s/manifest.json\n", output);
  return out.write(text.view());
}

}  // namespace plumbline::firmware
