#pragma once
/// The one block of memory that holds all of the slicer's data.
///
///   bottom  data kept until the print ends ->  ...free...  <- scratch of the running stage  top
///
/// Both ends are stacks. A stage takes scratch from the top inside an ArenaScope, which releases it in order. An arena
/// never grows, never allocates, and does not own its block.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "slicer/core/error.hpp"

namespace plumbline::inline slicer {

class Arena {
 public:
  static constexpr std::size_t kAlignment = 64;  ///< bytes: a cache line, so that no two blocks share one

  /// @param block  caller's memory, of any alignment and size; must outlive the arena
  explicit Arena(std::span<std::byte> block) : Arena(block, kNone) {}
  /// For tests of what happens when memory runs out.
  /// @param refused  number of the one block that is not given, as if the arena were full; the first is 0
  Arena(std::span<std::byte> block, std::uint64_t refused);
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  std::size_t capacity() const { return capacity_; }               ///< bytes
  std::size_t bottom_used() const { return bottom_; }              ///< bytes
  std::size_t top_used() const { return capacity_ - top_; }        ///< bytes
  std::size_t used() const { return bottom_used() + top_used(); }  ///< bytes
  std::size_t available() const { return top_ - bottom_; }         ///< bytes
  std::size_t peak() const { return peak_; }  ///< highest used() since the last reset_peak(), bytes
  void reset_peak() { peak_ = used(); }
  std::uint64_t requests() const { return requests_; }  ///< blocks that were asked for

  /// Takes `count` uninitialised objects from the bottom. They stay until release_bottom() to an earlier mark.
  /// @param stage  named in the error
  /// @retval ErrorCode::kOutOfMemory  the message gives stage, bytes needed and bytes left
  template <class T>
  [[nodiscard]] Expected<std::span<T>> take_bottom(std::size_t count, const char* stage) {
    return take<T>(count, stage, true);
  }
  /// Takes `count` objects from the top; see take_bottom().
  template <class T>
  [[nodiscard]] Expected<std::span<T>> take_top(std::size_t count, const char* stage) {
    return take<T>(count, stage, false);
  }

  /// The same, as a span that is there already.
  template <class T>
  [[nodiscard]] Status take_bottom(std::span<T>& block, std::size_t count, const char* stage) {
    return take<T>(count, stage, true).map([&](std::span<T> taken) { block = taken; });
  }
  template <class T>
  [[nodiscard]] Status take_top(std::span<T>& block, std::size_t count, const char* stage) {
    return take<T>(count, stage, false).map([&](std::span<T> taken) { block = taken; });
  }

  /// What is left, for a stage that learns only while it fills the room how much it needs. It takes that much afterwards.
  std::span<std::byte> free_room() const { return {base_ + bottom_, available()}; }

  std::size_t bottom_mark() const { return bottom_; }
  std::size_t top_mark() const { return top_; }
  void release_bottom(std::size_t mark) { bottom_ = mark; }
  void release_top(std::size_t mark) { top_ = mark; }

  /// Shrinks the newest block at the bottom to its first `used` bytes.
  void trim_bottom(const void* block, std::size_t used);

  /// Bytes that a block of `bytes` takes, rounded up to whole cache lines.
  static constexpr std::size_t rounded(std::size_t bytes) { return (bytes + kAlignment - 1) / kAlignment * kAlignment; }

 private:
  template <class T>
  Expected<std::span<T>> take(std::size_t count, const char* stage, bool bottom) {
    static_assert(std::is_trivially_destructible_v<T>, "the arena never runs destructors");
    static_assert(alignof(T) <= kAlignment);
    auto block = take_bytes(count, sizeof(T), stage, bottom);
    if (!block) return tl::unexpected<Error>(block.error());
    return std::span<T>(static_cast<T*>(*block), count);
  }
  Expected<void*> take_bytes(std::size_t count, std::size_t size, const char* stage, bool bottom);

  static constexpr std::uint64_t kNone = ~std::uint64_t{0};

  std::byte* base_ = nullptr;
  std::size_t capacity_ = 0;
  std::size_t bottom_ = 0;
  std::size_t top_ = 0;
  std::size_t peak_ = 0;
  std::uint64_t requests_ = 0;
  std::uint64_t refused_;
};

/// At its end, releases everything taken from the top since its start.
class ArenaScope {
 public:
  explicit ArenaScope(Arena& arena) : arena_(arena), mark_(arena.top_mark()) {}
  ~ArenaScope() { arena_.release_top(mark_); }
  ArenaScope(const ArenaScope&) = delete;
  ArenaScope& operator=(const ArenaScope&) = delete;

 private:
  Arena& arena_;
  std::size_t mark_;
};

/// The same at the bottom.
class BottomScope {
 public:
  explicit BottomScope(Arena& arena) : arena_(arena), mark_(arena.bottom_mark()) {}
  ~BottomScope() { arena_.release_bottom(mark_); }
  BottomScope(const BottomScope&) = delete;
  BottomScope& operator=(const BottomScope&) = delete;

 private:
  Arena& arena_;
  std::size_t mark_;
};

}  // namespace plumbline::inline slicer
