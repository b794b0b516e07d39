#pragma once
/// Counts in sentences.

#include <cstdint>

namespace plumbline::inline slicer {

/// What a noun gets after a count: "%u layer%s".
constexpr const char* plural_s(std::uint64_t count) { return count == 1 ? "" : "s"; }

}  // namespace plumbline::inline slicer
