#pragma once
/// The outlines of the screen's font: DejaVu Sans Condensed, whose tall small letters are legible from afar.

#include <array>
#include <cstdint>
#include <span>

namespace plumbline {

enum class FontWeight : std::uint8_t { kRegular, kBold };

/// A point of a closed contour of straight lines and quadratic curves. It begins with a corner; between two corners lies at most one control
/// point.
struct OutlinePoint {
  static constexpr std::uint8_t kOnCurve = 1, kLastOfContour = 2;
  std::int16_t x, y;   ///< font units, y up from the baseline
  std::uint8_t flags;  ///< kOnCurve: a corner; otherwise a control point
};

struct GlyphOutline {
  std::uint16_t code;     ///< Unicode
  std::uint16_t advance;  ///< font units to the next character
  std::uint16_t first;    ///< index of its first point
  std::uint16_t count;    ///< points
};

struct FontOutlines {
  std::span<const OutlinePoint> points;
  std::span<const GlyphOutline> glyphs;  ///< by code
  std::int16_t x_height, cap_height;     ///< font units
};

const FontOutlines& font_outlines(FontWeight weight);

/// What is shown for a character that the font lacks.
inline constexpr std::uint16_t kUnknownCharacter = 0xFFFD;

}  // namespace plumbline
