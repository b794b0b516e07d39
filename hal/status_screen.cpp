#include "hal/status_screen.hpp"

#include <cassert>
#include <cstddef>

namespace plumbline::inline hal {

Status StatusScreen::present(std::span<const std::uint16_t> pixels) {
  assert(pixels.size() == std::size_t{columns_} * rows_);
  return do_present(pixels);
}

}  // namespace plumbline::inline hal
