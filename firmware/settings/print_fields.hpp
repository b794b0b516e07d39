#pragma once
/// The settings that a print is carried out with: their names, units and ranges, written once for profiles, archives, job files,
/// command lines, and what people are shown.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>

namespace plumbline::firmware::inline settings {

struct PrintProfile;

/// In the order in which people are shown them.
enum class PrintKey : std::uint8_t {
  kLayerHeight,
  kInitialLayerHeight,
  kBottomLayerCount,
  kInitialExposureTime,
  kFadedLayers,
  kExposureTime,
  kDelayBeforeExposure,
  kDelayAfterExposure,
  kLiftHeight,
  kLiftSpeed,
  kLiftHeight2,
  kLiftSpeed2,
  kWaitTimeAfterLift,
  kRetractSpeed,
  kRetractHeight2,
  kRetractSpeed2,
  kElefantFootCompensation,
  kPauseLiftHeight,
};
inline constexpr std::size_t kPrintKeyCount = 18;

/// Who has said a value.
enum class ValueSource : std::uint8_t { kProfile, kArchive, kPrinter, kPerson };
/// In this order.
inline constexpr std::array<std::string_view, 4> kSourceWords = {"profile", "archive", "printer", "person"};

/// A setting for each key; none: nobody has said it.
using PrintValues = std::array<std::optional<double>, kPrintKeyCount>;
constexpr std::size_t index_of(PrintKey key) { return static_cast<std::size_t>(key); }

struct PrintField {
  PrintKey key;
  std::string_view name;  ///< as in profiles: "exposure_time"
  std::variant<double PrintProfile::*, std::uint32_t PrintProfile::*> member;
  double low, high;  ///< inclusive
  const char* unit;  ///< for messages, with a leading space
  double step =
      0;  ///< by which the printer's screen changes it; 0: a person can't change it, or only before the masks are made
  bool in_profile = true;  ///< a profile's file has the key

  bool can_be_changed() const { return step > 0; }
  bool is_whole() const { return member.index() == 1; }
  bool allows(double value) const {
    return value >= low && value <= high && (!is_whole() || value == std::floor(value));
  }
};

/// In the order of PrintKey.
extern const std::array<PrintField, kPrintKeyCount> kPrintFields;

/// The field with a name; null: there is none.
const PrintField* find_print_field(std::string_view name);

double value_of(const PrintProfile& profile, const PrintField& field);
/// Replaces a value and its source.
void set_value(PrintProfile& profile, const PrintField& field, double value, ValueSource source);
/// The same for all that `values` has.
void set_values(PrintProfile& profile, const PrintValues& values, ValueSource source);

/// The same as plain numbers, from a process that is not trusted.
struct PassedValues {
  std::array<std::uint32_t, kPrintKeyCount> has{};  ///< 1: there is one
  std::array<double, kPrintKeyCount> value{};
};
PassedValues pass(const PrintValues& values);
/// @returns a field whose value is impossible; null: all are taken
const PrintField* receive(const PassedValues& passed, PrintValues& values);

}  // namespace plumbline::firmware::inline settings
