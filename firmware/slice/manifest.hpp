#pragma once
/// The manifest of a job: what the layers are, and how they came to be.

#include <cstdint>
#include <span>

#include "firmware/io/json_writer.hpp"
#include "firmware/slice/job_report.hpp"

namespace plumbline {

/// The files of a scan as the member "files", in the order in which they were read.
void write_files(JsonWriter& json, std::span<const std::string> names, const ScanSummaries& scans);

/// What was left out, as the member "stray_pieces".
void write_strays(JsonWriter& json, const StrayPieces& strays);

/// Raised when a key changes its meaning or goes away; new keys do not raise it.
inline constexpr std::uint32_t kManifestFormat = 2;

/// Writes the manifest as one JSON object. firmware/README.md explains its keys.
/// @param layer_hashes  mask_hash() of each layer; empty: the manifest is written without them
void write_manifest(JsonWriter& json, const JobReport& report, std::span<const std::uint64_t> layer_hashes);

}  // namespace plumbline
