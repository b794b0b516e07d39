#include "firmware/slice/manifest.hpp"

#include <algorithm>
#include <string_view>

#include "firmware/io/mask_hash.hpp"
#include "firmware/io/version.hpp"
#include "firmware/settings/support_choice.hpp"
#include "firmware/slice/issue_report.hpp"
#include "firmware/slice/proof_report.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/reader/formats/format_probe.hpp"

namespace plumbline::firmware {
namespace {

void write_scan(JsonWriter& json, const JobReport& report) {
  const ScanSummary& scan = report.slice.scan;
  json.begin_object("scan");
  json.member("name", report.scan_name);
  write_fields(json, kScanFields, scan);
  json.member("has_normals", scan.header.has_normals);
  json.member("points_without_normal", scan.header.has_normals ? scan.without_normal : scan.points);
  write_files(json, report.scan_names, report.slice.scans);
  json.end_object();
}

void write_grid(JsonWriter& json, const SliceReport& slice) {
  const Placement& placement = slice.placement;
  json.begin_object("grid");
  write_fields(json, kGridFields, placement.grid);
  json.member("origin_mm", Vec3d(millimetres_per(slice.units) * placement.origin_in_scan()));
  json.end_object();
  json.begin_array("transform");
  const Mat4d transform = placement.transform();
  for (int row = 0; row < 4; ++row) {
    json.value(std::array{transform(row, 0), transform(row, 1), transform(row, 2), transform(row, 3)});
  }
  json.end_array();
  json.member("size_mm", placement.size_mm);
  json.member("size_delivered_mm", slice.printed_mm);
}

void write_points(JsonWriter& json, const SliceReport& slice) {
  json.begin_object("thinning", kOneLine);
  json.member("cell_mm", slice.lengths.thinning_cell.value);
  json.member("averaged_points", slice.averaged_points);
  json.member("points_left", slice.cloud_points);
  json.member("room_for_points", slice.cloud_capacity);
  json.end_object();
  json.begin_object("averaging", kOneLine);
  json.member("times", slice.averagings);
  json.member("noise_mm", slice.lengths.averaged_noise.value);
  json.end_object();
  write_fields(json, kNormalFields, slice.normals);
  json.begin_object("views", kOneLine);
  json.member("stated", slice.stated_views.count);
  json.member("scanners_known", slice.stated_views.scanners);
  json.member("moved_mm", slice.lengths.views_moved.value);
  json.member("off_surface_before_mm", slice.lengths.views_before.value);
  json.member("off_surface_after_mm", slice.lengths.views_after.value);
  json.end_object();
  json.begin_object("points", kOneLine);
  write_by<PointClass>(json, slice.clustering.points.counts);
  json.end_object();
  json.member("core_points", slice.clustering.core_points);
  json.member("epsilon_mm", slice.lengths.epsilon.value);
  json.member("noise_mm", slice.lengths.noise.value);
  json.member("width_mm", slice.width_mm);
}

void write_rays(JsonWriter& json, const SliceReport& slice) {
  json.begin_object("rays");
  json.member("interested", slice.rays.interested());
  write_by<RayDecision>(json, slice.rays.decided);
  json.member("guided", slice.rays.guided);
  json.member("interpolated", slice.rays.interpolated);
  json.member("thinned_tiles", slice.rays.thinned_tiles);
  json.end_object();
  json.member("crossings", slice.crossings);
  const ComponentCounts& components = slice.components;
  json.begin_object("components", kOneLine);
  json.member("counted", components.counted);
  json.member("solids", components.solids);
  json.member("cavities", components.cavities);
  json.member("small_solids_removed", components.dropped_solids - components.floating_solids);
  json.member("floating_solids_removed", components.floating_solids);
  json.member("small_cavities_filled", components.filled_cavities - components.sealed_cavities);
  json.member("sealed_cavities_filled", components.sealed_cavities);
  json.member("voxels_changed", components.changed_voxels);
  json.end_object();
  write_position(json, slice);
  const FeatureCounts& features = slice.features;
  json.begin_object("small_features", kOneLine);
  json.member("counted", features.counted);
  json.member("islands_removed", features.islands);
  json.member("holes_filled", features.holes);
  json.member("voxels", features.voxels);
  json.end_object();
}

/// @param layers  empty: the manifest is written without them
void write_evidence(JsonWriter& json, const std::optional<ConfidenceShares>& shares,
                    std::span<const ConfidenceMap::Counts> layers) {
  json.key("evidence");
  if (!shares) return json.null();
  json.begin_object();
  json.begin_object("surface", kOneLine);
  write_by<Evidence>(json, shares->surface);
  json.end_object();
  json.begin_object("crossings", kOneLine);
  write_by<Evidence>(json, shares->crossings);
  json.end_object();
  if (!layers.empty()) {
    json.begin_array("layers");
    for (const ConfidenceMap::Counts& layer : layers) json.value(layer);
    json.end_array();
  }
  json.end_object();
}

void write_bleed(JsonWriter& json, const std::optional<BleedCounts>& bleed) {
  json.key("bleed");
  if (!bleed) return json.null();
  json.begin_object(kOneLine);
  json.member("raised_crossings", bleed->moved);
  json.member("mean_mm", bleed->mean_mm);
  json.member("most_mm", bleed->most_mm);
  json.end_object();
}

void write_supports(JsonWriter& json, const JobReport& report) {
  json.key("supports");
  if (!report.support_settings) return json.null();
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
  json.member("unreached", s.unreached());
  json.member("added", s.added);
  json.member("blocked_areas", report.support_settings->blocked.count);
  json.member("braces", s.braces);
  json.member("helper_pillars", s.helpers);
  json.member("pads", s.pads);
  json.member("specks_left_out", s.specks);
  json.member("specks_mm3", s.specks_mm3);
  json.member("unbraced_pillars", s.unbraced);
  json.member("longest_free_mm", s.longest_free_mm);
  json.member("largest_load_mm2", s.largest_load_mm2);
  json.member("raised", s.lifted > 0);
  json.member("flat_underside", s.flat);
  json.member("lifted_layers", s.lifted);
  json.member("sunk_layers", s.sunk);
  json.member("volume_mm3", report.support_volume_mm3());
  json.begin_object("settings");
  json.member("support_stand", kStandWords[static_cast<std::size_t>(report.support_settings->stand)]);
  json.member("support_buildplate_only", report.support_settings->buildplate_only);
  for (const SupportField& field : kSupportFields) json.member(field.key, (*report.support_settings).*field.member);
  for (const PlaceField& field : kPlaceFields) write_places(json, field, (*report.support_settings).*field.member);
  json.end_object();
  json.end_object();
}

void write_stages(JsonWriter& json, const JobReport& report) {
  json.begin_array("stages");
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
  json.begin_object("arena", kOneLine);
  json.member("bytes", report.arena_bytes);
  json.member("peak_bytes", report.peak_bytes());
  json.end_object();
  json.member("threads", report.threads);
}

void write_hashes(JsonWriter& json, const JobReport& report, std::span<const std::uint64_t> layer_hashes) {
  json.begin_object("hashes");
  json.member("definition", kMaskHashDefinition);
  json.key("job");
  json.hex(report.hash);
  if (!layer_hashes.empty()) {
    json.begin_array("layers");
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
  json.begin_object("stray_pieces", kOneLine);
  json.member("pieces", found.strays.pieces);
  json.member("points", found.strays.points);
  json.member("share", found.strays.share);
  json.end_object();
  json.begin_object("floor", kOneLine);
  json.member("points", found.floor.points);
  json.member("height_scan_units", found.floor.height);
  json.member("tilt", found.floor.tilt);
  json.member("size_scan_units", found.floor.size);
  json.end_object();
  json.member("outliers", found.outliers);
  json.member("evened_points", found.evened_points);
  json.member("flying_points", found.flying_points);
  const auto degrees = [](const std::optional<Orientation>& way) {
    return way ? std::optional(way->degrees) : std::nullopt;
  };
  json.begin_object("orientation", kOneLine);
  json.member("turned_deg", degrees(found.turned));
  json.member("upright_deg", degrees(found.upright));
  json.end_object();
}

void write_files(JsonWriter& json, std::span<const std::string> names, const ScanSummaries& scans) {
  if (names.size() < 2) return;
  json.begin_array("files");
  for (std::size_t i = 0; i < std::min(names.size(), scans.count); ++i) {
    json.begin_object(kOneLine);
    json.member("name", names[i]);
    write_fields(json, std::span(kScanFields).first(4), scans.each[i]);
    json.member("has_normals", scans.each[i].header.has_normals);
    json.end_object();
  }
  json.end_array();
}

void write_manifest(JsonWriter& json, const JobReport& report, std::span<const std::uint64_t> layer_hashes) {
  const SliceReport& slice = report.slice;
  json.begin_object();
  // JobDirectory recognises a manifest of plumbline by this first key.
  json.begin_object("plumbline", kOneLine);
  json.member("version", kVersion);
  json.member("manifest_format", kManifestFormat);
  json.end_object();
  write_scan(json, report);
  write_mesh(json, slice.mesh);
  const std::string_view printer = report.printer_name;
  json.member("printer", printer.empty() ? std::nullopt : std::optional(printer));
  json.begin_object("units", kOneLine);
  json.member("used", slice.units);
  json.member("guessed", slice.units_guessed);
  json.end_object();
  json.member("scale_mm_per_unit", slice.placement.scale);
  write_grid(json, slice);
  write_corrections(json, report.sizes);
  json.member("grey", kGreyWords[static_cast<std::size_t>(report.grey)]);
  json.begin_object("underside", kOneLine);
  json.member("base", report.base);
  json.member("on_base_plane", slice.flat_underside);
  json.end_object();
  write_points(json, slice);
  write_rays(json, slice);
  write_evidence(json, report.coverage,
                 layer_hashes.empty() ? std::span<const ConfidenceMap::Counts>{} : slice.confidence.layers());
  write_proof(json, slice.proof);
  json.member("volume_mm3", report.volume_mm3());
  write_bleed(json, report.supports.bleed);
  write_supports(json, report);
  write_issues(json, report.findings, slice.placement.grid, report.checks);
  write_stages(json, report);
  json.begin_array("warnings");
  for (const auto& line : report.warnings.all()) json.value(line);
  json.end_array();
  write_hashes(json, report, layer_hashes);
  json.end_object();
}

}  // namespace plumbline::firmware
