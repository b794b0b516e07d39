#include "firmware/print/job/printable.hpp"

#include <utility>

#include "firmware/slice/issue_report.hpp"
#include "slicer/core/words/printable_text.hpp"
#include "slicer/rrep/mask_extent.hpp"

namespace plumbline::firmware {
namespace {

ContractSubject subject(const PrintGrid& grid, const MaskExtent& extent, const StackFindings& findings) {
  ContractSubject about{
      .grid = grid, .cured_pixels = findings.voxels, .first_layer_pixels = findings.first_layer_pixels};
  if (!extent.empty()) {
    about.columns = extent.right - extent.left;
    about.left = extent.left;
    about.rows = extent.bottom - extent.top;
  }
  return about;
}

Printable printable(std::string_view name, std::string_view profile, const Contract& contract,
                    const StackFindings& findings, std::uint64_t hash) {
  Printable made;
  made.findings = findings;
  made.first_layer_pixels = findings.first_layer_pixels;
  made.facts.scan = short_name(PrintableText(name, made.facts.scan.size()).view());
  made.facts.profile = short_name(profile);
  made.facts.contract = contract;
  made.facts.cured_pixels = findings.voxels;
  made.facts.scan_hash = hash;
  return made;
}

}  // namespace

Expected<Contract> contract_of(const SlicedScan& sliced, const SliceSettings& settings, const PrintProfile& profile,
                               const MachineFile& machine) {
  ContractSubject about = subject(sliced.rrep.grid, extent_of(sliced.rrep), sliced.findings);
  const auto& degrees = settings.placement.rotation_degrees;
  about.rotation_deg = {degrees[0], degrees[1], degrees[2]};
  about.best_way_up = settings.orient;
  about.sizes = corrections_of(settings);
  about.steps = sliced.support_counts.steps;
  about.proof = sliced.proof;
  return make_contract(profile, machine, about);
}

Expected<Contract> contract_of(const SlicedArchive& sliced, const PrintProfile& profile, const MachineFile& machine) {
  ContractSubject about = subject(sliced.grid, sliced.extent, sliced.findings);
  about.is_archive = true;
  about.grey = sliced.grey.share();
  if (sliced.grey.lit > 0) {
    about.grey_lost = static_cast<double>(sliced.grey.lost) / static_cast<double>(sliced.grey.lit);
  }
  return make_contract(profile, machine, about);
}

Printable printable_of(const SlicedScan& sliced, std::string_view name, std::string_view profile,
                       const Contract& contract) {
  Printable made = printable(name, profile, contract, sliced.findings, sliced.scan_hash);
  made.parts = {sliced.rrep, sliced.supports, {}};
  made.support_counts = sliced.support_counts;
  made.support_pixels = sliced.support_pixels;
  return made;
}

Printable printable_of(const SlicedArchive& sliced, std::string_view name, std::string_view profile,
                       const Contract& contract, Descriptor file, std::uint64_t hash) {
  Printable made = printable(name, profile, contract, sliced.findings, hash);
  made.parts = {{.grid = sliced.grid, .first = {}, .packed = {}, .is_exact = true}, {}, sliced.layers};
  made.facts.turn = sliced.turn;
  made.archive = std::move(file);
  return made;
}

Expected<Printable> slice_printable(ScanSources scan, const SliceSettings& settings, const PrintProfile& profile,
                                    const MachineFile& machine, Arena& arena, ProgressSink* progress) {
  // Checks that don't depend on the height run before slicing, which may take minutes.
  const auto plan = plan_print(profile, machine, finest_layer_mm(profile), 1);
  PLUMBLINE_TRY(plan);
  PLUMBLINE_TRY(check_test(*plan));
  SliceReport report;
  const auto sliced = slice_for_print(scan, settings, arena, progress, report);
  PLUMBLINE_TRY(sliced);
  PLUMBLINE_TRY(judge(sliced->findings, sliced->rrep.grid, profile.checks));
  const auto contract = contract_of(*sliced, settings, profile, machine);
  PLUMBLINE_TRY(contract);
  Printable made = printable_of(*sliced, title_of(scan).c_str(), profile.name, *contract);
  for (const ByteSource* const file : scan) made.facts.add_file(file->name());
  made.slice = report;
  made.support_settings = settings.supports;
  return made;
}

}  // namespace plumbline::firmware
