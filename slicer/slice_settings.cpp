#include "slicer/slice_settings.hpp"

#include <omp.h>

#include <algorithm>

#include "slicer/rays/ray_shooter.hpp"

namespace plumbline::inline slicer {

SliceSettings set_threads(const SliceSettings& settings) {
  SliceSettings checked = settings;
  checked.threads = std::clamp<std::uint32_t>(settings.threads, 1, kMaxThreads);
  omp_set_num_threads(static_cast<int>(checked.threads));
  return checked;
}

}  // namespace plumbline::inline slicer
