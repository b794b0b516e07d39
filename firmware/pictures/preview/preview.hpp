#pragma once
/// The preview: the print from three sides, drawn from the R-Rep.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "firmware/pictures/png.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/drawing/supports.hpp"

namespace plumbline::firmware::inline pictures {

inline constexpr std::uint32_t kPreviewColumns = 1600;  ///< pixels
inline constexpr std::uint32_t kPreviewRows = 900;      ///< pixels
inline constexpr std::size_t kPageBytes = picture_bytes(kPreviewColumns, kPreviewRows);

/// Text on the picture, UTF-8. Lines that are too long are cut.
struct PreviewText {
  std::string_view name;                       ///< of the scan, top left
  std::string_view size;                       ///< of the object and its layers, top right
  std::span<const std::string_view> captions;  ///< lines at the bottom; the first kMaxPreviewCaptions are drawn
};
inline constexpr std::size_t kMaxPreviewCaptions = 3;

/// Bytes that draw_preview() takes from the top of the arena and releases.
std::size_t preview_bytes(const PrintGrid& grid);

namespace preview {
struct Paint;
}

/// Draws the object from the front (along +y), from the side (along +x) and from above (along -z), at one scale.
///
/// @param rrep      at least one layer; without crossings only the text is drawn
/// @param supports  drawn in another colour
/// @param arena     preview_bytes() are taken from its top and released
/// @param rgb       kPageBytes of the caller, row after row from the top; overwritten
/// @param paint     other colours; null: those of object and supports
/// @retval ErrorCode::kOutOfMemory  the arena has less than preview_bytes() left
[[nodiscard]] Status draw_preview(const RRep& rrep, const Supports& supports, const PreviewText& text, Arena& arena,
                                  std::span<std::uint8_t> rgb, const preview::Paint* paint = nullptr);

/// A page as a PNG file.
/// @param arena    kPageBytes is taken from its top and released
/// @param encoder  made for kPageBytes
/// @param draw     called with the page's kPageBytes
/// @returns the file, in the encoder's memory, valid until its next use
/// @retval ErrorCode::kOutOfMemory  the arena has no room, and any error of `draw`
template <class Draw>
[[nodiscard]] Expected<std::span<const std::byte>> encode_page(Arena& arena, PictureEncoder& encoder, Draw draw) {
  const ArenaScope scope(arena);
  const auto memory = arena.take_top<std::uint8_t>(kPageBytes, "page");
  PLUMBLINE_TRY(memory);
  PLUMBLINE_TRY(draw(*memory));
  return encoder.encode(*memory, kPreviewColumns, kPreviewRows);
}

}  // namespace plumbline::firmware::inline pictures
