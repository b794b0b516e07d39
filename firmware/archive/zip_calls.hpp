#pragma once
/// How minizip reaches a file: by plain system calls on a descriptor, whose error is kept.

#include <minizip/ioapi.h>

namespace plumbline {

struct ZipHandle {
  int file = -1;   ///< a descriptor
  int reason = 0;  ///< errno of the first call that failed; 0: none did
};

/// @param handle  must outlive what uses the calls; closing the archive leaves its file open
zlib_filefunc64_def zip_calls(ZipHandle& handle);

}  // namespace plumbline
