#include "firmware/settings/support_choice.hpp"

#include <algorithm>

#include "slicer/core/numbers/to_number.hpp"

namespace plumbline::firmware::inline settings {
namespace {

constexpr std::size_t kElevation = [] {
  std::size_t i = 0;
  while (kSupportFields[i].member != &SupportSettings::object_elevation) ++i;
  return i;
}();

/// The first key that is given; empty: none is.
std::string_view given_key(const SupportChoice& choice) {
  if (choice.preset) return "support_preset";
  if (choice.stand) return "support_stand";
  if (choice.buildplate_only) return "support_buildplate_only";
  for (std::size_t i = 0; i < choice.values.size(); ++i) {
    if (choice.values[i]) return kSupportFields[i].key;
  }
  for (std::size_t i = 0; i < kPlaceFields.size(); ++i) {
    if (choice.places[i].count > 0) return kPlaceFields[i].key;
  }
  return {};
}

/// Cuts the text before the first `mark` off, without spaces round it.
std::string_view take_part(std::string_view& text, char mark) {
  const std::size_t end = std::min(text.find(mark), text.size());
  std::string_view part = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  while (part.starts_with(' ')) part.remove_prefix(1);
  while (part.ends_with(' ')) part.remove_suffix(1);
  return part;
}

template <class Value>
std::uint32_t pass_one(const std::optional<Value>& value) {
  return value ? static_cast<std::uint32_t>(*value) + 1 : 0;
}

template <class Value>
bool receive_one(std::uint32_t word, std::size_t values, std::optional<Value>& value) {
  if (word > values) return false;
  if (word > 0) value = static_cast<Value>(word - 1);
  return true;
}

}  // namespace

std::string_view add_places(std::string_view text, const PlaceField& field, SupportPlaces& places) {
  while (!text.empty()) {
    const std::string_view place = take_part(text, ';');
    std::string_view rest = place;
    std::array<double, 5> numbers{};  // one more than there may be
    std::size_t count = 0;
    for (; !rest.empty() && count < numbers.size(); ++count) {
      const auto number = to_number<double>(take_part(rest, ','));
      if (!number) return place;
      numbers[count] = *number;
    }
    if (!add_place(std::span(numbers).first(count), field, places)) return place.empty() ? " " : place;
  }
  return {};
}

void write_places(JsonWriter& json, const PlaceField& field, const SupportPlaces& places) {
  json.begin_array(field.key, kOneLine);
  for (const SupportPlace& p : places.all()) {
    const std::array numbers = {p.x, p.y, p.z, p.radius};
    json.value(std::span(numbers).first(field.has_radius() ? 4 : 3));
  }
  json.end_array();
}

SupportSettings SupportChoice::put_into(SupportSettings settings) const {
  if (preset) apply(kSupportPresets[*preset], settings);
  settings.buildplate_only = buildplate_only.value_or(settings.buildplate_only);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i]) settings.*kSupportFields[i].member = *values[i];
  }
  if (const auto& elevation = values[kElevation]) {
    settings.stand = *elevation > 0 ? SupportStand::kRaised : SupportStand::kPlate;
  }
  settings.stand = stand.value_or(settings.stand);
  for (std::size_t i = 0; i < places.size(); ++i) settings.*kPlaceFields[i].member = places[i];
  return settings;
}

Expected<std::optional<SupportSettings>> SupportChoice::over(bool enabled, SupportSettings settings) const {
  if (!enable.value_or(enabled)) {
    const std::string_view given = given_key(*this);
    if (given.empty()) return std::nullopt;
    return fail(ErrorCode::kBadSetting, "%.*s is given, but supports are off.\tTurn them on with --supports auto",
                static_cast<int>(given.size()), given.data());
  }
  const SupportSettings job = put_into(settings);
  if (values[kElevation].value_or(0) > 0 && job.stand == SupportStand::kPlate) {
    return fail(ErrorCode::kBadSetting,
                "support_object_elevation is %g mm, but support_stand is plate.\tGive one of the two",
                job.object_elevation);
  }
  PLUMBLINE_TRY(check_support_settings(job));
  return job;
}

void add_support_rules(std::vector<SettingRule>& rules, SupportChoice& choice) {
  constexpr auto kOptional = Presence::kOptional;
  rules.insert(
      rules.end(),
      {{"supports", "support_preset",
        ChoiceSetting{kPresetWords, [&choice](std::size_t word) { choice.preset = word; }}, 0, 0, "", kOptional},
       {"supports", "support_stand",
        ChoiceSetting{kStandWords, [&choice](std::size_t word) { choice.stand = static_cast<SupportStand>(word); }}, 0,
        0, "", kOptional},
       {"supports", "support_buildplate_only", &choice.buildplate_only, 0, 0, "", kOptional}});
  for (std::size_t i = 0; i < kSupportFields.size(); ++i) {
    const SupportField& field = kSupportFields[i];
    SettingRule& rule = rules.emplace_back();
    rule = {"supports",
            field.key,
            &choice.values[i],
            field.low,
            field.high,
            field.unit == "deg" ? " degrees" : field.unit == "mm2" ? " mm2" : field.unit == "%" ? " %" : " mm",
            kOptional};
  }
}

void add_place_rules(std::vector<SettingRule>& rules, SupportChoice& choice) {
  for (std::size_t i = 0; i < kPlaceFields.size(); ++i) {
    rules.push_back({"supports", kPlaceFields[i].key, PlaceListSetting{&choice.places[i], &kPlaceFields[i]}, 0, 0, "",
                     Presence::kOptional});
  }
}

PassedSupports pass(const SupportChoice& choice) {
  PassedSupports passed;
  passed.words = {pass_one(choice.enable), pass_one(choice.preset), pass_one(choice.stand),
                  pass_one(choice.buildplate_only)};
  for (std::size_t i = 0; i < choice.values.size(); ++i) {
    passed.has[i] = choice.values[i] ? 1 : 0;
    passed.value[i] = choice.values[i].value_or(0);
  }
  passed.places = choice.places;
  return passed;
}

bool receive(const PassedSupports& passed, SupportChoice& choice) {
  for (std::size_t i = 0; i < choice.values.size(); ++i) {
    if (passed.has[i] == 0) continue;
    if (!(passed.value[i] >= kSupportFields[i].low && passed.value[i] <= kSupportFields[i].high)) return false;
    choice.values[i] = passed.value[i];
  }
  for (std::size_t i = 0; i < kPlaceFields.size(); ++i) {
    if (passed.places[i].count > passed.places[i].list.size()) return false;
    for (const SupportPlace& p : passed.places[i].all()) {
      const std::array numbers = {p.x, p.y, p.z, p.radius};
      const std::size_t count = kPlaceFields[i].has_radius() ? 4 : 3;
      if (!add_place(std::span(numbers).first(count), kPlaceFields[i], choice.places[i])) return false;
    }
  }
  return receive_one(passed.words[0], 2, choice.enable) &&
         receive_one(passed.words[1], kSupportPresets.size(), choice.preset) &&
         receive_one(passed.words[2], kStandWords.size(), choice.stand) &&
         receive_one(passed.words[3], 2, choice.buildplate_only);
}

}  // namespace plumbline::firmware::inline settings
