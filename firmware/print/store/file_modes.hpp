#pragma once

#include <sys/types.h>

namespace plumbline {

/// Of what the store keeps: everybody may read it, and only the daemon may write it.
constexpr mode_t kFileMode = 0644;
constexpr mode_t kFolderMode = 0755;

}  // namespace plumbline
