#include "firmware/child/shared_memory.hpp"

#include <sys/mman.h>

#include <cerrno>
#include <cstring>
#include <new>

namespace plumbline::firmware {

Expected<SharedMemory> SharedMemory::create(std::size_t arena_bytes) {
  void* const block = ::mmap(nullptr, kArenaAt + arena_bytes, PROT_READ | PROT_WRITE,
                             MAP_SHARED | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (block == MAP_FAILED) {
    return fail(ErrorCode::kOutOfMemory, "an arena of %zu MiB: %s.\tLower arena_mib in the board file",
                arena_bytes >> 20U, std::strerror(errno));
  }
  return SharedMemory(static_cast<std::byte*>(block), arena_bytes);
}

SharedMemory::SharedMemory(std::byte* block, std::size_t arena_bytes)
    : block_(block, Unmap{kArenaAt + arena_bytes}), arena_bytes_(arena_bytes) {
  ::new (block) MessagePage();
}

void SharedMemory::Unmap::operator()(std::byte* block) const { ::munmap(block, bytes); }

}  // namespace plumbline::firmware
