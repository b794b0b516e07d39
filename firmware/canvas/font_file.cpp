#include "firmware/canvas/font_file.hpp"

// PLUMBLINE_FONT_REGULAR and PLUMBLINE_FONT_BOLD are the paths that CMake has found. The labels are global because the assembler for
// aarch64 confuses local ones in the global offset table.
asm(R"(
  .pushsection .rodata
  .global kPlumblineFontRegular, kPlumblineFontBold, kPlumblineFontEnd
kPlumblineFontRegular:
  .incbin ")" PLUMBLINE_FONT_REGULAR R"("
kPlumblineFontBold:
  .incbin ")" PLUMBLINE_FONT_BOLD R"("
kPlumblineFontEnd:
  .byte 0
  .popsection
)");

extern "C" {
extern const std::uint8_t kPlumblineFontRegular[], kPlumblineFontBold[], kPlumblineFontEnd[];
}

namespace plumbline::firmware::inline canvas {

std::span<const std::uint8_t> font_file(FontWeight weight) {
  return weight == FontWeight::kBold ? std::span(&kPlumblineFontBold[0], &kPlumblineFontEnd[0])
                                     : std::span(&kPlumblineFontRegular[0], &kPlumblineFontBold[0]);
}

}  // namespace plumbline::firmware::inline canvas
