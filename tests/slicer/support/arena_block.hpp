#pragma once
/// An arena that owns its memory.

#include <cstddef>
#include <memory>

#include "slicer/core/arena.hpp"

namespace plumbline::testing {

class ArenaBlock {
 public:
  /// Only touched pages use memory.
  explicit ArenaBlock(std::size_t bytes)
      : block_(std::make_unique_for_overwrite<std::byte[]>(bytes)), arena_({block_.get(), bytes}) {}
  /// @param refused  see Arena::Arena()
  ArenaBlock(std::size_t bytes, std::uint64_t refused)
      : block_(std::make_unique_for_overwrite<std::byte[]>(bytes)), arena_({block_.get(), bytes}, refused) {}
  Arena& operator*() { return arena_; }
  Arena* operator->() { return &arena_; }

 private:
  std::unique_ptr<std::byte[]> block_;
  Arena arena_;
};

inline constexpr std::size_t kMiB = std::size_t{1024} * 1024;

}  // namespace plumbline::testing
