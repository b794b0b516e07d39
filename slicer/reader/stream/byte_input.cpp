#include "slicer/reader/stream/byte_input.hpp"

#include <algorithm>
#include <cassert>
#include <cstdarg>
#include <cstdio>
#include <cstring>

namespace plumbline::inline slicer {
namespace {

/// Bytes between two progress reports: a progress bar moves even on a slow stick (1 MB/s: 30 reports a second), and a
/// source that delivers single bytes doesn't report each of them.
constexpr std::uint64_t kReportEvery = 32 * 1024;

/// Characters of a file's name in a message. Longer paths lose their start, which says less than their end; the message
/// (Error::kCapacity) needs the room for what went wrong.
constexpr std::size_t kLongestName = 96;

}  // namespace

ByteInput::ByteInput(ByteSource& source, ReadProgress& sink, std::span<std::byte> buffer)
    : source_(source), sink_(sink), data_(reinterpret_cast<char*>(buffer.data())), capacity_(buffer.size()) {
  assert(!buffer.empty());
}

Expected<bool> ByteInput::more() {
  assert(!full());
  if (ended_) return false;
  if (begin_ == end_) {
    begin_ = end_ = 0;
  } else if (end_ == capacity_) {
    std::memmove(data_, data_ + begin_, available());
    end_ -= begin_;
    begin_ = 0;
  }
  const std::span<char> room(data_ + end_, capacity_ - end_);
  const auto count = source_.read(std::as_writable_bytes(room));
  PLUMBLINE_TRY(count);
  assert(*count <= room.size());
  if (*count == 0) {
    ended_ = true;
    const auto size = source_.size();
    if (!size || bytes_read_ >= *size) return false;
    return fail(ErrorCode::kTruncated, "only %llu of its %llu bytes can be read.\tCopy it again",
                static_cast<unsigned long long>(bytes_read_), static_cast<unsigned long long>(*size));
  }
  end_ += *count;
  bytes_read_ += *count;
  if (bytes_read_ - reported_ >= kReportEvery) {
    reported_ = bytes_read_;
    const auto size = source_.size();
    const double done =
        size && *size > 0 ? std::min(1.0, static_cast<double>(bytes_read_) / static_cast<double>(*size)) : 0.0;
    shown_ = std::max(shown_, share_.from + (share_.to - share_.from) * done);
    PLUMBLINE_TRY(report(shown_));
  }
  return true;
}

Expected<std::size_t> ByteInput::fill(std::size_t bytes) {
  assert(bytes <= capacity_);
  while (available() < bytes) {
    const auto grown = more();
    PLUMBLINE_TRY(grown);
    if (!*grown) break;
  }
  return available();
}

Expected<std::uint64_t> ByteInput::skip(std::uint64_t bytes) {
  std::uint64_t left = bytes;
  for (;;) {
    const auto step = static_cast<std::size_t>(std::min<std::uint64_t>(left, available()));
    consume(step);
    left -= step;
    if (left == 0) return bytes;
    const auto grown = more();
    PLUMBLINE_TRY(grown);
    if (!*grown) return bytes - left;
  }
}

Status ByteInput::rewind() {
  PLUMBLINE_TRY(source_.rewind());
  farthest_ = farthest();
  begin_ = end_ = 0;
  bytes_read_ = reported_ = 0;
  ended_ = false;
  return {};
}

Status ByteInput::finish() { return report(1.0); }

Status ByteInput::report(double fraction) {
  if (!sink_.progress(fraction)) {
    return fail(ErrorCode::kCancelled, "reading was cancelled after %llu bytes",
                static_cast<unsigned long long>(bytes_read_));
  }
  return {};
}

tl::unexpected<Error> ByteInput::fail(ErrorCode code, const char* pattern, ...) const {
  va_list args;
  va_start(args, pattern);
  const Error error = Error::format_list(code, pattern, args);
  va_end(args);
  auto shown = name();
  if (shown.size() <= kLongestName) return tl::unexpected<Error>(error.with_prefix(shown));
  shown.remove_prefix(shown.size() - kLongestName);
  char cut[kLongestName + 4];
  std::snprintf(cut, sizeof cut, "...%.*s", static_cast<int>(shown.size()), shown.data());
  return tl::unexpected<Error>(error.with_prefix(cut));
}

}  // namespace plumbline::inline slicer
