#include "firmware/setup/stage_trial.hpp"

#include <array>
#include <cmath>

namespace plumbline::firmware {
namespace {

/// mm a turn: T8 and other lead screws, ball screws.
constexpr std::array<double, 10> kLeads = {1, 1.25, 1.5, 2, 2.5, 3, 4, 5, 8, 10};
constexpr std::uint32_t kMostMicrosteps = 256;
/// A first jog of 1 mm is read to a tenth.
constexpr double kRoughly = 0.12;

double deviation(double ratio) { return std::abs(ratio - 1); }

/// Three digits, as a caliper gives them.
double rounded(double value) {
  const double unit = std::pow(10, std::floor(std::log10(value)) - 2);
  return std::round(value / unit) * unit;
}

}  // namespace

Expected<Drive> drive_for(const Drive& drive, Distance asked, double moved_mm) {
  const double ratio = moved_mm / asked.millimetres();
  const double size = std::abs(ratio);
  if (!(size >= 1e-3 && size <= 1e3)) {
    return fail(ErrorCode::kBadSetting, "%.3f mm instead of %.3f mm: no drive explains that. Measure again", moved_mm,
                asked.millimetres());
  }
  Drive found = drive;
  if (ratio < 0) found.direction_active_low = !drive.direction_active_low;
  if (deviation(size) <= kSameTravel) return found;
  for (std::uint32_t microsteps = 1; microsteps <= kMostMicrosteps; microsteps *= 2) {
    // Twice the microsteps is half the travel.
    const double explained = static_cast<double>(drive.microsteps) / microsteps;
    if (microsteps != drive.microsteps && deviation(size / explained) <= kRoughly) {
      found.microsteps = microsteps;
      return found;
    }
  }
  const double lead = drive.rotation_distance_mm * size;
  found.rotation_distance_mm = rounded(lead);
  double least = kRoughly;
  for (const double usual : kLeads) {
    if (deviation(lead / usual) > least) continue;
    least = deviation(lead / usual);
    found.rotation_distance_mm = usual;
  }
  return found;
}

}  // namespace plumbline::firmware
