#include "firmware/board_file.hpp"

#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <numeric>
#include <optional>
#include <sstream>
#include <variant>
#include <vector>

#include "slicer/core/print_grid.hpp"

namespace plumbline {
namespace {

/// One key that a board file has: where it stands, what it allows, where it goes.
struct KeyRule {
  std::string_view table;
  std::string_view key;
  std::variant<std::string BoardFile::*, std::uint32_t BoardFile::*, double BoardFile::*> member;
  double low = 0;   ///< of the number, or of the characters in the text
  double high = 0;  ///< included, as low is
  const char* unit = "";
};

constexpr double kMaxSide = PrintGrid::kMaxSide;

/// The order is that of messages: the first rule that is broken is the one reported.
const std::array kRules{
    KeyRule{"printer", "name", &BoardFile::name, 1, 63, ""},
    KeyRule{"panel", "columns", &BoardFile::columns, 1, kMaxSide, " pixels"},
    KeyRule{"panel", "rows", &BoardFile::rows, 1, kMaxSide, " pixels"},
    KeyRule{"panel", "pixel_pitch_x_mm", &BoardFile::pixel_pitch_x_mm, 0.005, 1, " mm"},
    KeyRule{"panel", "pixel_pitch_y_mm", &BoardFile::pixel_pitch_y_mm, 0.005, 1, " mm"},
    KeyRule{"z_stage", "travel_mm", &BoardFile::travel_mm, 1, 2000, " mm"},
    KeyRule{"print", "layer_height_mm", &BoardFile::layer_height_mm, 0.005, 1, " mm"},
    KeyRule{"memory", "arena_mib", &BoardFile::arena_mib, 8, 65536, " MiB"},
};

constexpr std::string_view kNameCharacters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789 ._-";

/// A file may hold what a terminal would obey, and more of it than fits a message.
std::string printable(std::string_view text) {
  constexpr std::size_t kLongest = 60;
  std::string shown{text.substr(0, kLongest)};
  for (char& c : shown) {
    if (c < ' ' || c > '~') c = '?';
  }
  return text.size() > kLongest ? shown + "..." : shown;
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

/// "an integer from 1 to 16384 pixels"
std::string allowed(const KeyRule& rule) {
  const std::string range = number(rule.low) + " to " + number(rule.high);
  if (std::holds_alternative<std::string BoardFile::*>(rule.member)) {
    return "a string of " + range + " letters, digits, spaces and . _ -";
  }
  const bool integer = std::holds_alternative<std::uint32_t BoardFile::*>(rule.member);
  return (integer ? "an integer from " : "a number from ") + range + rule.unit;
}

/// "a string '1440'"
std::string found(const toml::node& node) {
  const char* type = "a value";
  switch (node.type()) {
    case toml::node_type::none: break;
    case toml::node_type::table: return "a table";
    case toml::node_type::array: return "an array";
    case toml::node_type::string: type = "a string"; break;
    case toml::node_type::integer: type = "an integer"; break;
    // toml++ writes all 17 digits: 0.0047 would be 0.0047000000000000002, which the file does not have.
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

/// Insertions, deletions and replacements that make one word the other (Levenshtein).
std::size_t edits(std::string_view from, std::string_view to) {
  std::vector<std::size_t> row(to.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < from.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < to.size(); ++j) {
      const std::size_t above = row[j + 1];
      row[j + 1] = std::min({above + 1, row[j] + 1, diagonal + (from[i] == to[j] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row.back();
}

std::string_view nearest(std::string_view word, const std::vector<std::string_view>& known) {
  return *std::min_element(known.begin(), known.end(),
                           [word](std::string_view a, std::string_view b) { return edits(word, a) < edits(word, b); });
}

std::string joined(const std::vector<std::string_view>& words) {
  std::string text;
  for (const auto word : words) text.append(text.empty() ? "" : ", ").append(word);
  return text;
}

std::vector<std::string_view> known_tables() {
  std::vector<std::string_view> tables;
  for (const auto& rule : kRules) {
    if (tables.empty() || tables.back() != rule.table) tables.push_back(rule.table);
  }
  return tables;
}

std::vector<std::string_view> known_keys(std::string_view table) {
  std::vector<std::string_view> keys;
  for (const auto& rule : kRules) {
    if (rule.table == table) keys.push_back(rule.key);
  }
  return keys;
}

class BoardFileReader {
 public:
  BoardFileReader(const toml::table& root, std::string_view path, std::size_t lines)
      : root_(root), path_(printable(path)), last_line_(lines) {}

  Expected<BoardFile> read() {
    PLUMBLINE_TRY(refuse_unknown());
    BoardFile board;
    for (const auto& rule : kRules) PLUMBLINE_TRY(read_key(rule, board));
    return board;
  }

 private:
  /// The unknown key that comes first in the file, if there is one: most often a known one, misspelt.
  Status refuse_unknown() const {
    const toml::key* first = nullptr;
    std::string_view first_table;  // empty: the key stands outside of any table
    const auto visit = [&](const toml::key& key, std::string_view table) {
      if (first != nullptr && first->source().begin.line <= key.source().begin.line) return;
      first = &key;
      first_table = table;
    };
    const auto tables = known_tables();
    for (auto&& [table_name, node] : root_) {
      const auto known = std::find(tables.begin(), tables.end(), table_name.str());
      if (known == tables.end()) {
        visit(table_name, {});
        continue;
      }
      const toml::table* table = node.as_table();
      if (table == nullptr) continue;  // read_key() says so
      const auto keys = known_keys(*known);
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
    const auto other = std::find_if(kRules.begin(), kRules.end(), [&](const KeyRule& r) { return r.key == key.str(); });
    if (other != kRules.end()) {
      return refuse(line, shown, "this key belongs in [" + std::string{other->table} + "]");
    }
    if (table.empty()) {
      const auto tables = known_tables();
      return refuse(line, shown,
                    "unknown; the nearest known table is [" + std::string{nearest(key.str(), tables)} +
                        "]. Allowed are the tables " + joined(tables));
    }
    const auto keys = known_keys(table);
    return refuse(line, shown,
                  "unknown key; the nearest known one is " + std::string{nearest(key.str(), keys)} + ". Allowed are " +
                      joined(keys));
  }

  Status read_key(const KeyRule& rule, BoardFile& board) const {
    const std::string shown = "[" + std::string{rule.table} + "] " + std::string{rule.key};
    const toml::node* table_node = root_.get(rule.table);
    if (table_node == nullptr) {
      return refuse(last_line_, shown,
                    "missing, the file has no [" + std::string{rule.table} + "]; allowed is " + allowed(rule));
    }
    const auto table_line = static_cast<std::size_t>(table_node->source().begin.line);
    const toml::table* table = table_node->as_table();
    if (table == nullptr) {
      return refuse(table_line, std::string{rule.table},
                    "found " + found(*table_node) + ", allowed is a table [" + std::string{rule.table} + "]");
    }
    const toml::node* node = table->get(rule.key);
    if (node == nullptr) return refuse(table_line, shown, "missing; allowed is " + allowed(rule));
    if (!store(rule, *node, board)) {
      return refuse(node->source().begin.line, shown, "found " + found(*node) + ", allowed is " + allowed(rule));
    }
    return {};
  }

  /// @returns false, and leaves `board` alone, where the value is not what the rule allows
  static bool store(const KeyRule& rule, const toml::node& node, BoardFile& board) {
    const auto in_range = [&rule](double value) { return value >= rule.low && value <= rule.high; };  // NaN is not
    if (const auto* text = std::get_if<std::string BoardFile::*>(&rule.member)) {
      const auto value = node.value_exact<std::string_view>();
      if (!value || !in_range(static_cast<double>(value->size()))) return false;
      if (value->find_first_not_of(kNameCharacters) != std::string_view::npos) return false;
      board.*(*text) = *value;
      return true;
    }
    if (const auto* integer = std::get_if<std::uint32_t BoardFile::*>(&rule.member)) {
      const auto value = node.value_exact<std::int64_t>();
      if (!value || !in_range(static_cast<double>(*value))) return false;
      board.*(*integer) = static_cast<std::uint32_t>(*value);
      return true;
    }
    if (!node.is_number()) return false;
    const auto value = node.value<double>();
    if (!value || !in_range(*value)) return false;
    board.*std::get<double BoardFile::*>(rule.member) = *value;
    return true;
  }

  tl::unexpected<Error> refuse(std::size_t line, const std::string& key, const std::string& reason) const {
    return fail(ErrorCode::kBadSetting, "%s:%zu: %s: %s", path_.c_str(), line, key.c_str(), reason.c_str());
  }

  const toml::table& root_;
  std::string path_;
  std::size_t last_line_;
};

}  // namespace

Expected<BoardFile> parse_board_file(std::string_view text, std::string_view path) {
  if (text.size() > kMaxBoardFileBytes) {
    return fail(ErrorCode::kMalformed, "%s: larger than %zu bytes, so not a board file", printable(path).c_str(),
                kMaxBoardFileBytes);
  }
  try {
    const toml::table root = toml::parse(text);
    const auto lines = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
    return BoardFileReader{root, path, std::max<std::size_t>(lines, 1)}.read();
  } catch (const toml::parse_error& error) {
    return fail(ErrorCode::kMalformed, "%s:%u: not TOML at column %u: %s", printable(path).c_str(),
                static_cast<unsigned>(error.source().begin.line), static_cast<unsigned>(error.source().begin.column),
                printable(error.description()).c_str());
  }
}

Expected<BoardFile> read_board_file(const std::string& path) {
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  const std::unique_ptr<std::FILE, Close> file{std::fopen(path.c_str(), "rb")};
  if (!file) {
    return fail(ErrorCode::kCannotOpen, "%s: %s", printable(path).c_str(), std::strerror(errno));
  }
  std::vector<char> text(kMaxBoardFileBytes + 1);
  text.resize(std::fread(text.data(), 1, text.size(), file.get()));
  if (std::ferror(file.get()) != 0) {
    return fail(ErrorCode::kCannotRead, "%s: %s", printable(path).c_str(), std::strerror(errno));
  }
  return parse_board_file({text.data(), text.size()}, path);
}

}  // namespace plumbline
