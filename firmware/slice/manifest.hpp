#pragma once
/// The manifest of a job: what its layers are and how they were made.

#include <cstdint>
#include <span>

#include "firmware/io/text/json_writer.hpp"
#include "firmware/slice/job_report.hpp"

namespace plumbline {

/// Writes the files of a scan as the member "files", in reading order.
void write_files(JsonWriter& json, std::span<const std::string> names, const ScanSummaries& scans);

/// Writes the key "mesh"; null for a scan.
void write_mesh(JsonWriter& json, const std::optional<MeshCounts>& mesh);

/// Writes what was left out as the member "stray_pieces".
/// Keys "floor" and "orientation": what was cut off below the object, how it was turned, and how it had better lie.
void write_position(JsonWriter& json, const PreparationReport& found);
void write_strays(JsonWriter& json, const StrayPieces& strays);

/// Raised when a key changes its meaning or is removed, not for new keys.
inline constexpr std::uint32_t kManifestFormat = 2;

/// Writes the manifest as one JSON object. firmware/README.md explains its keys.
/// @param layer_hashes  mask_hash() of each layer; empty: none are written
void write_manifest(JsonWriter& json, const JobReport& report, std::span<const std::uint64_t> layer_hashes);

}  // namespace plumbline
