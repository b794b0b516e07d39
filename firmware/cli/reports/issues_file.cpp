#include "firmware/cli/reports/issues_file.hpp"

#include "firmware/io/output_file.hpp"
#include "firmware/pictures/preview/preview.hpp"

namespace plumbline::firmware {
namespace {

/// @param draw  called with the pixels of a page
template <class Draw>
Status write(const std::string& path, const StackFindings& findings, Arena& arena, Draw draw) {
  if (path.empty() || ShownIssues(findings).count == 0) return {};
  auto encoder = PictureEncoder::create(kPageBytes);
  PLUMBLINE_TRY(encoder);
  const auto png = encode_page(arena, *encoder, draw);
  PLUMBLINE_TRY(png);
  return write_file(path.c_str(), *png);
}

}  // namespace

Status write_issues_file(const std::string& path, const CheckedMasks& masks, MaskOf mask, Arena& arena) {
  return write(path, masks.findings, arena, [&](std::span<std::uint8_t> rgb) {
    return draw_issues(masks.findings, masks.grid, masks.name, mask, arena, rgb);
  });
}

Status write_issues_file(const std::string& path, const CheckedMasks& masks, const RRep& rrep, const Supports& supports,
                         Arena& arena) {
  return write(path, masks.findings, arena, [&](std::span<std::uint8_t> rgb) {
    return draw_issues(masks.findings, rrep, supports, masks.name, arena, rgb);
  });
}

}  // namespace plumbline::firmware
