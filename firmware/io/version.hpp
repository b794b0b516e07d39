#pragma once
/// The version of the programs, from CMake.

namespace plumbline {

inline constexpr const char* kVersion = PLUMBLINE_VERSION;

}  // namespace plumbline
