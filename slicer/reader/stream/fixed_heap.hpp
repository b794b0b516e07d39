#pragma once
/// malloc() and free() within a fixed block, for libraries that allocate.

#include <cstddef>
#include <span>

namespace plumbline::inline slicer {

/// First fit; neighbouring free parts are joined. Made for some hundred parts: each request looks at all of them.
class FixedHeap {
 public:
  /// @param block  aligned to kAlignment; must outlive the heap
  explicit FixedHeap(std::span<std::byte> block);
  FixedHeap(const FixedHeap&) = delete;
  FixedHeap& operator=(const FixedHeap&) = delete;

  static constexpr std::size_t kAlignment = 16;  ///< bytes

  /// @returns null if no part is large enough
  void* allocate(std::size_t bytes);
  /// Moves what is at `old`, which may be null, to a part of `bytes` bytes.
  /// @returns null if no part is large enough; `old` is then as before
  void* reallocate(void* old, std::size_t bytes);
  /// @param part  from allocate(), or null
  void release(void* part);
  bool refused() const { return refused_; }  ///< whether a request found no room

 private:
  struct alignas(kAlignment) Head {
    std::size_t bytes;  ///< of the part, its head included
    bool used;
  };
  static Head* head_of(void* part) { return static_cast<Head*>(part) - 1; }
  Head* after(Head* head) const { return reinterpret_cast<Head*>(reinterpret_cast<std::byte*>(head) + head->bytes); }

  Head* first_ = nullptr;
  Head* end_ = nullptr;
  bool refused_ = false;
};

}  // namespace plumbline::inline slicer
