#include "hal/sim/part/loss.hpp"

#include <array>
#include <cstdio>

namespace plumbline::inline hal::inline sim {

std::string to_string(const Loss& loss) {
  std::array<char, 160> text{};
  int length = std::snprintf(text.data(), text.size(), "%.4g ml at (%.2f, %.2f) mm, layers %u to %u", loss.ml,
                             loss.x_mm, loss.y_mm, loss.layer, loss.last_layer);
  if (loss.kind == LossKind::kTorn) {
    const auto used = static_cast<std::size_t>(length);
    length += std::snprintf(text.data() + used, text.size() - used, "; the peel asked for %.3g N, %.3g N held",
                            loss.asked_n, loss.held_n);
  }
  return std::string(text.data(), static_cast<std::size_t>(length));
}

}  // namespace plumbline::inline hal::inline sim
