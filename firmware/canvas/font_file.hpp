#pragma once
/// The font of all texts: DejaVu Sans Condensed, whose tall small letters are legible from afar. Its files are part of the program, so
/// that a printer needs no fonts and a process without rights opens none.

#include <cstdint>
#include <span>

namespace plumbline::firmware::inline canvas {

enum class FontWeight : std::uint8_t { kRegular, kBold };

/// A TrueType file.
std::span<const std::uint8_t> font_file(FontWeight weight);

}  // namespace plumbline::firmware::inline canvas
