#pragma once
/// Any scan format that plumbline reads, as a stream, in fixed memory.

#include <cstddef>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/byte_source.hpp"
#include "slicer/reader/stream/scan_point.hpp"

namespace plumbline {

/// Bytes of work space that read_scan() needs for any file but a large PCD with compressed columns.
inline constexpr std::size_t kReaderWorkspace = std::size_t{512} * 1024;

/// Reads a scan from start to end and hands its points to `sink`.
///
/// The format is told by the first bytes; XYZ, which has no mark, also by the name's ending (.xyz .txt .pts .asc).
/// @param workspace  at least kReaderWorkspace bytes, uninitialised
/// @param lent       may be null; what its bottom has free when the points begin may be used until the end, for the columns
///                   of a compressed PCD: ScanHeader::reader_bytes. The caller releases it
/// @returns what was read; at least one point
/// @retval ErrorCode::kUnknownFormat, kMalformed, kTruncated, kUnsupported, kNoPoints  with source.name(), byte or line,
///         what was expected and what was found
/// @retval any error of the source or the sink
[[nodiscard]] Expected<ScanSummary> read_scan(ByteSource& source, PointSink& sink, std::span<std::byte> workspace,
                                              Arena* lent = nullptr);

}  // namespace plumbline
