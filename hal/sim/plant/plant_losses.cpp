#include <algorithm>

#include "hal/sim/plant/plant.hpp"

namespace plumbline::inline hal::inline sim {

void Plant::hang_last_layer() {
  const CuredLayer& last = part_.layers().back();
  // Lost steps can leave a layer higher than the one before.
  const double gap = std::max(0.0, (last.z - above_last_layer()).millimetres());
  part_.complete_layer(first_layer() + judged_ - 1, gap, judged_ == 1 && first_layer() > 0);
  const HangingPart& hanging = part_.hanging();
  for (const std::uint32_t i : hanging.changed()) {
    const Loss& loss = hanging.losses()[i];
    if (i < objection_of_loss_.size()) {
      const std::size_t at = objection_of_loss_[i];
      if (loss.joined == Loss::kNone) {
        objections_[at].loss = loss;
        continue;
      }
      objections_.erase(objections_.begin() + static_cast<std::ptrdiff_t>(at));
      for (std::size_t& later : objection_of_loss_) later -= later > at ? 1 : 0;
      continue;
    }
    objection_of_loss_.push_back(objections_.size());
    objections_.push_back({.kind = kind_of(loss.kind),
                           .at = last.ended,
                           .z = last.z,
                           .layer = first_layer() + judged_ - 1,
                           .detail = {},
                           .loss = loss});
  }
}

}  // namespace plumbline::inline hal::inline sim
