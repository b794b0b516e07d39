#pragma once
/// The version of the programs, as CMake has it.

namespace plumbline {

inline constexpr const char* kVersion = PLUMBLINE_VERSION;

}  // namespace plumbline
