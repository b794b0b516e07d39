#include "slicer/reader/stream/fixed_heap.hpp"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <cstring>
#include <new>

namespace plumbline::inline slicer {

FixedHeap::FixedHeap(std::span<std::byte> block) {
  assert(reinterpret_cast<std::uintptr_t>(block.data()) % kAlignment == 0);
  const std::size_t bytes = block.size() / kAlignment * kAlignment;
  assert(bytes >= sizeof(Head));
  first_ = new (block.data()) Head{bytes, false};
  end_ = after(first_);
}

void* FixedHeap::allocate(std::size_t bytes) {
  const auto room = static_cast<std::size_t>(reinterpret_cast<std::byte*>(end_) - reinterpret_cast<std::byte*>(first_));
  if (bytes <= room) {
    const std::size_t need = sizeof(Head) + (bytes + kAlignment - 1) / kAlignment * kAlignment;
    for (Head* head = first_; head != end_; head = after(head)) {
      if (head->used) continue;
      for (Head* next = after(head); next != end_ && !next->used; next = after(head)) head->bytes += next->bytes;
      if (head->bytes < need) continue;
      if (head->bytes - need >= 2 * sizeof(Head)) {
        const std::size_t rest = head->bytes - need;
        head->bytes = need;
        new (after(head)) Head{rest, false};
      }
      head->used = true;
      return head + 1;
    }
  }
  refused_ = true;
  return nullptr;
}

void* FixedHeap::reallocate(void* old, std::size_t bytes) {
  void* const fresh = allocate(bytes);
  if (fresh == nullptr || old == nullptr) return fresh;
  std::memcpy(fresh, old, std::min(bytes, head_of(old)->bytes - sizeof(Head)));
  release(old);
  return fresh;
}

void FixedHeap::release(void* part) {
  if (part != nullptr) head_of(part)->used = false;
}

}  // namespace plumbline::inline slicer
