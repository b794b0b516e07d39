#include "firmware/slice/job_report.hpp"

#include <algorithm>

namespace plumbline {
namespace {

constexpr double kSmallestUsual = 5;      ///< mm, longest side of what people print
constexpr double kLargestUsual = 500;     ///< mm
constexpr double kRaysByEvidence = 0.01;  ///< share of rays above which a hole in the scan is worth a word

double voxel_mm3(const PrintGrid& grid) {
  return static_cast<double>(grid.pitch_x_mm) * static_cast<double>(grid.pitch_y_mm) *
         static_cast<double>(grid.layer_height_mm);
}

}  // namespace

double JobReport::volume_mm3() const { return static_cast<double>(cured_pixels) * voxel_mm3(slice.placement.grid); }

double JobReport::support_volume_mm3() const {
  return static_cast<double>(support_pixels) * voxel_mm3(slice.placement.grid);
}

std::size_t JobReport::peak_bytes(Stage stage) const {
  return stage == Stage::kLayers ? layers_peak_bytes : slice.peak_bytes[static_cast<std::size_t>(stage)];
}

std::size_t JobReport::peak_bytes() const {
  return std::max(
      {*std::max_element(slice.peak_bytes.begin(), slice.peak_bytes.end()), layers_peak_bytes, preview_peak_bytes});
}

double JobReport::share_of_rays(RayDecision decision) const {
  const auto shot = static_cast<double>(slice.rays.interested);
  return shot > 0 ? static_cast<double>(slice.rays.decided[static_cast<std::size_t>(decision)]) / shot : 0;
}

const char* to_string(ScanFormat format) {
  switch (format) {
    case ScanFormat::kPly: return "PLY";
    case ScanFormat::kXyz: return "XYZ";
    case ScanFormat::kPcd: return "PCD";
    case ScanFormat::kObj: return "OBJ";
  }
  return "unknown";
}

FixedText<256> stray_warning(const StrayPieces& strays) {
  FixedText<256> text;
  if (strays.pieces == 0) return text;
  const bool one = strays.pieces == 1;
  text.add(
      "%u stray piece%s left out: %u points, %.2g %% of the scan's surface, apart from the object. --keep-all keeps %s",
      strays.pieces, one ? " was" : "s were", strays.points, 100 * static_cast<double>(strays.share),
      one ? "it" : "them");
  return text;
}

double turned_share(std::uint32_t turned, std::uint32_t points) {
  return points > 0 ? static_cast<double>(turned) / points : 0;
}

bool lies_on_its_face(const ClusteringResult& clustering) {
  return hardly_any(clustering, PointClass::kExiting) && !hardly_any(clustering, PointClass::kEntering);
}

void for_each_remark(const SliceReport& slice, FunctionRef<void(std::string_view)> tell) {
  if (slice.strays.pieces > 0) tell(stray_warning(slice.strays).view());
  FixedText<256> text;
  const double turned = turned_share(slice.normals.turned, slice.cloud_points);
  if (turned > kTurnedWorthAWord) {
    text.add("%.2g %% of the normals pointed into the object and were turned over", 100 * turned);
    tell(text.view());
  }
  if (slice.components.floating_solids > 0) {
    text = {};
    const bool one = slice.components.floating_solids == 1;
    text.add("%u small solid%s neither the object nor the plate %s left out. --keep-all keeps %s",
             slice.components.floating_solids, one ? " that touches" : "s that touch", one ? "was" : "were",
             one ? "it" : "them");
    tell(text.view());
  }
  if (slice.components.sealed_cavities > 0) {
    text = {};
    const bool one = slice.components.sealed_cavities == 1;
    text.add("%u small hollow%s inside the object, into which no scanner can have seen, %s filled. --keep-all keeps %s",
             slice.components.sealed_cavities, one ? "" : "s", one ? "was" : "were", one ? "it" : "them");
    tell(text.view());
  }
  if (lies_on_its_face(slice.clustering)) tell(kOnItsFace);
}

void find_warnings(JobReport& report) {
  const SliceReport& s = report.slice;
  const PrintGrid& grid = s.placement.grid;
  const double longest = s.placement.size_mm.maxCoeff();
  if (s.units_guessed) {
    report.warnings.add().add(
        "units guessed: the scan is %.4g units long, %s make that %.4g mm. Say --units %s to be sure, or another one",
        longest / s.placement.scale, to_string(s.units), longest, to_string(s.units));
  }
  if (longest < kSmallestUsual) {
    report.warnings.add().add("the object is only %.3g mm long. If that is wrong, say --units m, cm or in, or --scale",
                              longest);
  } else if (longest > kLargestUsual) {
    report.warnings.add().add(
        "the object is %.4g mm long. If that is wrong, say --units, --scale, or --fit with --printer", longest);
  }
  const auto pitch = static_cast<double>(std::min(grid.pitch_x_mm, grid.pitch_y_mm));
  if (s.thinning_cell_mm > pitch) {
    report.warnings.add().add(
        "points were averaged in cells of %.3g mm, coarser than the pixels of %.3g mm: the arena has room for %u "
        "points. "
        "A larger --arena-mib keeps more detail",
        s.thinning_cell_mm, pitch, s.cloud_capacity);
  }
  if (report.share_of_rays(RayDecision::kBase) > kRaysByEvidence) {
    report.warnings.add().add(
        "the underside is open over %.1f %% of the rays: closed flat at z = 0 mm of the print (z = %.4g of the scan)",
        100 * report.share_of_rays(RayDecision::kBase), s.placement.origin_in_scan()[2]);
  }
  if (report.share_of_rays(RayDecision::kWinding) > kRaysByEvidence) {
    report.warnings.add().add(
        "the scan has holes: for %.1f %% of the rays the winding number of all points decided what is inside. Look at "
        "confidence.png",
        100 * report.share_of_rays(RayDecision::kWinding));
  }
  for_each_remark(s, [&](std::string_view warning) {
    report.warnings.add().add("%.*s", static_cast<int>(warning.size()), warning.data());
  });
  if (s.components.counted && s.components.solids > 1 && !report.support_settings) {
    report.warnings.add().add(
        "the object is %u separate pieces; those that do not stand on the plate need supports: --supports auto",
        s.components.solids);
  }
  if (s.normals.estimated > 0) {
    report.warnings.add().add("%u points have no normal in the scan; theirs were estimated from their neighbours",
                              s.normals.estimated);
  }
}

}  // namespace plumbline
