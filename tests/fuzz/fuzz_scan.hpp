#pragma once
/// Reads any bytes as a scan and checks what must always hold.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>

#include "slicer/reader/scan_reader.hpp"
#include "tests/fuzz/require.hpp"

namespace plumbline::firmware::fuzz {

/// Delivers bytes all at once, or in pieces of 1 to 97 that depend only on the input.
class Pieces final : public ByteSource {
 public:
  Pieces(std::string_view bytes, const char* name, bool whole)
      : all_(bytes), bytes_(bytes), name_(name), whole_(whole) {}

  Expected<std::size_t> read(std::span<std::byte> buffer) override {
    require(!buffer.empty(), "the reader asks for no bytes");
    std::size_t count = std::min(buffer.size(), bytes_.size());
    if (!whole_) {
      state_ = state_ * 1664525U + 1013904223U;
      count = std::min<std::size_t>(count, 1 + (state_ >> 16) % 97);
    }
    if (count > 0) std::memcpy(buffer.data(), bytes_.data(), count);
    bytes_.remove_prefix(count);
    return count;
  }
  std::string_view name() const override { return name_; }
  std::optional<std::uint64_t> size() const override { return std::nullopt; }
  Status rewind() override {
    bytes_ = all_;
    return {};
  }

 private:
  std::string_view all_;
  std::string_view bytes_;  ///< not read yet
  const char* name_;
  bool whole_;
  std::uint32_t state_ = 1;
};

class CheckingSink final : public PointSink {
 public:
  Status begin(const ScanHeader& header) override {
    require(!begun_, "begun twice");
    begun_ = true;
    has_normals_ = header.has_normals;
    return {};
  }
  Status take(std::span<const ScanPoint> points) override {
    require(begun_, "points before begin");
    require(!points.empty() && points.size() <= 1024, "size of a batch");
    for (const ScanPoint& p : points) {
      require(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z), "a position is not finite");
      require(std::isfinite(p.nx) && std::isfinite(p.ny) && std::isfinite(p.nz), "a normal is not finite");
      const bool none = p.nx == 0 && p.ny == 0 && p.nz == 0;
      require(has_normals_ || none, "a normal in a file without normals");
      if (has_normals_ && none) ++without_normal;
      const double numbers[] = {
          p.x, p.y, p.z, static_cast<double>(p.nx), static_cast<double>(p.ny), static_cast<double>(p.nz)};
      for (const double number : numbers) {
        std::uint64_t bits = 0;
        std::memcpy(&bits, &number, sizeof bits);
        hash = (hash ^ bits) * 1099511628211U;
      }
    }
    count += points.size();
    return {};
  }
  bool progress(double fraction) override {
    require(fraction >= 0 && fraction <= 1, "a fraction is outside of 0 to 1");
    return true;
  }

  std::uint64_t count = 0;
  std::uint64_t without_normal = 0;
  std::uint64_t hash = 14695981039346656037U;

 private:
  bool begun_ = false;
  bool has_normals_ = false;
};

struct Outcome {
  Expected<ScanSummary> summary;
  CheckingSink sink;
};

inline Outcome read(std::string_view bytes, const char* name, bool whole) {
  static std::byte workspace[kReaderWorkspace];
  // Not cleared between runs: what one scan leaves must not affect the next.
  Pieces source(bytes, name, whole);
  CheckingSink sink;
  auto summary = read_scan(source, sink, workspace);
  return {summary, sink};
}

/// Reads `bytes` as file `name`, at once and in pieces, and aborts if
///  - a point is not finite, or a batch is empty, too large or before begin();
///  - the summary's counts differ from what was delivered;
///  - an error has no message, or a success no point;
///  - points, counts or errors depend on the pieces.
/// @param points_a_byte  at most: more than one where a format packs or compresses them
/// @returns 0, as libFuzzer requires
inline int check_scan(const char* name, const std::uint8_t* bytes, std::size_t size, std::uint64_t points_a_byte = 1) {
  const std::string_view file(reinterpret_cast<const char*>(bytes), size);
  const Outcome whole = read(file, name, true);
  if (whole.summary) {
    require(whole.summary->points > 0, "a success without points");
    require(whole.summary->points == whole.sink.count, "the summary counts other points than came");
    require(whole.summary->without_normal == whole.sink.without_normal, "the summary counts other missing normals");
    require(whole.summary->bytes <= size, "more bytes than there are");
    require(whole.summary->points <= points_a_byte * size, "more points than the bytes can hold");
  } else {
    require(std::strlen(whole.summary.error().message()) > std::strlen(name) + 2, "an error without a message");
    require(std::strncmp(whole.summary.error().message(), name, std::strlen(name)) == 0, "an error without the name");
  }
  const Outcome parts = read(file, name, false);
  require(whole.summary.has_value() == parts.summary.has_value(), "pieces change the outcome");
  require(whole.sink.count == parts.sink.count && whole.sink.hash == parts.sink.hash, "pieces change the points");
  if (whole.summary) {
    require(whole.summary->not_finite == parts.summary->not_finite, "pieces change what is dropped");
  } else {
    require(whole.summary.error().code() == parts.summary.error().code(), "pieces change the error");
  }
  return 0;
}

}  // namespace plumbline::firmware::fuzz
