#pragma once
/// The manifest of a job: what its layers are and how they were made. Other reports have some of its members.

#include <cstdint>
#include <span>

#include "firmware/io/text/json_fields.hpp"
#include "firmware/slice/job_report.hpp"
#include "slicer/reader/formats/format_probe.hpp"

namespace plumbline::firmware {

inline constexpr JsonField<ScanSummary> kScanFields[] = {
    {"format", [](auto& json, auto& scan) { json.value(scan.header.format); }},
    {"encoding", [](auto& json, auto& scan) { json.value(scan.header.encoding); }},
    {"bytes", member<&ScanSummary::bytes>},
    {"points", member<&ScanSummary::points>},
    {"points_not_finite", member<&ScanSummary::not_finite>},
    {"points_left_out", member<&ScanSummary::left_out>},
};

inline constexpr JsonField<NormalCounts> kNormalFields[] = {
    {"normals_estimated", member<&NormalCounts::estimated>},
    {"normals_turned", member<&NormalCounts::turned>},
    {"normals_inside_out", member<&NormalCounts::inside_out>},
    {"normals_contradictory", member<&NormalCounts::contradictory>},
};

inline constexpr JsonField<PrintGrid> kGridFields[] = {
    {"columns", member<&PrintGrid::columns>},
    {"rows", member<&PrintGrid::rows>},
    {"layers", member<&PrintGrid::layers>},
    {"pixel_pitch_mm",
     [](auto& json, auto& grid) {
       json.value(std::array{grid.pitch_x_mm, grid.pitch_y_mm});
     }},
    {"layer_height_mm", member<&PrintGrid::layer_height_mm>},
};

/// Writes a member for each word of an enumeration: "winding_number" for "winding number".
template <class Word, class Values>
void write_by(JsonWriter& json, const Values& values) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    FixedText<32> key;
    for (const char c : std::string_view(to_string(static_cast<Word>(i))))
      key.add("%c", c == ' ' || c == '-' ? '_' : c);
    json.member(key.view(), values[i]);
  }
}

/// Writes the files of a scan as the member "files", in reading order, if there are several.
void write_files(JsonWriter& json, std::span<const std::string> names, const ScanSummaries& scans);

/// Writes the member "mesh"; null for a scan.
void write_mesh(JsonWriter& json, const std::optional<MeshCounts>& mesh);

/// Writes what was left out of the scan, how it was turned, and how it had better lie.
void write_position(JsonWriter& json, const PreparationReport& found);

/// Raised when a key changes its meaning or is removed, not for new keys.
inline constexpr std::uint32_t kManifestFormat = 2;

/// Writes the manifest as one JSON object. firmware/README.md explains its keys.
/// @param layer_hashes  mask_hash() of each layer; empty: none are written
void write_manifest(JsonWriter& json, const JobReport& report, std::span<const std::uint64_t> layer_hashes);

}  // namespace plumbline::firmware
