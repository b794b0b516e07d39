#include "firmware/slice/job_report.hpp"

#include <algorithm>

#include "firmware/io/progress_lines.hpp"
#include "firmware/messages/printer_code.hpp"
#include "firmware/messages/told_text.hpp"
#include "firmware/slice/issue_report.hpp"
#include "firmware/slice/proof_report.hpp"
#include "slicer/core/words/plural.hpp"

namespace plumbline::firmware {
namespace {

constexpr double kSmallestUsual = 5;   ///< mm, longest side; smaller and larger prints are rare, and wrong units common
constexpr double kLargestUsual = 500;  ///< mm
constexpr double kThinnest = 2;        ///< pixels or layers; opening removes what is thinner
constexpr double kFewTurned = 1;       ///< % of the normals; if fewer were flipped, there is no warning

double voxel_mm3(const PrintGrid& grid) {
  return static_cast<double>(grid.pitch_x_mm) * static_cast<double>(grid.pitch_y_mm) *
         static_cast<double>(grid.layer_height_mm);
}

/// Remarks on what a wrong unit causes, and on the points that did not fit.
void for_each_size_remark(const SliceReport& slice, RemarkVisit visit) {
  const PrintGrid& grid = slice.placement.grid;
  const Vec3d& size = slice.placement.size_mm;
  const double longest = size.maxCoeff();
  Sentence text;
  if (slice.ignored_units) {
    visit({PrinterCode::kUnitsIgnored, {}, to_string(*slice.ignored_units)},
          ignored_units_warning(*slice.ignored_units).view());
  }
  if (slice.units_guessed) {
    text.add("the scan is %.4g units long and says no unit; %s, which make it %.4g mm, are a guess",
             longest / slice.placement.scale, to_string(slice.units), longest);
    visit({PrinterCode::kUnitsGuessed, {{Fact::kLongestMm, longest}}, to_string(slice.units)}, text.view());
  }
  text = {};
  const char* const unit_option = slice.scan.header.is_in_mm ? "" : "units";
  if (longest < kSmallestUsual) {
    text.add("the object is only %.3g mm long", longest);
    visit({PrinterCode::kObjectSmall, {{Fact::kLongestMm, longest}}, unit_option}, text.view());
  } else if (longest > kLargestUsual) {
    text.add("the object is %.4g mm long", longest);
    visit({PrinterCode::kObjectLarge, {{Fact::kLongestMm, longest}}, unit_option}, text.view());
  }
  const auto pitch = static_cast<double>(std::min(grid.pitch_x_mm, grid.pitch_y_mm));
  const Vec3d thinnest = kThinnest * Vec3d(pitch, pitch, static_cast<double>(grid.layer_height_mm));
  if ((size.array() < thinnest.array()).any()) {
    text = {};
    text.add(
        "the scan is %.3g x %.3g x %.3g mm: along one axis it is thinner than %.0f pixels or layers, and little of it "
        "may print. Look at the layers",
        size[0], size[1], size[2], kThinnest);
    visit(
        {PrinterCode::kObjectThin, {{Fact::kWidthMm, size[0]}, {Fact::kDepthMm, size[1]}, {Fact::kHeightMm, size[2]}}},
        text.view());
  }
  const auto cell_mm = static_cast<double>(slice.lengths.thinning_cell.value);
  if (cell_mm > pitch) {
    text = {};
    text.add(
        "the scan has more points than memory holds (%u): they were averaged in cells of %.3g mm, coarser than the "
        "pixels of %.3g mm. A larger arena keeps more detail",
        slice.cloud_capacity, cell_mm, pitch);
    visit({PrinterCode::kPointsAveraged, {{Fact::kCellMm, cell_mm}, {Fact::kPixelMm, pitch}}}, text.view());
  }
}

/// Remarks on a print that is not as large as somebody has asked for.
void remark_on_asked_size(const SliceReport& slice, RemarkVisit visit) {
  if (!slice.asked_size || slice.turned_since) return;
  const auto [side, asked] = *slice.asked_size;
  const PrintGrid& grid = slice.placement.grid;
  const Vec3d step(static_cast<double>(grid.pitch_x_mm), static_cast<double>(grid.pitch_y_mm),
                   static_cast<double>(grid.layer_height_mm));
  Eigen::Index axis = static_cast<Eigen::Index>(side);
  if (side == Side::kLength) slice.printed_mm.maxCoeff(&axis);
  const double printed = slice.printed_mm[axis];
  // Masks are whole pixels and layers.
  if (std::abs(printed - asked) < 1.01 * step[axis]) return;
  const bool sunk =
      axis == 2 && slice.sunk_layers > 0 && std::abs(printed + slice.sunk_layers * step[2] - asked) < 1.01 * step[2];
  Sentence text;
  text.add("the object is %.2f mm %s, not %.4g: %s. If that matters, ask for %.4g mm", printed,
           side == Side::kWidth    ? "wide"
           : side == Side::kDepth  ? "deep"
           : side == Side::kHeight ? "high"
                                   : "long",
           asked,
           sunk         ? "so much was cut off its underside that it stands flat"
           : slice.mesh ? "what reaches beyond that is too thin to print"
                        : "what reaches beyond that is the scan's noise, or too thin to print",
           asked * asked / std::max(printed, step[axis]));
  visit({sunk ? PrinterCode::kSizeSunk : PrinterCode::kSizeOff,
         {{PrinterFact::kAskedMm, asked}, {PrinterFact::kDeliveredMm, printed}}},
        text.view());
}

}  // namespace

double JobReport::volume_mm3() const { return static_cast<double>(cured_pixels) * voxel_mm3(slice.placement.grid); }

double JobReport::support_volume_mm3() const {
  return static_cast<double>(support_pixels) * voxel_mm3(slice.placement.grid);
}

std::size_t JobReport::peak_bytes(Stage stage) const {
  return stage == Stage::kLayers ? layers_peak_bytes : slice.peak_bytes[static_cast<std::size_t>(stage)];
}

std::size_t JobReport::peak_bytes() const {
  return std::max(
      {*std::max_element(slice.peak_bytes.begin(), slice.peak_bytes.end()), layers_peak_bytes, preview_peak_bytes});
}

double JobReport::share_of_rays(RayDecision decision) const {
  const auto shot = static_cast<double>(slice.rays.interested());
  return shot > 0 ? static_cast<double>(slice.rays.decided[static_cast<std::size_t>(decision)]) / shot : 0;
}

void for_each_dropped(const ScanSummary& scan, FunctionRef<void(const char*)> say) {
  const bool splats = scan.header.format == ScanFormat::kPly || scan.header.format == ScanFormat::kSpz;
  const auto dropped = [&](std::uint64_t points, const char* why) {
    FixedText<128> text;
    text.add("%llu point%s dropped: %s", big(points), plural_s(points), why);
    if (points > 0) say(text.c_str());
  };
  dropped(scan.not_finite, "not finite");
  dropped(scan.left_out,
          splats ? "splats that hardly show, or far larger than the others" : "the file marks them as invalid");
}

FixedText<128> unseen_sentence(const Unseen& unseen) {
  FixedText<128> text;
  if (unseen.is_negligible()) return text;
  const bool underside = unseen.underside > Unseen::kNegligible;
  const bool elsewhere = unseen.elsewhere > Unseen::kNegligible;
  if (underside) text.add("the underside (%.1f %% of the surface)", 100 * unseen.underside);
  if (underside && elsewhere) {
    text.add(" and %.1f %% elsewhere were not scanned", 100 * unseen.elsewhere);
  } else if (underside) {
    text.add(" was not scanned");
  } else {
    text.add("%.1f %% of the surface was not scanned", 100 * unseen.elsewhere);
  }
  return text;
}

FixedText<96> scanned_text(const Unseen& unseen) {
  FixedText<96> text;
  text.add("%.1f %% of the surface; closed: underside %.1f %%, elsewhere %.1f %%",
           100 * (1 - unseen.underside - unseen.elsewhere), 100 * unseen.underside, 100 * unseen.elsewhere);
  return text;
}

FixedText<96> size_text(const Placement& placement) {
  FixedText<96> text;
  const Vec3d& size = placement.size_mm;
  text.add("%.2f x %.2f x %.2f mm, %u layer%s of %.4g mm", size[0], size[1], size[2], placement.grid.layers,
           plural_s(placement.grid.layers), static_cast<double>(placement.grid.layer_height_mm));
  return text;
}

FixedText<160> stand_text(const SupportSettings& settings, const SupportCounts& counts, double layer_height_mm) {
  FixedText<160> text;
  const bool raised = counts.lifted > 0;
  if (raised) {
    text.add("%.4g mm above the plate, %s a raft", counts.lifted * layer_height_mm,
             settings.pad_wall_thickness > 0 ? "on" : "without");
  } else {
    text.add("on the plate");
  }
  if (settings.stand != SupportStand::kAuto || !(lift_mm(settings) > 0)) {
    text.add(", as asked%s", counts.flat == false ? "; its underside is not flat" : "");
  } else if (raised) {
    text.add(", since its underside is not flat; --support-stand plate puts it down");
  } else {
    text.add(", since its underside is flat; --support-stand raised lifts it by %.4g mm", lift_mm(settings));
  }
  return text;
}

Sentence ignored_units_warning(Units units) {
  Sentence text;
  text.add("the unit %s was ignored: the file says its own (E57 in metres, 3MF and tables any)", to_string(units));
  return text;
}

namespace {

/// Normals that were flipped; nothing if they are few, as those of flying pixels at edges.
void remark_on_normals(const PreparationReport& scan, RemarkVisit visit) {
  const double percent = 100.0 * scan.normals.turned / std::max(1U, scan.cloud_points);
  Sentence text;
  if (scan.normals.contradictory) {
    text.add(
        "the scan's normals face into the object and out of it at random; %.0f %% were flipped. Check in the preview "
        "that its solid parts are solid, or scan again",
        percent);
    visit({PrinterCode::kNormalsAtRandom, {{Fact::kPercent, percent}}}, text.view());
  } else if (scan.normals.inside_out) {
    text.add("the scan is inside out: %.0f %% of its normals pointed into the object and were flipped", percent);
    visit({PrinterCode::kInsideOut, {{Fact::kPercent, percent}}}, text.view());
  } else if (percent > kFewTurned) {
    text.add("%.2g %% of the normals pointed into the object and were flipped", percent);
    visit({PrinterCode::kNormalsFlipped, {{Fact::kPercent, percent}}}, text.view());
  }
}

/// Places that shall get a support, but have no surface.
void remark_on_missed_supports(const SupportPlaces& missed, RemarkVisit visit) {
  if (missed.count == 0) return;
  const SupportPlace& first = missed.list[0];
  Sentence text;
  if (missed.count > 1) text.add("%u places to support have no surface, the first: ", missed.count);
  text.add(
      "no surface within %g mm of x %.1f, y %.1f, z %.2f mm to support. Take the place from a finding, in which z is "
      "that of the layer where the object begins, or leave it out",
      kPlaceReach, first.x, first.y, first.z);
  visit({PrinterCode::kSupportMissed,
         {{Fact::kCount, missed.count}, {Fact::kXMm, first.x}, {Fact::kYMm, first.y}, {Fact::kFromMm, first.z}}},
        text.view());
}

/// What a slicer's project holds that is not used.
void remark_on_project(const UnusedSettings& project, RemarkVisit visit) {
  Sentence text;
  if (project.ignored > 0) {
    text.add(
        "%u %s of the project %s left out, since %s no part of the object: modifiers, support enforcers or blockers",
        project.ignored, project.ignored == 1 ? "volume" : "volumes", project.ignored == 1 ? "was" : "were",
        project.ignored == 1 ? "it is" : "they are");
    visit({PrinterCode::kVolumesLeftOut, {{Fact::kCount, project.ignored}}}, text.view());
  }
  const auto say = [&](bool found, PrinterCode code, std::string_view sentence) {
    if (found) visit({code, {}}, sentence);
  };
  say(project.hollowing, PrinterCode::kHollowingUnused,
      "the project says that the object is hollow: it is printed solid. Export the hollow object as STL or 3MF");
  say(project.drain_holes, PrinterCode::kDrainHolesUnused,
      "the project has drain holes, which are not printed. Export the object with its holes as STL or 3MF");
  say(project.support_points, PrinterCode::kSupportPointsUnused,
      "the project has support points, which are not used: supports are found anew");
  say(project.correction, PrinterCode::kCorrectionUnused,
      "the project corrects scale or XY size, which is not used. Set it for this printer");
}

/// What was left out of a mesh, and how its holes were closed.
void for_each_mesh_remark(const MeshCounts& mesh, RemarkVisit visit) {
  Sentence text;
  if (mesh.not_finite > 0) {
    text.add("%llu of the mesh's %llu triangles %s left out: a coordinate is not finite, or huge", big(mesh.not_finite),
             big(mesh.not_finite + mesh.triangles), mesh.not_finite == 1 ? "was" : "were");
    visit({PrinterCode::kTrianglesLeftOut,
           {{Fact::kCount, mesh.not_finite}, {Fact::kOf, mesh.not_finite + mesh.triangles}}},
          text.view());
  }
  remark_on_project(mesh.project, visit);
  if (mesh.turned > 0) {
    text = {};
    text.add("%llu of the mesh's %llu triangles faced inwards and %s turned over. Look at the preview",
             big(mesh.turned), big(mesh.triangles), mesh.turned == 1 ? "was" : "were");
    visit({PrinterCode::kFacesTurned, {{Fact::kCount, mesh.turned}, {Fact::kOf, mesh.triangles}}}, text.view());
  }
  if (mesh.dropped > 0) {
    text = {};
    text.add("%llu of the mesh's %llu triangles %s there more than once and %s left out. Look at the preview",
             big(mesh.dropped), big(mesh.triangles), mesh.dropped == 1 ? "was" : "were",
             mesh.dropped == 1 ? "was" : "were");
    visit({PrinterCode::kFacesDoubled, {{Fact::kCount, mesh.dropped}, {Fact::kOf, mesh.triangles}}}, text.view());
  }
  if (mesh.closed_holes > 0) {
    text = {};
    text.add(
        "the mesh had %llu small %s (faces that are missing, flipped or doubled), which %s closed. "
        "Look at the preview",
        big(mesh.closed_holes), mesh.closed_holes == 1 ? "gap" : "gaps", mesh.closed_holes == 1 ? "was" : "were");
    visit({PrinterCode::kSmallHolesClosed, {{Fact::kCount, mesh.closed_holes}}}, text.view());
  }
  if (!mesh.closed && (mesh.closed_holes == 0 || mesh.decided_rays > 0)) {
    text = {};
    const std::uint64_t rays = std::max(mesh.rays, mesh.decided_rays);
    text.add(
        "the mesh is not closed (it has holes): %llu of %llu rays %s decided by its winding number. Look at the "
        "preview",
        big(mesh.decided_rays), big(rays), mesh.decided_rays == 1 ? "was" : "were");
    visit({PrinterCode::kMeshOpen, {{Fact::kCount, mesh.decided_rays}, {Fact::kOf, rays}}}, text.view());
  }
  if (mesh.crowded_rays > 0) {
    text = {};
    text.add("%llu ray%s more than 254 crossings, of which the upper ones were left out", big(mesh.crowded_rays),
             mesh.crowded_rays == 1 ? " has" : "s have");
    visit({PrinterCode::kRaysCrowded, {{Fact::kCount, mesh.crowded_rays}}}, text.view());
  }
}

/// Says how much of the scan or of the print is left out as noise, if it is much.
void remark_on_losses(const SliceReport& slice, RemarkVisit visit) {
  constexpr double kMuch = 0.02;          // small solids over what stays: dirty scans have .001
  constexpr double kManyOutliers = 0.25;  // of all points: dirty scans have .03
  Sentence text;
  const ComponentCounts& c = slice.components;
  const auto removed = static_cast<double>(c.dropped_voxels);
  if (removed > kMuch * static_cast<double>(c.voxels)) {
    const PrintGrid& grid = slice.placement.grid;
    const double voxel_ml = static_cast<double>(grid.pitch_x_mm) * static_cast<double>(grid.pitch_y_mm) *
                            static_cast<double>(grid.layer_height_mm) / 1000;
    const double share = 100 * removed / static_cast<double>(std::max<std::uint64_t>(c.voxels, 1));
    text.add(
        "small solids were removed (%u, %.3g ml, %.2g %% of what stays) that may be parts of the object, such as thin "
        "walls. Look at the preview; scan more densely, or print it larger",
        c.dropped_solids, removed * voxel_ml, share);
    visit({PrinterCode::kMuchRemoved, {{Fact::kPercent, share}}}, text.view());
  }
  // A floor that was cut off has its own remark.
  const std::uint32_t noise = slice.clustering.points[PointClass::kNoise] -
                              std::min(slice.clustering.points[PointClass::kNoise], slice.floor.points);
  const double all = static_cast<double>(noise) + slice.clustering.points.surface();
  if (noise > kManyOutliers * all) {
    text = {};
    text.add("%.0f %% of the points lie on no surface and were left out. Look at the preview, or scan again",
             100 * noise / all);
    visit({PrinterCode::kManyOutliers, {{Fact::kPercent, 100 * noise / all}}}, text.view());
  }
}

}  // namespace

FixedText<128> mesh_text(const MeshCounts& mesh) {
  FixedText<128> text;
  text.add("%llu triangle%s, %s", big(mesh.triangles), plural_s(mesh.triangles), mesh.closed ? "closed" : "not closed");
  return text;
}

FixedText<96> classes_text(const ClassCounts& points) {
  FixedText<96> text;
  for (std::size_t i = 0; i < kPointClassCount; ++i) {
    const auto which = static_cast<PointClass>(i);
    text.add("%s%s %.*f %%", i == 0 ? "" : ", ", to_string(which).data(), which == PointClass::kNoise ? 2 : 1,
             100.0 * points[which] / std::max(1U, points.all()));
  }
  return text;
}

void for_each_scan_remark(const PreparationReport& scan, double noise_mm, double mm_per_unit, RemarkVisit visit) {
  Sentence text;
  if (scan.averagings > 0) {
    text.add(
        "the points are too noisy to show a surface (about %.2g mm), so neighbours were averaged, %u time%s: "
        "finer details are lost. Check the preview, or scan with less noise",
        noise_mm, scan.averagings, plural_s(scan.averagings));
    visit({PrinterCode::kNoiseAveraged, {{Fact::kNoiseMm, noise_mm}, {Fact::kCount, scan.averagings}}}, text.view());
  }
  if (const FloorCut& floor = scan.floor; floor.points > 0) {
    constexpr float kLevel = 0.001F;
    const Vec3d mm = floor.size * mm_per_unit;
    text = {};
    text.add("a floor of %.1f x %.1f x %.1f mm was cut off, at height %.5g of the scan", mm[0], mm[1], mm[2],
             floor.height);
    if (floor.tilt > kLevel) text.add(", which was levelled by %.2g in 100", 100 * static_cast<double>(floor.tilt));
    visit({PrinterCode::kFloorCut,
           {{Fact::kWidthMm, mm[0]},
            {Fact::kDepthMm, mm[1]},
            {Fact::kHeightMm, mm[2]},
            {Fact::kPoints, floor.points},
            {Fact::kFloor, floor.height}}},
          text.view());
  }
  if (const StrayPieces& strays = scan.strays; strays.pieces > 0) {
    const double percent = 100 * double{strays.share};
    text = {};
    text.add("%u stray piece%s left out: %u point%s apart from the object, %.2g %% of the scan's surface",
             strays.pieces, strays.pieces == 1 ? " was" : "s were", strays.points, plural_s(strays.points), percent);
    visit({PrinterCode::kPiecesLeftOut,
           {{Fact::kCount, strays.pieces}, {Fact::kPoints, strays.points}, {Fact::kPercent, percent}}},
          text.view());
  }
  remark_on_normals(scan, visit);
}

void remark_on_orientation(const PreparationReport& scan, RemarkVisit visit) {
  const ClassCounts& points = scan.clustering.points;
  if (points.is_negligible(PointClass::kExiting) && !points.is_negligible(PointClass::kEntering)) {
    visit(PrinterCode::kOnItsFace, "the scan shows one side only, which faces down, so most of it can't be closed");
  } else if (scan.upright) {
    const auto [x, y] = scan.upright->degrees;
    Told told(PrinterCode::kLiesWrong);
    if (x != 0) told.add(Fact::kTurnXDeg, x);
    if (y != 0) told.add(Fact::kTurnYDeg, y);
    visit(told, "the scan seems to lie on its side or its head");
  }
}

void for_each_remark(const SliceReport& slice, RemarkVisit visit) {
  remark_on_missed_supports(slice.missed_supports, visit);
  for_each_size_remark(slice, visit);
  remark_on_asked_size(slice, visit);
  if (slice.mesh) return for_each_mesh_remark(*slice.mesh, visit);
  for_each_scan_remark(slice, static_cast<double>(slice.lengths.averaged_noise.value), slice.placement.scale, visit);
  Sentence text;
  if (slice.components.floating_solids > 0) {
    text = {};
    const bool one = slice.components.floating_solids == 1;
    text.add("%u small solid%s neither the object nor the plate %s left out", slice.components.floating_solids,
             one ? " that touches" : "s that touch", one ? "was" : "were");
    visit({PrinterCode::kSolidsLeftOut, {{Fact::kCount, slice.components.floating_solids}}}, text.view());
  }
  remark_on_losses(slice, visit);
  if (slice.components.sealed_cavities > 0) {
    text = {};
    const bool one = slice.components.sealed_cavities == 1;
    text.add("%u small enclosed cavit%s, which no scanner can have seen, %s filled", slice.components.sealed_cavities,
             one ? "y" : "ies", one ? "was" : "were");
    visit({PrinterCode::kCavitiesFilled, {{Fact::kCount, slice.components.sealed_cavities}}}, text.view());
  }
  if (slice.crossings > 0 && !(slice.components.counted && slice.features.counted)) {
    visit(PrinterCode::kSmallPartsStay,
          "the arena had no room to look for small parts: loose solids, enclosed cavities, islands and holes that the "
          "scan "
          "does not resolve stay");
  }
  remark_on_orientation(slice, visit);
  if (slice.normals.estimated > 0 && slice.averagings == 0) {
    text = {};
    text.add("%u point%s of the scan %s no usable normal, which was estimated from neighbouring points",
             slice.normals.estimated, plural_s(slice.normals.estimated), slice.normals.estimated == 1 ? "has" : "have");
    visit({PrinterCode::kNormalsEstimated, {{Fact::kPoints, slice.normals.estimated}}}, text.view());
  }
}

void find_warnings(JobReport& report) {
  const SliceReport& s = report.slice;
  for_each_remark(s, [&](const Told& told, std::string_view warning) {
    report.warnings.add().add("%s", at_terminal(told, warning).c_str());
  });
  if (s.proof.is_doubtful()) report.warnings.add().add("%s", points_off_warning(s.proof).c_str());
  if (report.coverage) {
    const auto unseen = unseen_sentence(Unseen::of(*report.coverage));
    if (!unseen.view().empty()) {
      report.warnings.add().add(
          "%s and had to be closed: %s", unseen.c_str(),
          report.draws_coverage ? "look at coverage.png" : "'plumbline inspect' draws where, with --picture");
    }
  }
  if (!report.findings) return;
  for_each_issue(*report.findings, s.placement.grid, report.checks,
                 [&](IssueKind, CheckAction, std::string_view sentence) {
                   report.warnings.add().add("%.*s", static_cast<int>(sentence.size()), sentence.data());
                 });
  if (report.findings->unchecked_layers > 0) {
    report.warnings.add().add("%u layer%s too fine to check", report.findings->unchecked_layers,
                              report.findings->unchecked_layers == 1 ? " is" : "s are");
  }
}

}  // namespace plumbline::firmware
