#include "firmware/settings/setting_rules.hpp"

#include <algorithm>
#include <optional>
#include <sstream>

#include "firmware/settings/setting_words.hpp"

namespace plumbline::firmware::inline settings {
namespace {

/// "none, x or y"
template <class Item>
std::string listed(std::span<const Item> items) {
  std::ostringstream text;
  for (std::size_t i = 0; i < items.size(); ++i) {
    text << (i == 0 ? "" : i + 1 == items.size() ? " or " : ", ") << items[i];
  }
  return text.str();
}

}  // namespace

std::string allowed(const SettingRule& rule) {
  const std::string range = number(rule.low) + " to " + number(rule.high);
  struct Wording {
    const SettingRule& rule;
    const std::string& range;
    std::string operator()(const TextSetting& text) const {
      return "a string of " + range +
             (text.kind == TextKind::kName ? " letters, digits, spaces and . _ -" : " characters");
    }
    std::string operator()(const PathListSetting& paths) const {
      return "a string of " + range + " characters, or an array of 1 to " + std::to_string(paths.most) + " of them";
    }
    std::string operator()(const std::uint32_t*) const { return "an integer from " + range + rule.unit; }
    std::string operator()(const double*) const { return "a number from " + range + rule.unit; }
    std::string operator()(const bool*) const { return "true or false"; }
    std::string operator()(const std::optional<double>*) const { return (*this)(static_cast<const double*>(nullptr)); }
    std::string operator()(const std::optional<bool>*) const { return (*this)(static_cast<const bool*>(nullptr)); }
    std::string operator()(const PlaceListSetting& places) const {
      return "an array of up to 32 " + std::string(places.field->allowed);
    }
    std::string operator()(const LampMap*) const {
      return "an array of 1 to 16 rows, each an array of as many numbers, 1 to 16, from " + range;
    }
    std::string operator()(const NumberOrWord& either) const {
      return "a number from " + range + rule.unit + ", or the string \"" + std::string(either.word) + "\"";
    }
    std::string operator()(const ChoiceSetting& choice) const { return "one of the strings " + listed(choice.words); }
    std::string operator()(const NumberChoiceSetting& choice) const {
      return "one of the integers " + listed(choice.numbers) + rule.unit;
    }
  };
  return std::visit(Wording{rule, range}, rule.value);
}

std::vector<std::string_view> known_tables(std::span<const SettingRule> rules) {
  std::vector<std::string_view> tables;
  for (const auto& rule : rules) {
    if (std::find(tables.begin(), tables.end(), rule.table) == tables.end()) tables.push_back(rule.table);
  }
  return tables;
}

std::vector<std::string_view> known_keys(std::span<const SettingRule> rules, std::string_view table) {
  std::vector<std::string_view> keys;
  for (const auto& rule : rules) {
    if (rule.table == table) keys.push_back(rule.key);
  }
  return keys;
}

}  // namespace plumbline::firmware::inline settings
