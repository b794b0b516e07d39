#include "firmware/setup/board_draft.hpp"

#include <algorithm>
#include <optional>
#include <sstream>
#include <vector>

#include "firmware/settings/setting_rules.hpp"
#include "firmware/settings/setting_words.hpp"

namespace plumbline::firmware {
namespace {

bool is_text(const SettingRule& rule) {
  return std::holds_alternative<TextSetting>(rule.value) || std::holds_alternative<ChoiceSetting>(rule.value);
}

/// The value without quotes.
std::string shown(const SettingRule& rule) {
  struct Show {
    std::string operator()(const TextSetting& text) const { return *text.value; }
    std::string operator()(const PathListSetting& list) const {
      std::string all;
      for (const std::string& path : *list.values) all += (all.empty() ? "" : ", ") + path;
      return all;
    }
    std::string operator()(const std::uint32_t* integer) const { return std::to_string(*integer); }
    std::string operator()(const double* real) const { return number(*real); }
    std::string operator()(const bool* truth) const { return *truth ? "true" : "false"; }
    std::string operator()(const std::optional<double>* real) const { return *real ? number(**real) : ""; }
    std::string operator()(const std::optional<bool>* truth) const { return *truth ? (*this)(&**truth) : ""; }
    std::string operator()(const ChoiceSetting& choice) const { return std::string(choice.words[choice.load()]); }
    std::string operator()(const NumberChoiceSetting& choice) const { return std::to_string(*choice.value); }
    std::string operator()(const LampMap* map) const {
      std::string all;
      for (std::size_t i = 0; i < map->all().size(); ++i) {
        const bool begins_row = i % map->columns == 0;
        all += (i == 0 ? "[[" : begins_row ? "], [" : ", ") + number(map->light[i]);
      }
      return all.empty() ? all : all + "]]";
    }
    std::string operator()(const PlaceListSetting&) const { return ""; }  // no board has any, nor
    std::string operator()(const NumberOrWord&) const { return ""; }
  };
  return std::visit(Show{}, rule.value);
}

std::string quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

/// As TOML has the answer.
Expected<std::string> literal(const SettingRule& rule, const std::string& answer) {
  if (std::any_of(answer.begin(), answer.end(), [](char c) { return static_cast<unsigned char>(c) < ' '; })) {
    return fail(ErrorCode::kBadSetting, "an answer is one line without control characters");
  }
  if (std::holds_alternative<bool*>(rule.value)) {
    if (answer == "true" || answer == "yes" || answer == "y") return std::string("true");
    if (answer == "false" || answer == "no" || answer == "n") return std::string("false");
  }
  // What can't be a number is a string to TOML, too, so that the message about it says what was found.
  const bool a_number = answer.find_first_of("0123456789") != std::string::npos &&
                        answer.find_first_not_of("0123456789+-.eE") == std::string::npos;
  if (is_text(rule) || !a_number) return quoted(answer);
  return answer.starts_with('.') ? "0" + answer : answer;
}

std::vector<std::string> words_of(const std::string& answer) {
  std::istringstream stream(answer);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

bool is_number(const std::string& word) {
  return !word.empty() && word.find_first_not_of("0123456789") == std::string::npos;
}

/// The rules of a copy of the draft's values, for one call.
struct Bound {
  explicit Bound(const BoardFile& from) : board(from), rules(board_rules(board, *board.machine)) {}
  Bound(const Bound&) = delete;
  Bound& operator=(const Bound&) = delete;

  const SettingRule* find(std::string_view table, std::string_view key) const {
    const auto rule = std::find_if(rules.begin(), rules.end(),
                                   [&](const SettingRule& one) { return one.table == table && one.key == key; });
    return rule == rules.end() ? nullptr : &*rule;
  }

  BoardFile board;
  std::vector<SettingRule> rules;
};

/// A board file's values before any key was read.
const BoardFile& untouched() {
  static const BoardFile kBoard = [] {
    BoardFile board;
    board.machine.emplace();
    return board;
  }();
  return kBoard;
}

/// Parses `text` by some rules and tells what is wrong without "answer:2: [table] key: ".
Status parse_answer(const std::string& text, std::span<const SettingRule> rules,
                    const std::function<std::string(const SettingRule&)>& check) {
  const Status parsed = parse_settings(text, "answer", {"an answer", rules, nullptr, check});
  if (parsed) return {};
  std::string_view message = parsed.error().message();
  if (const auto found = message.find("found "); found != std::string_view::npos) message.remove_prefix(found);
  return fail(ErrorCode::kBadSetting, "%.*s", static_cast<int>(message.size()), message.data());
}

}  // namespace

BoardDraft::BoardDraft(BoardFile board) : board_(std::move(board)), like_(board_.name) {}

Expected<BoardDraft> BoardDraft::like(const std::string& like) {
  auto board = read_board_file(like);
  PLUMBLINE_TRY(board);
  PLUMBLINE_TRY(machine_of(*board, board->path));
  return BoardDraft(std::move(*board));
}

void BoardDraft::note(std::string_view table, std::string_view key, std::string_view source) {
  if (!source.empty()) sources_[{std::string(table), std::string(key)}] = source;
}

Status BoardDraft::set(std::string_view table, std::string_view key, const std::string& answer,
                       std::string_view source) {
  Bound trial(board_);
  const SettingRule* const rule = trial.find(table, key);
  if (rule == nullptr) return fail(ErrorCode::kBadSetting, "no such key");
  const auto value = literal(*rule, answer);
  PLUMBLINE_TRY(value);
  SettingRule one = *rule;
  one.presence = Presence::kOptional;
  PLUMBLINE_TRY(parse_answer(
      "[" + std::string(table) + "]\n" + std::string(key) + " = " + *value + "\n", std::span(&one, 1),
      [&](const SettingRule& checked) { return check_board_key(checked, trial.board, *trial.board.machine); }));
  board_ = trial.board;
  note(table, key, source);
  return {};
}

Status BoardDraft::set_table(std::string_view table, const std::map<std::string, std::string>& keys,
                             std::string_view source) {
  Bound trial(board_);
  std::vector<SettingRule> rules;
  std::string text = "[" + std::string(table) + "]\n";
  for (const auto& [key, answer] : keys) {
    const SettingRule* const rule = trial.find(table, key);
    if (rule == nullptr) return fail(ErrorCode::kBadSetting, "no such key");
    const auto value = literal(*rule, answer);
    PLUMBLINE_TRY(value);
    text += key + " = " + *value + "\n";
  }
  Bound fresh(untouched());
  for (const SettingRule& rule : trial.rules) {
    if (rule.table != table) continue;
    // What the table had before goes.
    const SettingRule* const blank = fresh.find(rule.table, rule.key);
    if (const auto* const name = std::get_if<TextSetting>(&rule.value)) name->value->clear();
    if (auto* const* const integer = std::get_if<std::uint32_t*>(&rule.value)) {
      **integer = **std::get_if<std::uint32_t*>(&blank->value);
    }
    if (const auto* const number = std::get_if<NumberChoiceSetting>(&rule.value)) {
      *number->value = *std::get<NumberChoiceSetting>(blank->value).value;
    }
    if (const auto* const choice = std::get_if<ChoiceSetting>(&rule.value)) {
      choice->store(std::get<ChoiceSetting>(blank->value).load());
    }
    rules.push_back(rule);
    rules.back().presence = Presence::kOptional;
  }
  PLUMBLINE_TRY(parse_answer(text, rules, [&](const SettingRule& checked) {
    return check_board_key(checked, trial.board, *trial.board.machine);
  }));
  board_ = trial.board;
  std::erase_if(sources_, [&](const auto& one) { return one.first.first == table; });
  for (const auto& [key, answer] : keys) note(table, key, source);
  return {};
}

Status BoardDraft::set_line(std::string_view table, const std::string& answer, std::string_view source) {
  constexpr const char* kForm =
      "a line is its name, or chip and number, then low if a low voltage means on, then pull-up, pull-down or "
      "disabled: "
      "GPIO17 low pull-up";
  std::map<std::string, std::string> keys;
  auto words = words_of(answer);
  if (words.empty()) return fail(ErrorCode::kBadSetting, "%s", kForm);
  if (words.size() == 1 && words[0] == "none") return set_table(table, {}, source);
  std::size_t next = 1;
  if (words.size() > 1 && is_number(words[1])) {
    keys = {{"chip", words[0]}, {"offset", words[1]}};
    next = 2;
  } else {
    keys = {{"line", words[0]}};
  }
  for (; next < words.size(); ++next) {
    const bool level = words[next] == "low" || words[next] == "high";
    const bool bias = std::find(kLineBiasWords.begin(), kLineBiasWords.end(), words[next]) != kLineBiasWords.end();
    if (!level && !bias) return fail(ErrorCode::kBadSetting, "%s", kForm);
    keys[level ? "active" : "bias"] = words[next];
  }
  return set_table(table, keys, source);
}

Status BoardDraft::set_sensor(std::string_view table, const std::string& answer, std::string_view source) {
  const auto words = words_of(answer);
  if (words.size() == 2 && words[0] == "hwmon") return set_table(table, {{"hwmon", words[1]}}, source);
  if (words.size() == 3 && words[0] == "hwmon" && is_number(words[2])) {
    return set_table(table, {{"hwmon", words[1]}, {"channel", words[2]}}, source);
  }
  if (words.size() == 2 && words[0] == "zone") return set_table(table, {{"thermal_zone", words[1]}}, source);
  if (words.size() == 2 && words[0] == "file") return set_table(table, {{"file", words[1]}}, source);
  return fail(ErrorCode::kBadSetting, "a sensor is hwmon NAME, hwmon NAME CHANNEL, zone TYPE or file PATH");
}

Status BoardDraft::set_fan(std::string_view table, const std::string& answer, std::string_view source) {
  const auto words = words_of(answer);
  if (words.size() == 1 && words[0] == "none") return set_table(table, {}, source);
  if (words.size() == 3 && is_number(words[2]) && (words[0] == "hwmon" || words[0] == "pwm")) {
    return set_table(table, {{words[0] == "pwm" ? "pwm_chip" : "hwmon", words[1]}, {"channel", words[2]}}, source);
  }
  return fail(ErrorCode::kBadSetting, "a fan is hwmon NAME CHANNEL, pwm CHIP CHANNEL or none");
}

Status BoardDraft::set_screen(const std::string& answer, std::string_view source) {
  constexpr const char* kForm =
      "a screen is its connector and its size in pixels, and if it needs them its rotation, 16-bit, and the path of "
      "its touch panel: SPI-1 320x240 90 16-bit";
  const auto words = words_of(answer);
  if (words.size() == 1 && words[0] == "none") return set_table("screen", {}, source);
  std::map<std::string, std::string> keys;
  for (const std::string& word : words) {
    const std::size_t cross = word.find('x');
    if (cross != std::string::npos && is_number(word.substr(0, cross)) && is_number(word.substr(cross + 1))) {
      keys["columns"] = word.substr(0, cross);
      keys["rows"] = word.substr(cross + 1);
    } else if (is_number(word)) {
      keys["rotation_deg"] = word;
    } else if (word == "16-bit" || word == "24-bit") {
      keys["bits"] = word.substr(0, 2);
    } else if (!keys.emplace(word.starts_with('/') ? "touch" : "connector", word).second) {
      return fail(ErrorCode::kBadSetting, "%s", kForm);
    }
  }
  const bool placed = keys.contains("connector") || board_.machine->simulated;
  if (!placed || !keys.contains("columns")) return fail(ErrorCode::kBadSetting, "%s", kForm);
  return set_table("screen", keys, source);
}

std::string BoardDraft::value(std::string_view table, std::string_view key) const {
  const Bound now(board_);
  const Bound before(untouched());
  const std::string text = shown(*now.find(table, key));
  const bool unset = now.find(table, key)->presence == Presence::kOptional && text == shown(*before.find(table, key));
  return unset ? std::string() : text;
}

std::string BoardDraft::line(std::string_view table) const {
  const std::string name = value(table, "line");
  const std::string chip = value(table, "chip");
  if (name.empty() && chip.empty()) return "none";
  std::string text = name.empty() ? chip + " " + value(table, "offset") : name;
  for (const char* const key : {"active", "bias"}) {
    if (const std::string word = value(table, key); !word.empty()) text += " " + word;
  }
  return text;
}

std::string BoardDraft::sensor(std::string_view table) const {
  if (const auto chip = value(table, "hwmon"); !chip.empty()) {
    const std::string channel = value(table, "channel");
    return "hwmon " + chip + (channel.empty() ? "" : " " + channel);
  }
  if (const auto zone = value(table, "thermal_zone"); !zone.empty()) return "zone " + zone;
  if (const auto file = value(table, "file"); !file.empty()) return "file " + file;
  return {};
}

std::string BoardDraft::fan(std::string_view table) const {
  const std::string chip = value(table, "hwmon"), pwm = value(table, "pwm_chip"), channel = value(table, "channel");
  if (chip.empty() && pwm.empty()) return "none";
  return (pwm.empty() ? "hwmon " + chip : "pwm " + pwm) + " " + (channel.empty() ? "1" : channel);
}

std::string BoardDraft::screen() const {
  if (!board_.machine->wiring.screen.given()) return "none";
  std::string text = value("screen", "columns") + "x" + value("screen", "rows");
  if (const auto connector = value("screen", "connector"); !connector.empty()) text = connector + " " + text;
  if (const auto degrees = value("screen", "rotation_deg"); !degrees.empty()) text += " " + degrees;
  if (const auto bits = value("screen", "bits"); !bits.empty()) text += " " + bits + "-bit";
  if (const auto touch = value("screen", "touch"); !touch.empty()) text += " " + touch;
  return text;
}

std::string BoardDraft::allowed_for(std::string_view table, std::string_view key) const {
  const Bound now(board_);
  return allowed(*now.find(table, key));
}

std::string BoardDraft::text() const {
  constexpr std::size_t kComment = 31;
  std::string out =
      "# Made by plumbline setup. board/README.md explains each key. Unknown keys are errors.\n"
      "# Check it on the printer's board: plumbline doctor --printer " +
      board_.name + ".toml\n";
  const Bound now(board_);
  std::string_view table;
  for (const SettingRule& rule : now.rules) {
    const auto source = sources_.find({std::string(rule.table), std::string(rule.key)});
    const bool choice = std::holds_alternative<ChoiceSetting>(rule.value);
    // A choice that somebody was asked about is written even if the key's absence would mean the same.
    const std::string value_text = choice && source != sources_.end() ? shown(rule) : value(rule.table, rule.key);
    const bool named = is_text(rule) && !choice;
    if (value_text.empty() && (rule.presence == Presence::kOptional || !named)) continue;
    if (rule.table != table) out += "\n[" + std::string(rule.table) + "]\n";
    table = rule.table;
    std::string line = std::string(rule.key) + " = " + (is_text(rule) ? quoted(value_text) : value_text);
    line.resize(std::max(kComment, line.size() + 1), ' ');
    out.append(line).append("# ");
    if (rule.unit[0] == ' ') out.append(rule.unit + 1).append("; ");
    out.append(source == sources_.end() ? "as " + like_ : source->second).append("\n");
  }
  return out;
}

Expected<BoardFile> BoardDraft::board() const { return parse_board_file(text(), board_.name + ".toml"); }

}  // namespace plumbline::firmware
