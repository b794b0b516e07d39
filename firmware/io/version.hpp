#pragma once
/// The version of the programs, from CMake.

namespace plumbline::firmware {

inline constexpr const char* kVersion = PLUMBLINE_VERSION;

}  // namespace plumbline::firmware
