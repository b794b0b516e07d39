#pragma once

#include <cstddef>
#include <cstdint>

namespace plumbline {

/// Of the printer's screen.
enum class Language : std::uint8_t { kEnglish, kGerman };
inline constexpr std::size_t kLanguageCount = 2;

}  // namespace plumbline
