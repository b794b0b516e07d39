#include "slicer/reader/peeked_source.hpp"

#include <algorithm>
#include <cstring>

#include "slicer/reader/scan_reader.hpp"

namespace plumbline::inline slicer {
namespace {

/// Stops the reader as soon as it has read the header.
class HeadSink final : public PointSink {
 public:
  Status begin(const ScanHeader& header) override {
    header_ = header;
    return fail(ErrorCode::kCancelled, "the header has been read");
  }
  Status take(std::span<const ScanPoint> /*points*/) override { return {}; }
  bool progress(double /*fraction*/) override { return true; }
  const std::optional<ScanHeader>& header() const { return header_; }

 private:
  std::optional<ScanHeader> header_;
};

}  // namespace

Expected<std::optional<ScanHeader>> PeekedSource::peek(std::span<std::byte> workspace) {
  while (kept_ < room_.size()) {
    const auto got = source_.read(room_.subspan(kept_));
    PLUMBLINE_TRY(got);
    if (*got == 0) break;
    kept_ += *got;
  }
  HeadSink sink;
  peeking_ = true;
  // Always ends with an error: the sink's, or one because the kept bytes are not a whole scan.
  static_cast<void>(read_scan(*this, sink, workspace));
  peeking_ = false;
  at_ = 0;
  return sink.header();
}

Expected<std::size_t> PeekedSource::read(std::span<std::byte> buffer) {
  if (at_ == kept_) {
    if (peeking_) return std::size_t{0};
    return source_.read(buffer);
  }
  const std::size_t count = std::min(buffer.size(), kept_ - at_);
  std::memcpy(buffer.data(), room_.data() + at_, count);
  at_ += count;
  return count;
}

Status PeekedSource::rewind() {
  if (!peeking_) {
    PLUMBLINE_TRY(source_.rewind());
    kept_ = 0;
  }
  at_ = 0;
  return {};
}

}  // namespace plumbline::inline slicer
