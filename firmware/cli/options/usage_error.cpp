#include "firmware/cli/options/usage_error.hpp"

#include <string_view>
#include <vector>

#include "firmware/settings/setting_words.hpp"
#include "slicer/reader/scan_sources.hpp"

namespace plumbline {
namespace {

/// In quotes, so that a sentence can begin with it.
std::string quoted(const std::string& word) { return "'" + printable(word) + "'"; }

/// "; did you mean --supports?" or "".
std::string suggestion(std::string_view word, const std::vector<std::string_view>& known) {
  const auto near = nearest_within(word, known);
  return near ? "; did you mean " + std::string(*near) + "?" : std::string(".");
}

std::string unknown_subcommand(const CLI::App& app, const std::vector<std::string>& rest) {
  std::vector<std::string> names;
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(sub->get_name());
  const std::vector<std::string_view> known(names.begin(), names.end());
  const std::string all = "Subcommands are " + joined(known);
  if (rest.empty()) return "no subcommand given. " + all;
  return quoted(rest.front()) + " is not a subcommand" + suggestion(rest.front(), known) + " " + all;
}

std::string unknown_option(const CLI::App& sub, const std::string& given) {
  const std::string word = given.substr(0, given.find('='));
  std::vector<std::string> names;
  for (const CLI::Option* option : sub.get_options()) {
    for (const auto& name : option->get_lnames()) names.push_back("--" + name);
  }
  return quoted(word) + " is not an option" + suggestion(word, {names.begin(), names.end()});
}

bool is_option(const std::string& word) { return word.size() > 1 && word.front() == '-'; }

}  // namespace

std::string usage_message(const CLI::App& app, const CLI::ParseError& error) {
  const auto parsed = app.get_subcommands();
  const CLI::App& sub = parsed.empty() ? app : *parsed.front();
  const std::string name = parsed.empty() ? "plumbline" : "plumbline " + sub.get_name();
  const std::string more = " '" + name + " --help' explains them.";
  const auto rest = sub.remaining();
  for (const auto& word : rest) {
    if (is_option(word)) return name + ": " + unknown_option(sub, word) + " '" + name + " --help' lists them.";
  }
  if (parsed.empty()) return name + ": " + unknown_subcommand(app, rest) + ";" + more;
  if (!rest.empty()) return name + ": " + quoted(rest.front()) + " is one argument too many.";
  if (error.get_name() == "ArgumentMismatch" && std::string_view(error.what()).starts_with("scan:")) {
    return name + ": too many files. A scan may have up to " + std::to_string(kMostScans) + ".";
  }
  return name + ": " + error.what() + ". '" + name + " --help' lists the options.";
}

}  // namespace plumbline
