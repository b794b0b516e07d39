#pragma once
/// Reads any supported scan format as a stream, in fixed memory.

#include <cstddef>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/byte_source.hpp"
#include "slicer/reader/stream/scan_point.hpp"

namespace plumbline::inline slicer {

/// Bytes of workspace that read_scan() needs for any file but a large compressed PCD or SPZ: the 64 KiB window, 1024 points, the
/// largest header, and compressed columns of some 45,000 points.
inline constexpr std::size_t kReaderWorkspace = std::size_t{512} * 1024;

/// Reads a scan from start to end and passes its points to `sink`.
///
/// The first bytes decide the format. XYZ has no signature, so the name's ending (scan_endings.hpp) counts too.
/// @param workspace  at least kReaderWorkspace bytes, uninitialised
/// @param lent       may be null. The columns of a compressed PCD or an SPZ (ScanHeader::reader_bytes) are kept at its bottom. The
///                   caller releases them
/// @returns what was read: at least one point
/// @retval ErrorCode::kUnknownFormat, kMalformed, kTruncated, kUnsupported, kNoPoints  the message gives source.name(),
///         byte or line, what was expected and what was found
/// @retval any error of the source or the sink
[[nodiscard]] Expected<ScanSummary> read_scan(ByteSource& source, PointSink& sink, std::span<std::byte> workspace,
                                              Arena* lent = nullptr);

}  // namespace plumbline::inline slicer
