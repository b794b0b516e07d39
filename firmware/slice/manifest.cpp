#include "firmware/slice/manifest.hpp"

#include <algorithm>
#include <string_view>

#include "firmware/io/mask_hash.hpp"
#include "firmware/io/version.hpp"
#include "firmware/slice/issue_report.hpp"
#include "firmware/slice/proof_report.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/reader/formats/format_probe.hpp"

namespace plumbline {
namespace {

/// "winding number" as a key: "winding_number".
FixedText<32> as_key(std::string_view name) {
  FixedText<32> key;
  for (const char c : name) key.add("%c", c == ' ' || c == '-' ? '_' : c);
  return key;
}

void write_scan(JsonWriter& json, const JobReport& report) {
  const ScanSummary& scan = report.slice.scan;
  json.key("scan");
  json.begin_object();
  json.member("name", std::string_view(report.scan_name));
  json.member("format", to_string(scan.header.format));
  json.member("encoding", scan.header.encoding);
  json.member("bytes", scan.bytes);
  json.member("points", scan.points);
  json.member("points_not_finite", scan.not_finite);
  json.member("points_left_out", scan.left_out);
  json.member("has_normals", scan.header.has_normals);
  json.member("points_without_normal", scan.header.has_normals ? scan.without_normal : scan.points);
  if (report.scan_names.size() > 1) write_files(json, report.scan_names, report.slice.scans);
  json.end_object();
}

void write_grid(JsonWriter& json, const SliceReport& slice) {
  const Placement& placement = slice.placement;
  const PrintGrid& grid = placement.grid;
  json.key("grid");
  json.begin_object();
  json.member("columns", grid.columns);
  json.member("rows", grid.rows);
  json.member("layers", grid.layers);
  json.key("pixel_pitch_mm");
  json.row(std::array{grid.pitch_x_mm, grid.pitch_y_mm});
  json.member("layer_height_mm", grid.layer_height_mm);
  json.key("origin_mm");
  json.row(Vec3d(millimetres_per(slice.units) * placement.origin_in_scan()));
  json.end_object();
  json.key("transform");
  json.begin_array();
  const Mat4d transform = placement.transform();
  for (int row = 0; row < 4; ++row) {
    json.row(std::array{transform(row, 0), transform(row, 1), transform(row, 2), transform(row, 3)});
  }
  json.end_array();
  json.key("size_mm");
  json.row(placement.size_mm);
  json.key("size_delivered_mm");
  json.row(slice.printed_mm);
}

void write_points(JsonWriter& json, const SliceReport& slice) {
  json.key("thinning");
  json.begin_object(kOneLine);
  json.member("cell_mm", slice.lengths.thinning_cell.value);
  json.member("averaged_points", slice.averaged_points);
  json.member("points_left", slice.cloud_points);
  json.member("room_for_points", slice.cloud_capacity);
  json.end_object();
  json.key("averaging");
  json.begin_object(kOneLine);
  json.member("times", slice.averagings);
  json.member("noise_mm", slice.lengths.averaged_noise.value);
  json.end_object();
  json.member("normals_estimated", slice.normals.estimated);
  json.member("normals_turned", slice.normals.turned);
  json.member("normals_inside_out", slice.normals.inside_out);
  json.member("normals_contradictory", slice.normals.contradictory);
  json.key("views");
  json.begin_object(kOneLine);
  json.member("stated", slice.stated_views.count);
  json.member("scanners_known", slice.stated_views.scanners);
  json.member("moved_mm", slice.lengths.views_moved.value);
  json.member("off_surface_before_mm", slice.lengths.views_before.value);
  json.member("off_surface_after_mm", slice.lengths.views_after.value);
  json.end_object();
  json.key("points");
  json.begin_object(kOneLine);
  const auto& points = slice.clustering.points;
  json.member("entering", points[PointClass::kEntering]);
  json.member("exiting", points[PointClass::kExiting]);
  json.member("neutral", points[PointClass::kNeutral]);
  json.member("noise", points[PointClass::kNoise]);
  json.end_object();
  json.member("core_points", slice.clustering.core_points);
  json.member("epsilon_mm", slice.lengths.epsilon.value);
  json.member("noise_mm", slice.lengths.noise.value);
  json.member("width_mm", slice.width_mm);
}

void write_rays(JsonWriter& json, const SliceReport& slice) {
  json.key("rays");
  json.begin_object();
  json.member("interested", slice.rays.interested());
  for (std::size_t i = 0; i < kRayDecisionCount; ++i) {
    json.member(as_key(to_string(static_cast<RayDecision>(i))).view(), slice.rays.decided[i]);
  }
  json.member("guided", slice.rays.guided);
  json.member("interpolated", slice.rays.interpolated);
  json.member("thinned_tiles", slice.rays.thinned_tiles);
  json.end_object();
  json.member("crossings", slice.crossings);
  const ComponentCounts& components = slice.components;
  json.key("components");
  json.begin_object(kOneLine);
  json.member("counted", components.counted);
  json.member("solids", components.solids);
  json.member("cavities", components.cavities);
  json.member("small_solids_removed", components.dropped_solids - components.floating_solids);
  json.member("floating_solids_removed", components.floating_solids);
  json.member("small_cavities_filled", components.filled_cavities - components.sealed_cavities);
  json.member("sealed_cavities_filled", components.sealed_cavities);
  json.member("voxels_changed", components.changed_voxels);
  json.end_object();
  write_strays(json, slice.strays);
  write_position(json, slice);
  const FeatureCounts& features = slice.features;
  json.key("small_features");
  json.begin_object(kOneLine);
  json.member("counted", features.counted);
  json.member("islands_removed", features.islands);
  json.member("holes_filled", features.holes);
  json.member("voxels", features.voxels);
  json.end_object();
}

template <class Values>
void write_by_evidence(JsonWriter& json, std::string_view name, const Values& values) {
  json.key(name);
  json.begin_object(kOneLine);
  for (std::size_t e = 0; e < kEvidenceCount; ++e) {
    json.member(as_key(to_string(static_cast<Evidence>(e))).view(), values[e]);
  }
  json.end_object();
}

/// @param layers  empty: the manifest is written without them
void write_evidence(JsonWriter& json, const std::optional<ConfidenceShares>& shares,
                    std::span<const ConfidenceMap::Counts> layers) {
  json.key("evidence");
  if (!shares) {
    json.null();
    return;
  }
  json.begin_object();
  write_by_evidence(json, "surface", shares->surface);
  write_by_evidence(json, "crossings", shares->crossings);
  if (!layers.empty()) {
    json.key("layers");
    json.begin_array();
    for (const ConfidenceMap::Counts& layer : layers) json.row(layer);
    json.end_array();
  }
  json.end_object();
}

void write_supports(JsonWriter& json, const JobReport& report) {
  json.key("supports");
  if (!report.support_settings) {
    json.null();
    return;
  }
  const SupportCounts& s = report.supports;
  json.begin_object();
  json.member("count", s.all());
  json.member("below_islands", s.islands);
  json.member("below_overhangs", s.overhangs);
  json.member("on_plate", s.on_plate);
  json.member("on_object", s.on_object);
  json.member("on_supports", s.on_supports);
  json.member("light", s.light);
  json.member("medium", s.medium);
  json.member("heavy", s.heavy);
  json.member("close_to_walls", s.close);
  json.member("braces", s.braces);
  json.member("helper_pillars", s.helpers);
  json.member("pads", s.pads);
  json.member("specks_left_out", s.specks);
  json.member("specks_mm3", s.specks_mm3);
  json.member("unbraced_pillars", s.unbraced);
  json.member("longest_free_mm", s.longest_free_mm);
  json.member("largest_load_mm2", s.largest_load_mm2);
  json.member("lifted_layers", s.lifted);
  json.member("sunk_layers", s.sunk);
  json.member("volume_mm3", report.support_volume_mm3());
  json.key("settings");
  json.begin_object();
  for (const SupportField& field : kSupportFields) json.member(field.key, (*report.support_settings).*field.member);
  json.end_object();
  json.end_object();
}

void write_stages(JsonWriter& json, const JobReport& report) {
  json.key("stages");
  json.begin_array();
  const auto write_stage = [&](std::string_view name, double seconds, std::uint64_t planned, std::uint64_t peak) {
    json.begin_object(kOneLine);
    json.member("name", name);
    json.member("seconds", seconds);
    json.member("planned_bytes", planned);
    json.member("peak_bytes", peak);
    json.end_object();
  };
  for (std::size_t i = 0; i < kStageCount; ++i) {
    const auto stage = static_cast<Stage>(i);
    write_stage(to_string(stage), report.seconds[i], report.slice.planned_bytes[i], report.peak_bytes(stage));
  }
  if (report.has_preview || report.has_coverage)
    write_stage("preview", report.preview_seconds, 0, report.preview_peak_bytes);
  json.end_array();
  json.member("seconds", report.total_seconds);
  json.key("arena");
  json.begin_object(kOneLine);
  json.member("bytes", report.arena_bytes);
  json.member("peak_bytes", report.peak_bytes());
  json.end_object();
  json.member("threads", report.threads);
}

void write_hashes(JsonWriter& json, const JobReport& report, std::span<const std::uint64_t> layer_hashes) {
  json.key("hashes");
  json.begin_object();
  json.member("definition", kMaskHashDefinition);
  json.key("job");
  json.hex(report.hash);
  if (!layer_hashes.empty()) {
    json.key("layers");
    json.begin_array();
    for (const std::uint64_t hash : layer_hashes) json.hex(hash);
    json.end_array();
  }
  json.end_object();
}

}  // namespace

void write_mesh(JsonWriter& json, const std::optional<MeshCounts>& mesh) {
  json.key("mesh");
  if (!mesh) return json.null();
  json.begin_object();
  json.member("faces", mesh->faces);
  json.member("triangles", mesh->triangles);
  json.member("triangles_not_finite", mesh->not_finite);
  json.member("triangles_flat", mesh->flat);
  json.member("vertices", mesh->vertices);
  json.member("closed", mesh->closed);
  json.member("volumes_cut_out", mesh->project.negative);
  json.member("volumes_left_out", mesh->project.ignored);
  json.member("triangles_turned", mesh->turned);
  json.member("triangles_doubled", mesh->dropped);
  json.member("small_holes_closed", mesh->closed_holes);
  json.member("hits", mesh->hits);
  json.member("rays", mesh->rays);
  json.member("rays_broken", mesh->broken_rays);
  json.member("rays_decided_by_winding_number", mesh->decided_rays);
  json.member("rays_asked_for_winding_number", mesh->asked_rays);
  json.member("rays_crowded", mesh->crowded_rays);
  json.end_object();
}

void write_position(JsonWriter& json, const PreparationReport& found) {
  json.key("floor");
  json.begin_object(kOneLine);
  json.member("points", found.floor.points);
  json.member("height_scan_units", found.floor.height);
  json.member("tilt", found.floor.tilt);
  json.key("size_scan_units");
  json.row(found.floor.size);
  json.end_object();
  json.member("outliers", found.outliers);
  json.member("evened_points", found.evened_points);
  json.member("flying_points", found.flying_points);
  json.key("orientation");
  json.begin_object(kOneLine);
  const auto degrees = [&](const char* key, const std::optional<Orientation>& orientation) {
    json.key(key);
    if (!orientation) return json.null();
    json.begin_array(kOneLine);
    for (const double angle : orientation->degrees) json.value(angle);
    json.end_array();
  };
  degrees("turned_deg", found.turned);
  degrees("upright_deg", found.upright);
  json.end_object();
}

void write_strays(JsonWriter& json, const StrayPieces& strays) {
  json.key("stray_pieces");
  json.begin_object(kOneLine);
  json.member("pieces", strays.pieces);
  json.member("points", strays.points);
  json.member("share", strays.share);
  json.end_object();
}

void write_files(JsonWriter& json, std::span<const std::string> names, const ScanSummaries& scans) {
  json.key("files");
  json.begin_array();
  for (std::size_t i = 0; i < std::min(names.size(), scans.count); ++i) {
    const ScanSummary& scan = scans.each[i];
    json.begin_object(kOneLine);
    json.member("name", std::string_view(names[i]));
    json.member("format", to_string(scan.header.format));
    json.member("encoding", scan.header.encoding);
    json.member("bytes", scan.bytes);
    json.member("points", scan.points);
    json.member("has_normals", scan.header.has_normals);
    json.end_object();
  }
  json.end_array();
}

void write_manifest(JsonWriter& json, const JobReport& report, std::span<const std::uint64_t> layer_hashes) {
  const SliceReport& slice = report.slice;
  json.begin_object();
  // JobDirectory recognises a manifest of plumbline by this first key.
  json.key("plumbline");
  json.begin_object(kOneLine);
  json.member("version", kVersion);
  json.member("manifest_format", kManifestFormat);
  json.end_object();
  write_scan(json, report);
  write_mesh(json, slice.mesh);
  json.key("printer");
  if (report.printer_name.empty()) {
    json.null();
  } else {
    json.value(std::string_view(report.printer_name));
  }
  json.key("units");
  json.begin_object(kOneLine);
  json.member("used", to_string(slice.units));
  json.member("guessed", slice.units_guessed);
  json.end_object();
  json.member("scale_mm_per_unit", slice.placement.scale);
  write_grid(json, slice);
  json.key("underside");
  json.begin_object(kOneLine);
  json.member("base", to_string(report.base));
  json.member("on_base_plane", slice.flat_underside);
  json.end_object();
  write_points(json, slice);
  write_rays(json, slice);
  write_evidence(json, report.coverage,
                 layer_hashes.empty() ? std::span<const ConfidenceMap::Counts>{} : slice.confidence.layers());
  write_proof(json, slice.proof);
  json.member("volume_mm3", report.volume_mm3());
  write_supports(json, report);
  if (report.findings) {
    write_issues(json, *report.findings, slice.placement.grid, report.checks);
  } else {
    json.key("issues");
    json.null();
  }
  write_stages(json, report);
  json.key("warnings");
  json.begin_array();
  for (const auto& line : report.warnings.all()) json.value(line.view());
  json.end_array();
  write_hashes(json, report, layer_hashes);
  json.end_object();
}

}  // namespace plumbline
