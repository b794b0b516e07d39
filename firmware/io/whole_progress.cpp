#include "firmware/io/whole_progress.hpp"

#include <algorithm>

namespace plumbline::firmware {
namespace {

struct Weight {
  Stage stage;
  double weight;
};

/// In the order of the work. Percent of the time without the layers: mean of the sample bust and the raw Stanford bunny and dragon,
/// 40 to 60 mm high, layers of 0.05 mm, two threads on x86-64. The views of a scan may need more.
constexpr Weight kWeights[] = {
    {Stage::kRead, 2},        {Stage::kTrees, 4},   {Stage::kNormals, 6}, {Stage::kViews, 5}, {Stage::kClustering, 11},
    {Stage::kWindingTree, 2}, {Stage::kRayGrid, 1}, {Stage::kRays, 52},   {Stage::kRRep, 8},  {Stage::kSupports, 9},
};
constexpr double kLayersWritten = 85;  ///< of the same unit: with their PNG files
constexpr double kLayersChecked = 15;

}  // namespace

double WholeProgress::reach(Stage stage, double fraction) {
  if (!begun_ || stage != stage_) {
    double own = 0, rest = 0;  // weights of this stage, and of it and all that may follow
    const auto add = [&](Stage one, double weight) {
      if (one == stage) own = weight;
      if (own > 0) rest += weight;
    };
    for (const auto& [one, weight] : kWeights) {
      add(one, weight);
      if (one == last_) break;
    }
    if (last_ == Stage::kLayers) add(last_, writes_ ? kLayersWritten : kLayersChecked);
    from_ = to_;
    to_ = own < rest ? from_ + (1 - from_) * own / rest : 1;
    stage_ = stage;
    begun_ = true;
  }
  reached_ = std::clamp(from_ + (to_ - from_) * fraction, reached_, to_);
  return reached_;
}

}  // namespace plumbline::firmware
