#include "firmware/settings/settings_file.hpp"

// toml++ 3.3 asserts what a malformed file can break, such as a key after "[", and then reports it as an error. An assertion would end the
// program, and clang optimizes by it.
#pragma push_macro("NDEBUG")
#undef NDEBUG
#define TOML_ASSERT(condition) static_cast<void>(0)
#include <toml++/toml.h>
#pragma pop_macro("NDEBUG")

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <optional>
#include <sstream>
#include <vector>

#include "firmware/settings/setting_rules.hpp"
#include "firmware/settings/setting_words.hpp"

namespace plumbline {
namespace {

constexpr std::size_t kLongestPath = 150;  ///< characters of a path in a message, so that there is room for the rest

using Rules = std::span<const SettingRule>;

constexpr std::string_view kNameCharacters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789 ._-";

/// "a string '1440'"
std::string found(const toml::node& node) {
  const char* type = "a value";
  switch (node.type()) {
    case toml::node_type::none: break;
    case toml::node_type::table: return "a table";
    case toml::node_type::array: return "an array";
    case toml::node_type::string: type = "a string"; break;
    case toml::node_type::integer: type = "an integer"; break;
    // toml++ writes 17 digits: 0.0047 would show as 0.0047000000000000002.
    case toml::node_type::floating_point: return "a float " + number(node.value_or(0.0));
    case toml::node_type::boolean: type = "a boolean"; break;
    case toml::node_type::date: type = "a date"; break;
    case toml::node_type::time: type = "a time"; break;
    case toml::node_type::date_time: type = "a date and time"; break;
  }
  std::ostringstream value;
  value << toml::node_view<const toml::node>{node};
  return std::string{type} + " " + printable(value.str());
}

bool store_text(const TextSetting& text, const SettingRule& rule, const toml::node& node) {
  const auto value = node.value_exact<std::string_view>();
  if (!value || static_cast<double>(value->size()) < rule.low || static_cast<double>(value->size()) > rule.high) {
    return false;
  }
  if (text.kind == TextKind::kName && !is_setting_name(*value)) return false;
  if (value->find('\0') != std::string_view::npos) return false;  // it would cut a path short
  *text.value = *value;
  return true;
}

/// @returns false and stores nothing if the rule does not allow the value
bool store(const SettingRule& rule, const toml::node& node) {
  struct Store {
    const SettingRule& rule;
    const toml::node& node;
    bool in_range(double value) const { return value >= rule.low && value <= rule.high; }  // NaN is not

    bool operator()(const TextSetting& text) const { return store_text(text, rule, node); }
    bool operator()(std::uint32_t* integer) const {
      const auto value = node.value_exact<std::int64_t>();
      if (!value || !in_range(static_cast<double>(*value))) return false;
      *integer = static_cast<std::uint32_t>(*value);
      return true;
    }
    bool operator()(double* real) const {
      if (!node.is_number()) return false;
      const auto value = node.value<double>();
      if (!value || !in_range(*value)) return false;
      *real = *value;
      return true;
    }
    bool operator()(bool* truth) const {
      const auto value = node.value_exact<bool>();
      if (value) *truth = *value;
      return value.has_value();
    }
    bool operator()(const ChoiceSetting& choice) const {
      const auto value = node.value_exact<std::string_view>();
      const auto word = std::find(choice.words.begin(), choice.words.end(), value.value_or(""));
      if (word == choice.words.end()) return false;
      choice.store(static_cast<std::size_t>(word - choice.words.begin()));
      return true;
    }
    bool operator()(const NumberChoiceSetting& choice) const {
      const auto value = node.value_exact<std::int64_t>();
      if (!value || std::find(choice.numbers.begin(), choice.numbers.end(), *value) == choice.numbers.end())
        return false;
      *choice.value = static_cast<std::uint32_t>(*value);
      return true;
    }
  };
  return std::visit(Store{rule, node}, rule.value);
}

class SettingsReader {
 public:
  SettingsReader(const toml::table& root, std::string_view path, std::size_t lines, const SettingsSchema& schema)
      : root_(root), path_(printable(path, kLongestPath)), last_line_(lines), schema_(schema), rules_(schema.rules) {}

  Status read() {
    PLUMBLINE_TRY(refuse_unknown());
    const bool all = std::any_of(rules_.begin(), rules_.end(), [this](const SettingRule& rule) {
      return rule.presence == Presence::kAllOrNone && find(rule) != nullptr;
    });
    if (schema_.has_all_or_none != nullptr) *schema_.has_all_or_none = all;
    for (const auto& rule : rules_) {
      const bool required = rule.presence == Presence::kRequired || (all && rule.presence == Presence::kAllOrNone);
      PLUMBLINE_TRY(read_key(rule, required));
    }
    for (const auto& rule : rules_) PLUMBLINE_TRY(check(rule));
    return {};
  }

 private:
  const toml::node* find(const SettingRule& rule) const {
    const toml::node* table = root_.get(rule.table);
    return table != nullptr && table->is_table() ? table->as_table()->get(rule.key) : nullptr;
  }

