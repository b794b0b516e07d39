#include "firmware/daemon/stick/job_setting.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <type_traits>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/messages/printer_code.hpp"
#include "firmware/settings/job_options.hpp"
#include "firmware/settings/print_length.hpp"
#include "firmware/settings/print_values.hpp"
#include "slicer/core/numbers/to_number.hpp"

namespace plumbline::firmware {
namespace {

tl::unexpected<Error> refused(std::string_view key, std::string_view value, const char* allowed) {
  return telling(Told(PrinterCode::kSettingValue, {}, key),
                 fail(ErrorCode::kBadSetting, "%.*s: found '%.*s', allowed is %s", static_cast<int>(key.size()),
                      key.data(), static_cast<int>(value.size()), value.data(), allowed));
}

struct NumberKey {
  std::string_view name;
  double StickJob::*field;
  double low, high;
  const char* allowed;
};
constexpr std::array kNumbers = {
    NumberKey{"scale", &StickJob::scale, kSmallestScale, kLargestScale, "1e-6 to 1e6"},
    NumberKey{"rotate_x_deg", &StickJob::rotate_x_deg, -360, 360, "-360 to 360 degrees"},
    NumberKey{"rotate_y_deg", &StickJob::rotate_y_deg, -360, 360, "-360 to 360 degrees"},
    NumberKey{"rotate_z_deg", &StickJob::rotate_z_deg, -360, 360, "-360 to 360 degrees"},
    NumberKey{"layer_height", &StickJob::layer_height, kFinestMm, kCoarsestMm,
              "0.005 to 1 mm, adaptive, or \"\" for the profile's"},
};

struct TruthKey {
  std::string_view name;
  bool StickJob::*field;
};
constexpr std::array kTruths = {TruthKey{"fit", &StickJob::fit}, TruthKey{"keep_all", &StickJob::keep_all}};

/// Clears what a new value contradicts: a print has one size and one orientation.
void clear_rivals(StickJob& job, std::string_view key) {
  if (key == "scale" || (key == "fit" && job.fit)) job.size.reset();
  if (key.starts_with("rotate_")) job.orient = false;
}

/// The side whose size a key sets.
std::optional<Side> side_of(std::string_view key) {
  for (const Side side : {Side::kWidth, Side::kDepth, Side::kHeight, Side::kLength}) {
    if (key == to_string(side)) return side;
  }
  return std::nullopt;
}

/// The index of a word; none: it is not among them.
std::optional<std::size_t> index_of(std::span<const std::string_view> words, std::string_view word) {
  const auto found = std::find(words.begin(), words.end(), word);
  if (found == words.end()) return std::nullopt;
  return static_cast<std::size_t>(found - words.begin());
}

/// Sets a key of [supports]; an empty value takes it back.
/// @returns none: no such key
std::optional<Status> set_support(SupportChoice& choice, std::string_view key, std::string_view value) {
  for (std::size_t i = 0; i < kSupportFields.size(); ++i) {
    const SupportField& field = kSupportFields[i];
    if (field.key != key) continue;
    const auto number = to_number<double>(value);
    if (!value.empty() && !(number && *number >= field.low && *number <= field.high)) {
      FixedText<96> allowed;
      allowed.add("%g to %g %s, or \"\" for the profile's", field.low, field.high, field.unit.data());
      return refused(key, value, allowed.c_str());
    }
    choice.values[i] = number;
    return Status();
  }
  for (std::size_t i = 0; i < kPlaceFields.size(); ++i) {
    if (kPlaceFields[i].key != key) continue;
    SupportPlaces places;
    const std::string_view wrong = add_places(value, kPlaceFields[i], places);
    FixedText<200> allowed;
    allowed.add("up to 32 %s; with a semicolon between them, or \"\" for none", kPlaceFields[i].allowed);
    if (!wrong.empty()) return refused(key, wrong.substr(0, 60), allowed.c_str());
    choice.places[i] = places;
    return Status();
  }
  const auto put = [&](std::span<const std::string_view> words, const char* allowed, auto& to) -> Status {
    const auto word = index_of(words, value);
    if (!word && !value.empty()) return refused(key, value, allowed);
    to.reset();
    if (word) to = static_cast<typename std::decay_t<decltype(to)>::value_type>(*word);
    return {};
  };
  constexpr std::array<std::string_view, 2> kTruthWords = {"false", "true"};
  if (key == "supports") return put(kSupportWords, "none or auto, or \"\" for the profile's", choice.enable);
  if (key == "support_preset") {
    return put(kPresetWords, "light, medium or heavy, or \"\" for the profile's", choice.preset);
  }
  if (key == "support_stand") {
    return put(kStandWords, "auto, plate or raised, or \"\" for the profile's", choice.stand);
  }
  if (key == "support_buildplate_only") {
    return put(kTruthWords, "true or false, or \"\" for the profile's", choice.buildplate_only);
  }
  return std::nullopt;
}

}  // namespace

Status set_job_setting(StickJob& job, std::string_view key, std::string_view value) {
  for (const NumberKey& number : kNumbers) {
    if (number.name != key) continue;
    if (number.field == &StickJob::layer_height && (value.empty() || value == kAdaptiveWord)) {
      job.layer_height = value.empty() ? 0 : kAdaptiveHeight;
      return {};
    }
    const auto found = to_number<double>(value);
    if (!found || !(*found >= number.low && *found <= number.high)) return refused(key, value, number.allowed);
    job.*number.field = *found;
    clear_rivals(job, key);
    return {};
  }
  for (const TruthKey& truth : kTruths) {
    if (truth.name != key) continue;
    if (value != "true" && value != "false") return refused(key, value, "true or false");
    job.*truth.field = value == "true";
    clear_rivals(job, key);
    return {};
  }
  if (const PrintField* const field = find_print_field(key); field != nullptr && field->can_be_changed()) {
    const auto number = parse_print_value(*field, value);
    PLUMBLINE_TRY(number);
    job.values[index_of(field->key)] = *number;
    return {};
  }
  if (key == "units") {
    const auto word = index_of(kUnitWords, value);
    if (!word) return refused(key, value, "mm, cm, m, in or auto");
    job.units = static_cast<Units>(*word);
    return {};
  }
  if (key == "as") {
    const auto word = index_of(kAsWords, value);
    if (!word) return refused(key, value, "auto, points or mesh");
    job.as = static_cast<ReadAs>(*word);
    return {};
  }
  if (key == "base") {
    const auto word = index_of(kBaseWords, value);
    if (!word) return refused(key, value, "auto, none or flat");
    job.base = static_cast<BaseChoice>(*word);
    return {};
  }
  if (const auto set = set_support(job.supports, key, value)) return *set;
  if (const auto side = side_of(key)) {
    const auto mm = parse_length(value);
    if (!mm) return refused(key, value, kLengthForm);
    job.size = PrintSize{*side, *mm};
    job.scale = 1;
    job.fit = false;
    return {};
  }
  if (key == "floor") {
    const auto floor = parse_floor(value);
    if (!floor) return refused(key, value, kFloorForm);
    job.floor = *floor;
    return {};
  }
  if (key == "keep_clean") {
    const auto side = clean_side_named(value);
    if (!side) return refused(key, value, kCleanSideForm);
    job.keep_clean = *side;
    return {};
  }
  if (key == "orient") {
    const auto word = index_of(kSupportWords, value);
    if (!word) return refused(key, value, "none or auto");
    job.orient = *word == 1;
    if (job.orient) job.rotate_x_deg = job.rotate_y_deg = job.rotate_z_deg = 0;
    return {};
  }
  return telling(
      Told(PrinterCode::kSettingUnknown, {}, key),
      fail(ErrorCode::kBadSetting,
           "'%.*s': unknown setting.\tKnown are profile, units, scale, fit, width, depth, height, length, floor, "
           "orient, keep_clean, rotate_x_deg, "
           "rotate_y_deg, rotate_z_deg, layer_height, supports, as, base, keep_all, and supports, exposures, lifts and "
           "waits as a profile names them",
           static_cast<int>(key.size()), key.data()));
}

}  // namespace plumbline::firmware
