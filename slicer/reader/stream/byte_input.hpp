#pragma once
/// A window over a ByteSource, from which every scan reader takes its bytes.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "slicer/core/byte_source.hpp"
#include "slicer/reader/stream/read_progress.hpp"

namespace plumbline::inline slicer {

/// Bytes that were read but not yet consumed lie contiguously in one fixed buffer, whatever the size of the source's
/// reads. Progress and cancellation are handled here, because every reader, skipping or parsing, passes this loop.
class ByteInput {
 public:
  /// @param sink    gets the progress, and may cancel
  /// @param buffer  not empty; its size limits the line or record that can be parsed as a whole
  ByteInput(ByteSource& source, ReadProgress& sink, std::span<std::byte> buffer);
  ByteInput(const ByteInput&) = delete;
  ByteInput& operator=(const ByteInput&) = delete;

  const char* begin() const { return data_ + begin_; }
  const char* end() const { return data_ + end_; }
  std::size_t available() const { return end_ - begin_; }  ///< bytes
  std::size_t capacity() const { return capacity_; }       ///< bytes
  bool full() const { return available() == capacity_; }
  /// @param bytes  at most available()
  void consume(std::size_t bytes) { begin_ += bytes; }

  std::uint64_t offset() const { return bytes_read_ - available(); }  ///< of begin() in the stream, bytes
  std::uint64_t bytes_read() const { return bytes_read_; }
  std::uint64_t farthest() const { return std::max(farthest_, bytes_read_); }  ///< bytes_read(), before a rewind() too

  /// Reads more bytes into the window, which must not be full(). Invalidates pointers into it.
  /// @returns false at the end of the stream
  /// @retval ErrorCode::kCancelled  the sink asked to stop
  [[nodiscard]] Expected<bool> more();

  /// Reads until `bytes` are available or the stream ends.
  /// @param bytes  at most capacity()
  /// @returns available()
  [[nodiscard]] Expected<std::size_t> fill(std::size_t bytes);

  /// Consumes `bytes` bytes, or all that are left if there are fewer.
  /// @returns how many it consumed
  [[nodiscard]] Expected<std::uint64_t> skip(std::uint64_t bytes);

  /// Goes back to the first byte, for a format that is read twice.
  /// @retval ErrorCode::kUnsupported  the source can be read only once
  [[nodiscard]] Status rewind();

  /// From now on, the progress through the source is reported as `from` to `to` of the whole.
  void report_within(double from, double to) { share_ = {from, to}; }

  /// Reports to the sink that reading is done, even if the rest of the file was not needed.
  [[nodiscard]] Status finish();

  std::string_view name() const { return source_.name(); }
  std::optional<std::uint64_t> size() const { return source_.size(); }

  /// An error that starts with the file's name.
  [[gnu::format(printf, 3, 4)]] tl::unexpected<Error> fail(ErrorCode code, const char* pattern, ...) const;

 private:
  Status report(double fraction);

  ByteSource& source_;
  ReadProgress& sink_;
  char* data_;
  std::size_t capacity_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::uint64_t bytes_read_ = 0;
  std::uint64_t reported_ = 0;
  std::uint64_t farthest_ = 0;
  struct {
    double from = 0, to = 1;
  } share_;           ///< of the progress
  double shown_ = 0;  ///< the last progress: what was probed before report_within() must not take it back
  bool ended_ = false;
};

}  // namespace plumbline::inline slicer
