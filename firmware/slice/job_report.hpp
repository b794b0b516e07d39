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
#include "slicer/checks/stack_findings.hpp"
#include "slicer/slicer.hpp"
#include "slicer/supports/support_finder.hpp"

namespace plumbline {

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

/// Why points were left out (ScanSummary::left_out): "the file marks them as invalid".
const char* why_left_out(ScanFormat format);

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

/// The sentence about stray pieces that were left out; empty if there were none.
Sentence stray_warning(const StrayPieces& strays);

/// Says that the unit asked for was ignored, and why.
Sentence ignored_units_warning(Units units);

/// The sentence about neighbours that were averaged; empty if they were not.
/// @param noise_mm  of the scan's points
Sentence averaged_warning(std::uint32_t averagings, double noise_mm);

/// The sentence about a floor that was cut off.
/// @param scale  mm per scan unit
Sentence floor_warning(const FloorCut& floor, double scale);

/// The sentence about normals that were flipped; empty if they are few, as those of flying pixels at edges.
/// @param points  of the cloud
Sentence turned_warning(const NormalCounts& normals, std::uint32_t points);

/// "1042 triangles, closed".
FixedText<128> mesh_text(const MeshCounts& mesh);

/// Whether the scan shows one side only, and that side faces down.
bool lies_on_its_face(const ClusteringCounts& clustering);
inline constexpr const char* kOnItsFaceText =
    "the scan shows one side only, which faces down, so most of it can't be closed";

using RemarkVisit = FunctionRef<void(const Told& told, std::string_view sentence)>;
/// A sentence each for what was left out of the scan, what was changed in it, and a bad orientation.
void for_each_remark(const SliceReport& slice, RemarkVisit visit);

/// Adds to report.warnings what a user should know before printing, issues of the masks included.
void find_warnings(JobReport& report);

}  // namespace plumbline
