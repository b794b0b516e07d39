#include "firmware/child/answer_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "firmware/messages/printer_code.hpp"
#include "slicer/placement/placement.hpp"

namespace plumbline::firmware {
namespace {

tl::unexpected<Error> wrong(const char* what) {
  return fail(ErrorCode::kMalformed, "what was read of it does not add up (%s).\t%s", what, kExportAgain);
}

/// The text up to its NUL, or to the end of its array.
std::string_view text_of(std::span<const char> text) {
  return {text.data(), static_cast<std::size_t>(std::find(text.begin(), text.end(), '\0') - text.begin())};
}

/// The errors that a scan can cause. The child must not say that the lamp is stuck on.
constexpr std::array kScanErrors = {ErrorCode::kCannotRead,  ErrorCode::kUnknownFormat, ErrorCode::kMalformed,
                                    ErrorCode::kTruncated,   ErrorCode::kNoPoints,      ErrorCode::kUnsupported,
                                    ErrorCode::kOutOfMemory, ErrorCode::kDoesNotFit,    ErrorCode::kBadSetting,
                                    ErrorCode::kNoSurface};

/// `count` objects at byte `at` of the child's result; empty if they don't lie in it.
template <class T>
std::span<const T> part_of(std::span<const std::byte> result, std::uint64_t at, std::uint64_t count) {
  if (at % alignof(T) != 0 || at > result.size() || count > (result.size() - at) / sizeof(T)) return {};
  return {reinterpret_cast<const T*>(result.data() + at), static_cast<std::size_t>(count)};
}

/// Whether the crossings are those of an RRep: see there.
bool is_rrep(const RRep& rrep) {
  const std::uint32_t pixels = rrep.grid.columns * rrep.grid.rows;  // at most 2^28
  const CrossingPacking packing(rrep.grid);
  if (rrep.first.front() != 0 || rrep.first.back() != rrep.packed.size()) return false;
  for (std::size_t layer = 0; layer < rrep.grid.layers; ++layer) {
    const std::uint32_t begin = rrep.first[layer];
    const std::uint32_t end = rrep.first[layer + 1];
    if (begin > end || end > rrep.packed.size()) return false;
    std::uint32_t least = 0;
    for (const std::uint32_t packed : rrep.packed.subspan(begin, end - begin)) {
      const std::uint32_t pixel = packing.pixel(packed);
      if (pixel < least || pixel >= pixels) return false;
      least = pixel + 1;
    }
  }
  return true;
}

bool are_supports(std::span<const Strut> supports, const PrintGrid& grid) {
  std::uint16_t first = 0;
  for (const Strut& strut : supports) {
    const bool on_the_grid = std::max(strut.column0, strut.column1) < grid.columns &&
                             std::max(strut.row0, strut.row1) < grid.rows && strut.end <= grid.layers;
    if (!on_the_grid || strut.first < first || strut.end < strut.first) return false;
    if (static_cast<std::uint32_t>(strut.kind) >= kStrutKinds || strut.lies > 1) return false;
    first = strut.first;
  }
  return true;
}

/// Whether the findings can be those of a stack with this grid.
bool are_findings(const StackFindings& findings, const PrintGrid& grid) {
  const std::uint64_t pixels = std::uint64_t{grid.columns} * grid.rows;
  const std::uint64_t voxels = pixels * grid.layers;
  const bool figures =
      findings.layers == grid.layers && findings.unchecked_layers <= grid.layers && findings.voxels <= voxels &&
      findings.shadowed_voxels <= voxels && findings.first_layer_pixels <= pixels && findings.peel_pixels <= pixels &&
      findings.peel_layer < grid.layers && findings.jump_pixels <= pixels && findings.jump_layer < grid.layers;
  if (!figures) return false;
  for (std::size_t i = 0; i < kIssueKindCount; ++i) {
    const IssueGroup& group = findings.groups[i];
    if (group.kept_count > IssueGroup::kKept || group.kept_count > group.count) return false;
    if (group.minor > group.count) return false;
    if ((group.kept_count == 0) != (group.count == 0)) return false;
    if (group.pixels > voxels || group.voxels > voxels) return false;
    for (const Issue& issue : group.all_kept()) {
      const bool here = issue.kind == static_cast<IssueKind>(i) && issue.column < grid.columns && issue.row < grid.rows;
      const bool layers =
          issue.first_layer <= issue.layer && issue.layer <= issue.last_layer && issue.last_layer < grid.layers;
      const auto is_force = [](float newtons) { return newtons >= 0 && newtons <= 1e12F; };
      if (!is_force(issue.asked_n) || !is_force(issue.held_n)) return false;
      if (!here || !layers || issue.pixels > group.pixels || issue.voxels > group.voxels) return false;
    }
  }
  return true;
}

bool is_proof(const PointProof& proof) {
  return proof.points <= kMostProofPoints &&
         std::max({proof.within_pixel, proof.within_layer, proof.off}) <= proof.points && proof.reach_mm >= 0 &&
         proof.reach_mm <= 1e6F;
}

}  // namespace

tl::unexpected<Error> child_error(const ScanAnswer& answer, std::span<const ErrorCode> possible) {
  const auto text = text_of(answer.message);
  const auto code = std::find_if(possible.begin(), possible.end(),
                                 [&answer](ErrorCode one) { return static_cast<std::uint32_t>(one) == answer.code; });
  if (code == possible.end() || text.empty()) return wrong("its error");
  if (!is_valid(answer.told)) return wrong("what its error tells");
  const auto at = std::min<std::size_t>(answer.advice_at, text.size());
  if (at == 0) return telling(answer.told, fail(*code, "%.*s", static_cast<int>(text.size()), text.data()));
  return telling(answer.told, fail(*code, "%.*s\t%.*s", static_cast<int>(at - 1), text.data(),
                                   static_cast<int>(text.size() - at), text.data() + at));
}

Expected<CheckedAnswer> check_answer(const ScanAnswer& answer, const ScanRequest& request, Arena& arena) {
  if (answer.kind == ScanAnswer::kRefused) return child_error(answer, kScanErrors);
  if (answer.kind != ScanAnswer::kSliced) return wrong("no answer");
  // The grid is the printer's. Of its layers only the number is the child's.
  const PlacementSettings& placement = request.settings.placement;
  PrintGrid grid = panel_grid(*placement.printer, placement.layer_height_mm);
  if (answer.layers == 0 || answer.layers > grid.layers) return wrong("layers");
  grid.layers = answer.layers;
  if (answer.bottom_used > arena.available()) return wrong("memory");
  const auto result = arena.take_bottom<std::byte>(static_cast<std::size_t>(answer.bottom_used), "r-rep");
  PLUMBLINE_TRY(result);

  CheckedAnswer checked;
  SlicedScan& sliced = checked.sliced;
  const std::uint64_t layer_ends = std::uint64_t{grid.layers} + 1;
  sliced.rrep = {.grid = grid,
                 .first = part_of<std::uint32_t>(*result, answer.first_at, layer_ends),
                 .packed = part_of<std::uint32_t>(*result, answer.packed_at, answer.crossings),
                 .is_exact = answer.is_exact != 0};
  if (sliced.rrep.first.size() != layer_ends || sliced.rrep.packed.size() != answer.crossings) return wrong("places");
  if (!is_rrep(sliced.rrep)) return wrong("crossings");
  if (!answer.steps.valid() || answer.steps.all_one() == request.settings.adaptive.wanted() ||
      answer.steps.layers(grid.layers) == 0) {
    return wrong("heights of the layers");
  }
  sliced.support_counts.steps = answer.steps;
  if (rays_for(request.settings.grey) > 1) {
    const auto others = arena.take_bottom<RRep>(answer.other_rays.size(), "r-rep");
    PLUMBLINE_TRY(others);
    for (std::uint32_t i = 0; i < others->size(); ++i) {
      const ScanAnswer::Ray& ray = answer.other_rays[i];
      RRep& other = (*others)[i] = {.grid = with_ray(grid, i + 1),
                                    .first = part_of<std::uint32_t>(*result, ray.first_at, layer_ends),
                                    .packed = part_of<std::uint32_t>(*result, ray.packed_at, ray.crossings),
                                    .is_exact = answer.is_exact != 0};
      if (other.first.size() != layer_ends || other.packed.size() != ray.crossings) return wrong("places");
      if (!is_rrep(other)) return wrong("crossings");
    }
    sliced.rrep.others = others->data();
  }

  if (answer.supports > 0) {
    if (!request.settings.supports || answer.supports > most_struts(grid)) return wrong("number of supports");
    sliced.supports = {.list = part_of<Strut>(*result, answer.supports_at, answer.supports), .pitch = PixelPitch(grid)};
    if (sliced.supports.list.size() != answer.supports) return wrong("place of the supports");
    if (!are_supports(sliced.supports.list, grid)) return wrong("supports");
  }

  if (!are_findings(answer.findings, grid)) return wrong("findings");
  sliced.scan_hash = answer.scan_hash;
  sliced.findings = answer.findings;
  if (!is_proof(answer.proof)) return wrong("proof");
  sliced.proof = answer.proof;

  if (answer.remarks > ScanAnswer::kMostRemarks) return wrong("remarks");
  for (std::size_t i = 0; i < answer.remarks; ++i) {
    const auto text = text_of(answer.remark[i]);
    if (!is_valid(answer.remark_told[i])) return wrong("what a remark tells");
    checked.remark_told[i] = answer.remark_told[i];
    checked.remark[checked.remarks++].add("%.*s", static_cast<int>(text.size()), text.data());
  }
  return checked;
}

Expected<SlicedArchive> check_archive_answer(const ScanAnswer& answer, const ScanRequest& request, Arena& arena) {
  if (answer.kind == ScanAnswer::kRefused) return child_error(answer, kScanErrors);
  if (answer.kind != ScanAnswer::kArchive) return wrong("no answer");
  const auto is_within = [](double value, double low, double high) { return value >= low && value <= high; };
  if (!is_within(answer.layer_height_mm, 0.005, 1)) return wrong("layer height");
  SlicedArchive sliced;
  sliced.grid = panel_grid(*request.settings.placement.printer, static_cast<float>(answer.layer_height_mm));
  if (answer.layers == 0 || answer.layers > sliced.grid.layers) return wrong("layers");
  sliced.grid.layers = answer.layers;
  if (answer.bottom_used > arena.available()) return wrong("memory");
  const auto result = arena.take_bottom<std::byte>(static_cast<std::size_t>(answer.bottom_used), "layers");
  PLUMBLINE_TRY(result);
  sliced.layers = part_of<ArchiveLayer>(*result, answer.archive_at, answer.layers);
  sliced.layers_end = arena.bottom_mark();
  if (sliced.layers.size() != answer.layers) return wrong("places");
  if (!are_findings(answer.findings, sliced.grid)) return wrong("findings");
  sliced.findings = answer.findings;
  sliced.turn = {answer.turn[0] != 0, answer.turn[1] != 0, answer.turn[2] != 0};
  sliced.turned = answer.turned != 0;
  const std::uint64_t voxels = std::uint64_t{sliced.grid.columns} * sliced.grid.rows * sliced.grid.layers;
  sliced.grey = {answer.grey[0], answer.grey[1], answer.grey[2]};
  const GreyShare& grey = sliced.grey;
  if (grey.lit > voxels || grey.grey > grey.lit || grey.lost > grey.grey) return wrong("grey");
  sliced.extent = {answer.extent[0], answer.extent[1], answer.extent[2], answer.extent[3]};
  const MaskExtent& extent = sliced.extent;
  const bool inside = extent.right <= sliced.grid.columns && extent.bottom <= sliced.grid.rows &&
                      (extent.empty() || extent.top < extent.bottom);
  if (!inside) return wrong("extent");
  if (const PrintField* const field = receive(answer.values, sliced.settings.values)) return wrong(field->name.data());
  return sliced;
}

Status take_checked_greys(std::span<const GreyRun> runs, std::uint64_t count, std::uint32_t columns, std::uint32_t rows,
                          GreyRuns& greys) {
  greys.clear();
  if (count > runs.size()) return wrong("number of grey pixels");
  const std::uint64_t pixels = std::uint64_t{columns} * rows;
  std::uint64_t least = 0;
  for (const GreyRun& run : runs.first(static_cast<std::size_t>(count))) {
    const bool inside = run.count > 0 && run.pixel < pixels && run.pixel % columns + run.count <= columns;
    if (!inside || run.pixel < least || !is_grey(run.level)) return wrong("grey pixels");
    least = std::uint64_t{run.pixel} + run.count;
    greys.add(run);
  }
  return {};
}

Expected<Proposals> check_proposals(const ScanAnswer& answer) {
  if (answer.kind == ScanAnswer::kRefused) return child_error(answer, kScanErrors);
  if (answer.kind != ScanAnswer::kProposals) return wrong("no answer");
  constexpr double kMost = 1e30;  // a scan in another unit can be far too large for the printer
  for (const Proposal& way : answer.proposals) {
    for (const double degrees : way.degrees) {
      if (!(std::abs(degrees) <= 360)) return wrong("angles");
    }
    for (const double figure : {way.cost, way.support_mm2, way.support_mm3, way.peel_mm2, way.height_mm, way.scar_mm2,
                                way.tip_scars_mm2, way.supports_mm3}) {
      if (!(figure >= 0 && figure <= kMost)) return wrong("figures");
    }
  }
  return answer.proposals;
}

}  // namespace plumbline::firmware
