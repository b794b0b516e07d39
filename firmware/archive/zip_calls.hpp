#pragma once
/// How minizip reaches a file: by plain system calls on a descriptor, whose error is kept, or in memory.

#include <minizip/ioapi.h>

#include <cstddef>
#include <cstdint>
#include <span>

namespace plumbline::firmware::inline archive {

struct ZipHandle {
  int file = -1;                      ///< a descriptor; below 0: the file is in `memory`, and only read
  int reason = 0;                     ///< errno of the first call that failed; 0: none did
  std::span<const std::byte> memory;  ///< the whole file
  std::uint64_t at = 0;               ///< the place in it, or behind its end
};

/// @param handle  must outlive what uses the calls; closing the archive leaves its file open
zlib_filefunc64_def zip_calls(ZipHandle& handle);

}  // namespace plumbline::firmware::inline archive
