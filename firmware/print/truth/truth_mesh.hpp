#pragma once
/// A mesh of the true surface, in the coordinates of the scan.

#include <string>
#include <vector>

#include "firmware/print/truth/true_surface.hpp"
#include "slicer/core/error.hpp"
#include "slicer/placement/placement.hpp"
#include "slicer/reader/triangles/triangle.hpp"

namespace plumbline::firmware {

class TruthMesh {
 public:
  /// Reads a mesh of any format that plumbline reads. If it is inside out it is turned over.
  /// @retval ErrorCode::kBadSetting  it has no triangles, it is not closed, or it has negative volumes
  /// @retval the errors of FileSource::open() and read_mesh()
  [[nodiscard]] static Expected<TruthMesh> read(const std::string& path);

  /// Spreads 50,000 points evenly over the surface, always the same ones.
  TrueSurface surface(const Placement& placement) const;

 private:
  std::string name_;
  std::vector<Triangle> triangles_;
};

}  // namespace plumbline::firmware
