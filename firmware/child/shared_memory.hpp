#pragma once
/// The memory that the firmware shares with the slicing child: a page of messages, then the arena.

#include <atomic>
#include <cstddef>
#include <memory>
#include <span>

#include "firmware/child/scan_answer.hpp"
#include "firmware/child/scan_request.hpp"
#include "firmware/pictures/job_pictures.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/progress.hpp"

namespace plumbline::firmware {

/// What the child has done so far. It may hold anything.
struct ChildProgress {
  std::atomic<std::uint32_t> beats = 0;     ///< changes as long as the child works
  std::atomic<std::uint32_t> stage = 0;     ///< a Stage
  std::atomic<std::uint32_t> permille = 0;  ///< of that stage
  static_assert(std::atomic<std::uint32_t>::is_always_lock_free, "a lock can't be shared with a process that may die");
};

struct MessagePage {
  ScanRequest request;         ///< the firmware's, from before the child starts
  ChildProgress progress;      ///< the child's, while it runs
  ScanAnswer answer;           ///< the child's, complete when it has exited
  SlicedPictures pictures;     ///< the child's; no byte of their pixels is invalid
  ProposalPictures proposals;  ///< the same
  ScanPicture glance;          ///< the same
};

/// Every process forked from this one shares it, at the same address. A page takes no memory until it is touched.
class SharedMemory {
 public:
  static constexpr std::size_t kPage = 65536;  ///< bytes: the largest page of any board

  /// @retval ErrorCode::kOutOfMemory  the kernel gives no address space for it
  [[nodiscard]] static Expected<SharedMemory> create(std::size_t arena_bytes);

  MessagePage& page() const { return *reinterpret_cast<MessagePage*>(block_.get()); }
  std::span<std::byte> arena() const { return {block_.get() + kArenaAt, arena_bytes_}; }

 private:
  static constexpr std::size_t kArenaAt = (sizeof(MessagePage) + kPage - 1) / kPage * kPage;

  struct Unmap {
    std::size_t bytes = 0;
    void operator()(std::byte* block) const;
  };
  SharedMemory(std::byte* block, std::size_t arena_bytes);

  std::unique_ptr<std::byte, Unmap> block_;
  std::size_t arena_bytes_;
};

}  // namespace plumbline::firmware
