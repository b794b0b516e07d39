#pragma once
/// A window over a ByteSource: what every scan reader takes its bytes from.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "slicer/core/byte_source.hpp"
#include "slicer/reader/stream/scan_point.hpp"

namespace plumbline {

/// The bytes that have been read and not yet used lie side by side in one fixed buffer, however small the pieces are in
/// which the source delivers. Progress and cancelling are here, because this is the one loop that every reader,
/// skipping or parsing, must pass.
class ByteInput {
 public:
  /// @param sink    hears the progress
  /// @param buffer  not empty; its size is the longest line or record that can be looked at as a whole
  ByteInput(ByteSource& source, PointSink& sink, std::span<std::byte> buffer);
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

  /// Reads more behind the window, which must not be full(). Moves the window: pointers into it are void.
  /// @returns false at the end of the stream
  /// @retval ErrorCode::kCancelled  the sink asked to stop
  [[nodiscard]] Expected<bool> more();

  /// Reads until `bytes` are available or the stream ends.
  /// @param bytes  at most capacity()
  /// @returns available()
  [[nodiscard]] Expected<std::size_t> fill(std::size_t bytes);

  /// Uses up `bytes` bytes unseen, or what there is.
  /// @returns how many there were
  [[nodiscard]] Expected<std::uint64_t> skip(std::uint64_t bytes);

  /// Tells the sink that reading is over, also where the rest of the file did not matter.
  [[nodiscard]] Status finish();

  std::string_view name() const { return source_.name(); }
  std::optional<std::uint64_t> size() const { return source_.size(); }

  /// An error that starts with the file's name.
  [[gnu::format(printf, 3, 4)]] tl::unexpected<Error> fail(ErrorCode code, const char* pattern, ...) const;

 private:
  Status report(double fraction);

  ByteSource& source_;
  PointSink& sink_;
  char* data_;
  std::size_t capacity_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::uint64_t bytes_read_ = 0;
  std::uint64_t reported_ = 0;
  bool ended_ = false;
};

}  // namespace plumbline