  /// Refuses the first unknown key of the file: usually a misspelt one.
  Status refuse_unknown() const {
    const toml::key* first = nullptr;
    std::string_view first_table;  // empty: the key is in no table
    const auto visit = [&](const toml::key& key, std::string_view table) {
      if (first != nullptr && first->source().begin.line <= key.source().begin.line) return;
      first = &key;
      first_table = table;
    };
    const auto tables = known_tables(rules_);
    for (auto&& [table_name, node] : root_) {
      const auto known = std::find(tables.begin(), tables.end(), table_name.str());
      if (known == tables.end()) {
        visit(table_name, {});
        continue;
      }
      const toml::table* table = node.as_table();
      if (table == nullptr) continue;  // read_key() reports it
      const auto keys = known_keys(rules_, *known);
      for (auto&& [key, value] : *table) {
        if (std::find(keys.begin(), keys.end(), key.str()) == keys.end()) visit(key, *known);
      }
    }
    if (first == nullptr) return {};
    return unknown(*first, first_table);
  }

  tl::unexpected<Error> unknown(const toml::key& key, std::string_view table) const {
    const auto line = static_cast<std::size_t>(key.source().begin.line);
    const std::string shown =
        table.empty() ? printable(key.str()) : "[" + std::string{table} + "] " + printable(key.str());
    const auto other =
        std::find_if(rules_.begin(), rules_.end(), [&](const SettingRule& rule) { return rule.key == key.str(); });
    if (other != rules_.end()) {
      return refuse(line, shown, "this key belongs in [" + std::string{other->table} + "]");
    }
    if (table.empty()) {
      const auto tables = known_tables(rules_);
      return refuse(line, shown,
                    "unknown; the nearest known table is [" + std::string{nearest(key.str(), tables)} +
                        "]. Allowed are the tables " + joined(tables));
    }
    const auto keys = known_keys(rules_, table);
    return refuse(line, shown,
                  "unknown key; the nearest known one is " + std::string{nearest(key.str(), keys)} + ". Allowed are " +
                      joined(keys));
  }

  static std::string shown(const SettingRule& rule) {
    return "[" + std::string{rule.table} + "] " + std::string{rule.key};
  }

  Status read_key(const SettingRule& rule, bool required) const {
    const toml::node* table_node = root_.get(rule.table);
    if (table_node == nullptr) {
      if (!required) return {};
      return refuse(last_line_, shown(rule),
                    "missing, the file has no [" + std::string{rule.table} + "]; allowed is " + allowed(rule));
    }
    const auto table_line = static_cast<std::size_t>(table_node->source().begin.line);
    if (!table_node->is_table()) {
      return refuse(table_line, std::string{rule.table},
                    "found " + found(*table_node) + ", allowed is a table [" + std::string{rule.table} + "]");
    }
    const toml::node* node = find(rule);
    if (node == nullptr) {
      if (!required) return {};
      return refuse(table_line, shown(rule), "missing; allowed is " + allowed(rule));
    }
    if (!store(rule, *node)) {
      return refuse(node->source().begin.line, shown(rule), "found " + found(*node) + ", allowed is " + allowed(rule));
    }
    return {};
  }

  Status check(const SettingRule& rule) const {
    const toml::node* node = find(rule);
    if (node == nullptr || !schema_.check) return {};
    const std::string reason = schema_.check(rule);
    if (reason.empty()) return {};
    return refuse(node->source().begin.line, shown(rule), "found " + found(*node) + ", " + reason);
  }

  tl::unexpected<Error> refuse(std::size_t line, const std::string& key, const std::string& reason) const {
    const std::string message = path_ + ":" + std::to_string(line) + ": " + key + ": " + reason;
    return fail(ErrorCode::kBadSetting, "%s", shortened(message, Error::kCapacity - 4).c_str());
  }

  const toml::table& root_;
  std::string path_;
  std::size_t last_line_;
  const SettingsSchema& schema_;
  Rules rules_;
};

}  // namespace

bool is_setting_name(std::string_view text) {
  return text.find_first_not_of(kNameCharacters) == std::string_view::npos;
}

Status parse_settings(std::string_view text, std::string_view path, const SettingsSchema& schema) {
  if (text.size() > kMaxSettingsFileBytes) {
    return fail(ErrorCode::kMalformed, "%s: larger than %zu bytes, so not %s", printable(path, kLongestPath).c_str(),
                kMaxSettingsFileBytes, schema.kind);
  }
  try {
    const toml::table root = toml::parse(text);
    const auto lines = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
    return SettingsReader{root, path, std::max<std::size_t>(lines, 1), schema}.read();
  } catch (const toml::parse_error& error) {
    return fail(ErrorCode::kMalformed, "%s:%u: not TOML at column %u: %s", printable(path, kLongestPath).c_str(),
                static_cast<unsigned>(error.source().begin.line), static_cast<unsigned>(error.source().begin.column),
                printable(error.description(), 250).c_str());
  }
}

Expected<std::string> read_settings_text(const std::string& path, const char* kind) {
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  const std::unique_ptr<std::FILE, Close> file{std::fopen(path.c_str(), "rb")};
  if (!file) {
    return fail(ErrorCode::kCannotOpen, "%s: %s", printable(path, kLongestPath).c_str(), std::strerror(errno));
  }
  std::string text(kMaxSettingsFileBytes + 1, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), file.get()));
  if (std::ferror(file.get()) != 0) {
    return fail(ErrorCode::kCannotRead, "%s: %s", printable(path, kLongestPath).c_str(), std::strerror(errno));
  }
  if (text.size() > kMaxSettingsFileBytes) {
    return fail(ErrorCode::kMalformed, "%s: larger than %zu bytes, so not %s", printable(path, kLongestPath).c_str(),
                kMaxSettingsFileBytes, kind);
  }
  return text;
}

Status read_settings_file(const std::string& path, const SettingsSchema& schema) {
  const auto text = read_settings_text(path, schema.kind);
  PLUMBLINE_TRY(text);
  return parse_settings(*text, path, schema);
}

}  // namespace plumbline
