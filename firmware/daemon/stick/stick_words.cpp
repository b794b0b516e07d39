#include "firmware/daemon/stick/stick_words.hpp"

#include <algorithm>
#include <array>
#include <cctype>

namespace plumbline {
namespace {

struct Option {
  std::string_view name;
  std::string_view key;  ///< in job.toml
  bool takes_argument = true;
};

/// Longer names before those they begin with.
constexpr std::array kOptions = {
    Option{"--layer-height", "layer_height"},
    Option{"--rotate-x", "rotate_x_deg"},
    Option{"--rotate-y", "rotate_y_deg"},
    Option{"--rotate-z", "rotate_z_deg"},
    Option{"--supports", "supports"},
    Option{"--keep-all", "keep_all = true", false},
    Option{"--orient", "orient"},
    Option{"--floor", "floor"},
    Option{"--height", "height"},
    Option{"--length", "length"},
    Option{"--width", "width"},
    Option{"--depth", "depth"},
    Option{"--scale", "scale"},
    Option{"--units", "units"},
    Option{"--as", "as"},
    Option{"--base", "base"},
    Option{"--fit", "fit = true", false},
};

bool ends_word(char c) { return c == ' ' || c == ',' || c == '.' || c == ';' || c == ':' || c == ')'; }

/// A number, or a word that an option takes.
bool is_argument(std::string_view word) {
  constexpr std::array<std::string_view, 10> kWords = {"auto", "keep", "none", "flat", "mm",
                                                       "cm",   "m",    "in",   "true", "false"};
  if (word.starts_with('-')) word.remove_prefix(1);
  const bool number = !word.empty() && std::isdigit(static_cast<unsigned char>(word[0])) != 0;
  return number || std::find(kWords.begin(), kWords.end(), word) != kWords.end();
}

const Option* option_at(std::string_view text) {
  for (const Option& option : kOptions) {
    if (!text.starts_with(option.name)) continue;
    if (text.size() == option.name.size() || ends_word(text[option.name.size()])) return &option;
  }
  return nullptr;
}

/// What somebody does about it in the printer's settings, or "".
std::string_view by_settings(ToldCode told) {
  switch (told) {
    case ToldCode::kTooWide:
    case ToldCode::kTooDeep: return "Under Settings, turn it or print it smaller.";
    case ToldCode::kTooHigh: return "Under Settings, tilt it or print it smaller.";
    case ToldCode::kTooHighOnSupports: return "Under Settings, tilt it, or print it smaller or without supports.";
    case ToldCode::kTooManySupports: return "Under Settings, turn or tilt it.";
    case ToldCode::kTooSmall: return "Under Settings, choose a height.";
    default: return {};
  }
}

}  // namespace

FixedText<1000> in_stick_words(std::string_view text) {
  FixedText<1000> result;
  bool rewritten = false;
  while (!text.empty()) {
    const Option* const option = option_at(text);
    if (option == nullptr) {
      result.add("%c", text[0]);
      text.remove_prefix(1);
      continue;
    }
    rewritten = true;
    text.remove_prefix(option->name.size());
    result.add("%.*s", static_cast<int>(option->key.size()), option->key.data());
    if (!option->takes_argument || !text.starts_with(' ')) continue;
    const auto rest = text.substr(1);
    auto length = std::min(rest.find_first_of(" ,;:)"), rest.size());
    if (length > 0 && rest[length - 1] == '.') --length;
    const auto word = rest.substr(0, length);
    if (!is_argument(word)) continue;
    const bool number = (word[0] == '-' || std::isdigit(static_cast<unsigned char>(word[0])) != 0) &&
                        std::isalpha(static_cast<unsigned char>(word.back())) == 0;  // 80mm is a text
    const char* const quote = number || word == "true" || word == "false" ? "" : "\"";
    result.add(" = %s%.*s%s", quote, static_cast<int>(word.size()), word.data(), quote);
    text.remove_prefix(1 + length);
  }
  if (rewritten && result.view().find("job.toml") == std::string_view::npos) result.add(" (in job.toml on the stick)");
  return result;
}

FixedText<1000> in_stick_words(std::string_view text, ToldCode told) {
  const FixedText<1000> of_job_file = in_stick_words(text);
  const std::string_view first = by_settings(told);
  if (first.empty()) return of_job_file;
  FixedText<1000> result;
  result.add("%.*s", static_cast<int>(first.size()), first.data());
  if (of_job_file.view().empty()) return result;
  result.add(" Or %c%s", std::tolower(static_cast<unsigned char>(of_job_file.view()[0])), of_job_file.c_str() + 1);
  return result;
}

}  // namespace plumbline
