#include "firmware/cli/reports/issues_file.hpp"

#include "firmware/io/output_file.hpp"
#include "firmware/pictures/preview/preview.hpp"

namespace plumbline {
namespace {

/// @param encode  takes an encoder and returns a file of no or some bytes
template <class Encode>
Status write(const std::string& path, Encode encode) {
  if (path.empty()) return {};
  auto encoder = PngEncoder::for_pictures(kPreviewColumns, kPreviewRows);
  PLUMBLINE_TRY(encoder);
  const auto png = encode(*encoder);
  PLUMBLINE_TRY(png);
  return png->empty() ? Status() : write_file(path.c_str(), *png);
}

}  // namespace

Status write_issues_file(const std::string& path, const CheckedMasks& masks, MaskOf mask, Arena& arena) {
  return write(path, [&](PngEncoder& encoder) {
    return encode_issues(masks.findings, masks.grid, masks.name, mask, arena, encoder);
  });
}

Status write_issues_file(const std::string& path, const CheckedMasks& masks, const RRep& rrep, const Supports& supports,
                         Arena& arena) {
  return write(path, [&](PngEncoder& encoder) {
    return encode_issues(masks.findings, rrep, supports, masks.name, arena, encoder);
  });
}

}  // namespace plumbline
