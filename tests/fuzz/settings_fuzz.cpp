/// Any text as a board file and as a print profile: accepted with every number in its range, or refused with the file's name.

#include <algorithm>
#include <cstdint>
#include <string_view>

#include "firmware/print/job/print_plan.hpp"
#include "firmware/settings/board_file.hpp"
#include "firmware/settings/print_profile.hpp"
#include "tests/fuzz/require.hpp"

namespace plumbline::firmware::fuzz {
namespace {

constexpr std::string_view kName = "fuzzed.toml";

void check_error(const Error& error) {
  require(error.code() == ErrorCode::kMalformed || error.code() == ErrorCode::kBadSetting, "another kind of error");
  const std::string_view message = error.message();
  require(message.starts_with(kName), "an error without the file's name");
  require(message.size() > kName.size() + 2, "an error without a reason");
}

void check_name(const std::string& name) {
  require(!name.empty(), "no name");
  require(std::all_of(name.begin(), name.end(), [](char c) { return c > ' ' && c < 127 && c != '/'; }), "an odd name");
}

void check_machine(const MachineFile& machine, const Expected<PrintProfile>& profile) {
  require(machine.step_mm() > 0 && machine.step_mm() < 1, "steps");
  require(machine.max_speed_mm_min > 0 && machine.max_acceleration_mm_s2 > 0, "speeds");
  require(machine.max_exposure_s > 0 && machine.power_mw_cm2 > 0, "lamp");
  require(machine.resin_min_c < machine.resin_max_c && machine.lamp_resume_c < machine.lamp_max_c, "temperatures");
  if (!profile) return;
  const auto plan = plan_print(*profile, machine, profile->layer_height, 100);
  if (!plan) return;
  require(lift_from(*plan, 99)[1].target <= plan->highest, "a lift beyond the travel");
  require(exposure_of(*plan, 0) > nanoseconds::zero() && exposure_of(*plan, 99) > nanoseconds::zero(), "no light");
  require(print_time(*plan) > nanoseconds::zero(), "a print that takes no time");
}

}  // namespace
}  // namespace plumbline::firmware::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace plumbline;
  using namespace plumbline::firmware;
  using namespace plumbline::firmware::fuzz;
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  const auto profile = parse_print_profile(text, kName);
  if (profile) {
    check_name(profile->name);
    require(profile->exposure_time > 0 && profile->layer_height > 0 && profile->lift_speed > 0, "a profile of nothing");
  } else {
    check_error(profile.error());
  }
  const auto board = parse_board_file(text, kName);
  if (!board) {
    check_error(board.error());
    return 0;
  }
  check_name(board->name);
  require(board->columns > 0 && board->rows > 0 && board->travel_mm > 0, "a printer of no size");
  require(board->pixel_pitch_x_mm > 0 && board->pixel_pitch_y_mm > 0 && board->layer_height_mm > 0, "pixels");
  static const auto standard = read_print_profile(PLUMBLINE_SOURCE_DIR "/board/profiles/standard.toml");
  if (board->machine) check_machine(*board->machine, standard);
  return 0;
}
