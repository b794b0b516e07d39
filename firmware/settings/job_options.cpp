#include "firmware/settings/job_options.hpp"

#include <omp.h>

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "firmware/settings/print_profile.hpp"
#include "slicer/support_building.hpp"

namespace plumbline::firmware::inline settings {
namespace {

constexpr std::size_t kMiB = std::size_t{1024} * 1024;

std::uint32_t default_threads() {
  // OpenMP obeys the variable. Without it OpenMP would take every core.
  const int wanted = std::getenv("OMP_NUM_THREADS") != nullptr  // NOLINT(concurrency-mt-unsafe): before any thread
                         ? std::min(omp_get_max_threads(), static_cast<int>(kMostThreads))
                         : std::min(omp_get_num_procs(), static_cast<int>(kMostDefaultThreads));
  return static_cast<std::uint32_t>(std::max(1, wanted));
}

}  // namespace

Expected<JobSetup> set_up(const JobOptions& options, std::size_t built_bytes) {
  JobSetup setup;
  PlacementSettings& placement = setup.placement;
  placement.units = options.units;
  placement.scale = options.scale;
  placement.fit = options.fit;
  placement.size = options.size;
  placement.rotation_degrees = {options.rotate_degrees[0], options.rotate_degrees[1], options.rotate_degrees[2]};
  const auto built_mib = static_cast<std::uint32_t>(built_bytes / kMiB);
  std::uint32_t arena_mib = built_mib;
  if (!options.printer.empty()) {
    auto board = read_board_file(options.printer);
    PLUMBLINE_TRY(board);
    setup.printer_name = board->name;
    placement.printer = printer_volume(*board);
    placement.layer_height_mm = static_cast<float>(board->layer_height_mm);
    arena_mib = board->arena_mib;
    setup.board = std::move(*board);
  }
  if (options.pixel_pitch_mm) placement.pixel_pitch_mm = static_cast<float>(*options.pixel_pitch_mm);
  if (options.layer_height_mm && *options.layer_height_mm < 0) {
    return fail(ErrorCode::kBadSetting,
                "--layer-height adaptive is for prints: in files all layers have one height.\tGive it in mm");
  }
  if (options.layer_height_mm) placement.layer_height_mm = static_cast<float>(*options.layer_height_mm);
  if (options.arena_mib) arena_mib = *options.arena_mib;
  if (arena_mib > built_mib) {
    return fail(
        ErrorCode::kBadSetting,
        "%s asks for an arena of %u MiB, but this program has %u MiB.\tUse --arena-mib %u or less, or build with "
        "-DPLUMBLINE_ARENA_MIB=%u",
        options.arena_mib ? "--arena-mib" : "the board file", arena_mib, built_mib, built_mib, arena_mib);
  }
  setup.arena_bytes = arena_mib * kMiB;
  setup.as = options.as;
  setup.base = options.base;
  setup.floor = options.floor;
  setup.orient = options.orient;
  setup.keep_clean = options.keep_clean;
  setup.keep_all = options.keep_all;
  setup.peel = peel_of(setup.board);
  setup.absolute_correction_mm = options.absolute_correction_mm;
  setup.threads = options.threads.value_or(default_threads());
  return setup;
}

SliceSettings slice_settings(const JobSetup& setup, const std::optional<SupportSettings>& supports,
                             const PrintProfile* profile) {
  SliceSettings settings;
  settings.placement = setup.placement;
  if (supports) settings.placement.room = support_room(*supports);
  settings.supports = supports;
  settings.keep_clean = setup.keep_clean;
  settings.as = setup.as;
  settings.base = setup.base;
  settings.floor = setup.floor;
  settings.orient = setup.orient;
  settings.keep_all = setup.keep_all;
  settings.peel = setup.peel;
  if (setup.board) {
    const PrintProfile own = profile == nullptr ? profile_or_defaults(setup.board) : PrintProfile();
    const PrintProfile& told = profile == nullptr ? own : *profile;
    correct_sizes(told, *setup.board, settings);
    if (setup.board->machine) tell_checks(told, *setup.board->machine, settings);
    if (setup.board->machine && profile != nullptr) settings.grey = shown_grey(told, *setup.board->machine);
  }
  if (setup.absolute_correction_mm) settings.absolute_correction_mm = *setup.absolute_correction_mm;
  settings.placement.room.beside_mm += std::max(0.0, settings.absolute_correction_mm);
  settings.threads = setup.threads;
  return settings;
}

void start_threads(std::uint32_t threads) {
  omp_set_dynamic(0);
  omp_set_num_threads(static_cast<int>(threads));
  std::uint32_t started = 0;
#pragma omp parallel reduction(+ : started)
  ++started;
  static_cast<void>(started);
}

}  // namespace plumbline::firmware::inline settings
