#include "slicer/core/arena.hpp"

#include <limits>

#include "slicer/core/numbers/mib.hpp"

namespace plumbline::inline slicer {

Arena::Arena(std::span<std::byte> block, std::uint64_t refused) : refused_(refused) {
  const auto address = reinterpret_cast<std::uintptr_t>(block.data());
  const std::size_t skip = (kAlignment - address % kAlignment) % kAlignment;
  if (block.size() > skip) {
    base_ = block.data() + skip;
    capacity_ = (block.size() - skip) / kAlignment * kAlignment;
  }
  top_ = capacity_;
}

Expected<void*> Arena::take_bytes(std::size_t count, std::size_t size, const char* stage, bool bottom) {
  const bool overflows = count > (std::numeric_limits<std::size_t>::max() - kAlignment) / size;
  const std::size_t need = overflows ? std::numeric_limits<std::size_t>::max() : rounded(count * size);
  if (requests_++ == refused_ || need > available()) {
    return telling(
        Told(ToldCode::kMemoryNeeded, {{Fact::kNeededMib, mib(need)}, {Fact::kAvailableMib, mib(available())}}),
        fail(
            ErrorCode::kOutOfMemory,
            "%s: needs %.1f MiB, but %.1f MiB of the arena's %.1f MiB are left.\tUse a larger arena, fewer points or a "
            "coarser grid",
            stage, mib(need), mib(available()), mib(capacity_)));
  }
  std::size_t offset = bottom_;
  if (bottom) {
    bottom_ += need;
  } else {
    top_ -= need;
    offset = top_;
  }
  peak_ = std::max(peak_, used());
  return base_ + offset;
}

void Arena::trim_bottom(const void* block, std::size_t used) {
  const auto offset = static_cast<std::size_t>(static_cast<const std::byte*>(block) - base_);
  bottom_ = std::min(bottom_, offset + rounded(used));
}

}  // namespace plumbline::inline slicer
