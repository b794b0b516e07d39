#include "slicer/core/progress.hpp"

namespace plumbline::inline slicer {

std::string_view to_string(Stage stage) {
  switch (stage) {
    case Stage::kRead: return "read";
    case Stage::kNormals: return "normals";
    case Stage::kTrees: return "trees";
    case Stage::kViews: return "views";
    case Stage::kClustering: return "clustering";
    case Stage::kWindingTree: return "winding";
    case Stage::kRayGrid: return "ray grid";
    case Stage::kRays: return "rays";
    case Stage::kRRep: return "r-rep";
    case Stage::kSupports: return "supports";
    case Stage::kLayers: return "layers";
  }
  return "unknown";
}

}  // namespace plumbline::inline slicer
