#pragma once
/// The results of a job, for its manifest and its report.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/settings/check_policy.hpp"
#include "firmware/settings/print_profile.hpp"
#include "firmware/slice/size_corrections.hpp"
#include "slicer/checks/stack_findings.hpp"
#include "slicer/slicer.hpp"
#include "slicer/supports/support_finder.hpp"

namespace plumbline::firmware {

/// Sentences to read before printing.
struct JobWarnings {
  static constexpr std::size_t kMost = 24;
  std::array<Sentence, kMost> lines = {};
  std::size_t count = 0;

  Sentence& add() { return lines[count < kMost ? count++ : kMost - 1]; }
  std::span<const Sentence> all() const { return std::span(lines).first(count); }
};

struct JobReport {
  std::string scan_name;                         ///< title_of() its files
  std::vector<std::string> scan_names;           ///< of each file; empty for a print resumed from its store
  std::string printer_name;                      ///< empty without a printer
  BaseChoice base = BaseChoice::kAuto;           ///< as asked for
  SizeCorrections sizes;                         ///< that were asked for
  Grey grey = Grey::kOff;                        ///< which pixels of the masks may be grey
  SliceReport slice;                             ///< peaks of the arena: up to Stage::kRRep
  std::array<double, kStageCount> seconds = {};  ///< by Stage
  double preview_seconds = 0;
  double total_seconds = 0;
  std::size_t layers_peak_bytes = 0;   ///< of the arena, in Stage::kLayers
  std::size_t preview_peak_bytes = 0;  ///< of the arena
  std::size_t arena_bytes = 0;         ///< the budget
  std::uint32_t threads = 1;
  std::uint64_t cured_pixels = 0;                   ///< of all layers
  std::uint64_t support_pixels = 0;                 ///< those that supports add to the object
  std::optional<SupportSettings> support_settings;  ///< none: supports are off
  SupportCounts supports;
  std::uint64_t hash = 0;                    ///< job_hash()
  std::optional<ConfidenceShares> coverage;  ///< what the surface rests on; none: no map was kept
  std::optional<StackFindings> findings;     ///< of the masks; none: they were not checked
  CheckPolicy checks;                        ///< what happens when they have an issue
  bool draws_coverage = false;               ///< coverage.png is asked for
  bool has_preview = false;
  bool has_coverage = false;       ///< its picture
  bool has_issue_picture = false;  ///< issues.png
  JobWarnings warnings;

  /// mm^3 of resin that the masks cure, supports included.
  double volume_mm3() const;
  /// mm^3 of it in supports.
  double support_volume_mm3() const;
  /// Highest use of the arena in any stage, bytes.
  std::size_t peak_bytes() const;
  /// Highest use of the arena in `stage`, bytes.
  std::size_t peak_bytes(Stage stage) const;
  /// Share of the rays that were shot, 0 to 1.
  double share_of_rays(RayDecision decision) const;
};

/// Says which points the reader has dropped: "12 points dropped: not finite".
void for_each_dropped(const ScanSummary& scan, FunctionRef<void(const char*)> say);

/// Shares of the whole surface that the scanner did not see, 0 to 1: the one definition for reports, warnings and pictures.
struct Unseen {
  double underside = 0;  ///< closed flat by the base plane
  double elsewhere = 0;  ///< closed to fit its surroundings

  /// Smaller shares are edges and creases, where a cell of the map may hold no point by chance.
  static constexpr double kNegligible = 0.01;
  static Unseen of(const ConfidenceShares& shares) {
    return {shares.of(Evidence::kBase), shares.of(Evidence::kWinding)};
  }
  bool is_negligible() const { return underside <= kNegligible && elsewhere <= kNegligible; }
};

/// "the underside (12.6 % of the surface) and 4.1 % elsewhere were not scanned"; empty if both are negligible.
FixedText<128> unseen_sentence(const Unseen& unseen);

/// "87.4 % of the surface; closed: underside 12.6 %, elsewhere 0.0 %".
FixedText<96> scanned_text(const Unseen& unseen);

/// "39.85 x 30.08 x 59.30 mm, 1184 layers of 0.05 mm": the size of the placed object, without supports.
FixedText<96> size_text(const Placement& placement);

/// "on the plate, since its underside is flat; --support-stand raised lifts it by 5.8 mm": how the object stands with supports, and why.
FixedText<160> stand_text(const SupportSettings& settings, const SupportCounts& counts, double layer_height_mm);

/// Says that the unit asked for was ignored, and why.
Sentence ignored_units_warning(Units units);

/// "1042 triangles, closed".
FixedText<128> mesh_text(const MeshCounts& mesh);

/// "entering", "exiting", "neutral", "noise".
constexpr std::string_view to_string(PointClass point_class) {
  constexpr std::array<std::string_view, kPointClassCount> kWords = {"entering", "exiting", "neutral", "noise"};
  return kWords[static_cast<std::size_t>(point_class)];
}

/// "entering 46.2 %, exiting 31.0 %, neutral 22.1 %, noise 0.71 %".
FixedText<96> classes_text(const ClassCounts& points);

using RemarkVisit = FunctionRef<void(const Told& told, std::string_view sentence)>;
/// A sentence each for noise that was averaged, a floor and stray pieces that were left out, and normals that were flipped.
/// @param noise_mm  of the scan's points
void for_each_scan_remark(const PreparationReport& scan, double noise_mm, double mm_per_unit, RemarkVisit visit);
/// A sentence if the scan plainly lies wrong.
void remark_on_orientation(const PreparationReport& scan, RemarkVisit visit);
/// Both, and a sentence each for what else was left out or changed, and for a size that is not as asked for.
void for_each_remark(const SliceReport& slice, RemarkVisit visit);

/// Adds to report.warnings what a user should know before printing, issues of the masks included.
void find_warnings(JobReport& report);

}  // namespace plumbline::firmware
