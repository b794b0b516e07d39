#pragma once

#include <cstdint>

namespace plumbline::inline slicer {

/// Bytes in MiB, for messages.
constexpr double mib(std::uint64_t bytes) { return static_cast<double>(bytes) / (1024.0 * 1024.0); }

}  // namespace plumbline::inline slicer
