#pragma once
/// Most of a panel is black: one look at a row spares the rest of the work on it.

#include <cstdint>
#include <span>

namespace plumbline {

/// Whether all pixels of a row of a BitImage are black.
inline bool is_blank(std::span<const std::uint64_t> row) {
  std::uint64_t any = 0;
  for (const std::uint64_t word : row) any |= word;
  return any == 0;
}

}  // namespace plumbline
