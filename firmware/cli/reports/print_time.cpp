#include "firmware/cli/reports/print_time.hpp"

#include <algorithm>
#include <cstdio>

#include "firmware/print/job/print_plan.hpp"
#include "firmware/settings/print_profile.hpp"

namespace plumbline::firmware {

std::string PrintTime::text() const {
  constexpr auto kHour = std::chrono::minutes(60);
  auto minutes = std::chrono::round<std::chrono::minutes>(time);
  if (minutes >= kHour) minutes = (minutes + std::chrono::minutes(5)) / 10 * 10;
  char words[128];
  if (minutes >= kHour) {
    std::snprintf(words, sizeof words, "about %d h %02d min with the profile %.64s", static_cast<int>(minutes / kHour),
                  static_cast<int>((minutes % kHour).count()), profile.c_str());
  } else {
    std::snprintf(words, sizeof words, "about %d min with the profile %.64s",
                  static_cast<int>(std::max<std::int64_t>(1, minutes.count())), profile.c_str());
  }
  return words;
}

std::optional<PrintTime> estimate_print_time(const BoardFile& board, std::uint32_t layers, double layer_height_mm) {
  if (!board.machine) return std::nullopt;
  const auto profile = read_print_profile(board.machine->profile, board.path);
  if (!profile) return std::nullopt;
  const auto plan = plan_print(*profile, *board.machine, layer_height_mm, layers);
  if (!plan) return std::nullopt;
  return PrintTime{print_time(*plan), profile->name};
}

}  // namespace plumbline::firmware
