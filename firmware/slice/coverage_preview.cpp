#include "firmware/slice/coverage_preview.hpp"

#include <algorithm>

#include "firmware/io/output_file.hpp"
#include "firmware/pictures/coverage_picture.hpp"
#include "firmware/pictures/preview/preview.hpp"
#include "firmware/slice/job_report.hpp"

namespace plumbline::firmware {
namespace {

/// Share of rays without solid above which a scan encloses nothing. A few percent of the rays pass beside any object, while
/// nearly all miss a sheet that was scanned from one side; the value only has to lie between the two.
constexpr double kNoObject = 0.5;

Status draw(const RRep& rrep, const ConfidenceMap& map, std::string_view name, const std::string& path, Arena& arena) {
  auto encoder = PictureEncoder::create(kPageBytes);
  PLUMBLINE_TRY(encoder);
  const auto png = encode_page(arena, *encoder,
                               [&](std::span<std::uint8_t> rgb) { return draw_coverage(rrep, map, name, arena, rgb); });
  PLUMBLINE_TRY(png);
  return write_file(path.c_str(), *png);
}

}  // namespace

bool CoveragePreview::underside_unseen() const {
  return on_base_plane && Unseen::of(shares).underside > Unseen::kNegligible;
}

FixedText<128> CoveragePreview::sentence() const {
  FixedText<128> text;
  if (outside > kNoObject) {
    text.add("%.0f %% of the scan encloses nothing: its other side was not scanned, or its normals are wrong",
             100 * outside);
    return text;
  }
  text = unseen_sentence(Unseen::of(shares));
  return text;
}

Expected<CoveragePreview> preview_coverage(const RRep& rrep, const SliceReport& report, std::string_view name,
                                           const std::string& picture, Arena& arena) {
  if (!picture.empty()) PLUMBLINE_TRY(draw(rrep, report.confidence, name, picture, arena));
  const auto outside = static_cast<double>(report.rays.decided[static_cast<std::size_t>(RayDecision::kOutside)]);
  const auto shot = static_cast<double>(std::max<std::uint64_t>(1, report.rays.interested()));
  return CoveragePreview{report.confidence.shares(), report.flat_underside, outside / shot};
}

}  // namespace plumbline::firmware
