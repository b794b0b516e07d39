#pragma once
/// Shared by all pictures: background, ink and faces.

#include <array>
#include <cstdint>

#include "firmware/pictures/preview/picture.hpp"

namespace plumbline::firmware::inline pictures::preview {

inline constexpr Rgb kInk{236, 232, 224}, kPaleInk{158, 168, 180};
/// Of the object and of its supports.
inline constexpr std::array<Rgb, 2> kMaterials{{{255, 243, 222}, {122, 178, 214}}};

inline constexpr std::uint8_t kOfSupports = 1;

/// Fills the page with a grey that darkens upwards.
void draw_background(const Picture& picture);

struct PageFaces {
  Face plain{FontWeight::kRegular, 11};
  Face title{FontWeight::kRegular, 21};
};
/// Made by the first call, which takes their memory from the heap.
const PageFaces& page_faces();

}  // namespace plumbline::firmware::inline pictures::preview
