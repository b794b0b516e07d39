#pragma once
/// What the pages of all pictures have in common.

#include <cstdint>
#include <string_view>

#include "firmware/pictures/preview_font.hpp"

namespace plumbline::preview {

inline constexpr Colour kInk{236, 232, 224}, kPaleInk{158, 168, 180};

/// A sky that darkens upwards.
void draw_background(const Picture& picture);

/// The part of a text that fits into `pixels`.
std::string_view cut(std::string_view text, std::uint32_t pixels, const TextStyle& style);

}  // namespace plumbline::preview
