#pragma once
/// Shared by all pictures: background, ink, and cutting text to a width.

#include <array>
#include <cstdint>
#include <string_view>

#include "firmware/pictures/preview/preview_font.hpp"

namespace plumbline::preview {

inline constexpr Rgb kInk{236, 232, 224}, kPaleInk{158, 168, 180};
/// Of the object and of its supports.
inline constexpr std::array<Rgb, 2> kMaterials{{{255, 243, 222}, {122, 178, 214}}};

/// Fills the page with a grey that darkens upwards.
void draw_background(const Picture& picture);

/// The start of a text that fits into `pixels`.
std::string_view cut(std::string_view text, std::uint32_t pixels, const LabelStyle& style);

}  // namespace plumbline::preview
