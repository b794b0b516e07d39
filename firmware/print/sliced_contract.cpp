#include "firmware/print/sliced_contract.hpp"

#include "slicer/rrep/mask_extent.hpp"

namespace plumbline {
namespace {

ContractSubject subject(const PrintGrid& grid, const MaskExtent& extent, const StackFindings& findings) {
  ContractSubject about{
      .grid = grid, .cured_pixels = findings.voxels, .first_layer_pixels = findings.first_layer_pixels};
  if (!extent.empty()) {
    about.columns = extent.right - extent.left;
    about.rows = extent.bottom - extent.top;
  }
  return about;
}

}  // namespace

Expected<Contract> contract_of(const SlicedScan& sliced, const SliceSettings& settings, const PrintProfile& profile,
                               const MachineFile& machine) {
  ContractSubject about = subject(sliced.rrep.grid, extent_of(sliced.rrep), sliced.findings);
  const auto& degrees = settings.placement.rotation_degrees;
  about.rotation_deg = {degrees[0], degrees[1], degrees[2]};
  about.best_way_up = settings.orient;
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

}  // namespace plumbline
