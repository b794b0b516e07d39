#pragma once
/// What is said of the proof of a print against the points of its scan.

#include "firmware/io/text/fixed_text.hpp"
#include "slicer/core/error.hpp"
#include "slicer/reader/scan_sources.hpp"
#include "slicer/rrep/point_proof.hpp"

namespace plumbline::firmware {

class JsonWriter;

/// "31 % of the points lie more than 0.4 mm off what is printed".
FixedText<96> points_off_sentence(const PointProof& proof);

/// The same with what to do.
FixedText<200> points_off_warning(const PointProof& proof);

/// Refuses a print that is not what was scanned.
/// @retval ErrorCode::kNoSurface  more than PointProof::kMost of the points lie off it: names the files and what to do
[[nodiscard]] Status check_proof(const PointProof& proof, ScanSources sources);

/// "98.6 % of the points lie within 0.2 mm of what is printed, 92.8 % within a pixel": what shows that the print is what was scanned.
FixedText<128> proven_text(const PointProof& proof);

/// Writes "proof": counts of points, and the distance from which on they are off.
void write_proof(JsonWriter& json, const PointProof& proof);

}  // namespace plumbline::firmware
