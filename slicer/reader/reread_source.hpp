#pragma once
/// A stream that can be read several times, even if its source can't.

#include <cstddef>
#include <optional>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/byte_source.hpp"

namespace plumbline::inline slicer {

/// Goes back by rewinding its source. If that can't be done, keeps a copy of what was read in the arena.
class RereadSource final : public ByteSource {
 public:
  /// Bytes at the beginning that are kept of any source that can't be rewound, before keep_all().
  static constexpr std::size_t kHeadBytes = 4096;

  /// @param source  at its beginning; outlives this
  /// @param arena   kHeadBytes from the top, if the source can't be rewound
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<RereadSource> open(ByteSource& source, Arena& arena);

  /// From now on all bytes are kept, if the source can't be rewound. Call it at the beginning of the stream.
  /// @param arena  as many bytes from the top as the source has; a quarter of what is left if that is unknown
  [[nodiscard]] Status keep_all(Arena& arena);

  /// @retval ErrorCode::kOutOfMemory  there is no room for the copy
  [[nodiscard]] Expected<std::size_t> read(std::span<std::byte> buffer) override;
  std::string_view name() const override { return source_->name(); }
  std::optional<std::uint64_t> size() const override {
    return is_peeking_ && !rewinds_ ? std::optional<std::uint64_t>() : source_->size();
  }
  /// @retval ErrorCode::kUnsupported  bytes that were not kept have been read
  [[nodiscard]] Status rewind() override;
  bool is_pipe() const { return !rewinds_; }  ///< the source can be read only once

  /// Ends the stream after the bytes that can be kept, until the next rewind(): for looking at the beginning of a file.
  void peek() { is_peeking_ = true; }

 private:
  explicit RereadSource(ByteSource& source) : source_(&source) {}

  ByteSource* source_;
  bool rewinds_ = true;  ///< the source does
  bool is_peeking_ = false;
  bool keeps_all_ = false;
  bool lost_ = false;          ///< bytes were read and not kept
  std::span<std::byte> kept_;  ///< unless rewinds_
  std::size_t filled_ = 0;     ///< of kept_
  std::size_t at_ = 0;         ///< in the stream, as far as it is kept
};

}  // namespace plumbline::inline slicer
