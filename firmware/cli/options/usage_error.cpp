#include "firmware/cli/options/usage_error.hpp"

#include <algorithm>
#include <string_view>
#include <vector>

#include "firmware/settings/setting_words.hpp"
#include "slicer/reader/scan_sources.hpp"

namespace plumbline::firmware {
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
  // A subcommand also takes those of what it belongs to.
  for (const CLI::App* app = &sub; app != nullptr; app = app->get_parent()) {
    for (const CLI::Option* option : app->get_options()) {
      for (const auto& name : option->get_lnames()) names.push_back("--" + name);
    }
  }
  return quoted(word) + " is not an option" + suggestion(word, {names.begin(), names.end()});
}

/// The options that are missing: "SCAN is required", "SCAN and --output are required". "" if none is.
std::string missing_options(const CLI::App& sub) {
  std::vector<std::string> missing;
  for (const CLI::Option* option :
       sub.get_options([](const CLI::Option* each) { return each->get_required() && each->empty(); }))
    missing.push_back(option->get_positional() ? option->get_type_name() : option->get_name());
  std::string text;
  for (std::size_t i = 0; i < missing.size(); ++i)
    text += (i == 0 ? "" : i + 1 < missing.size() ? ", " : " and ") + missing[i];
  if (!text.empty()) text += missing.size() > 1 ? " are required" : " is required";
  return text;
}

bool is_option(const std::string& word) { return word.size() > 1 && word.front() == '-'; }

}  // namespace

std::string usage_message(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App* found = &app;
  std::string name = app.get_name();
  while (!found->get_subcommands().empty()) {
    found = found->get_subcommands().front();
    name += " " + found->get_name();
  }
  const CLI::App& sub = *found;
  const bool has_subcommands = sub.get_require_subcommand_min() > 0;
  const std::string help = " '" + name + " --help' ";
  // Without those of its subcommands, which have been given already.
  const auto rest = app.remaining(true);
  const auto option = std::find_if(rest.begin(), rest.end(), is_option);
  const std::string all = sub.get_help_all_ptr() != nullptr ? " '" + name + " --help-all' " : help;
  if (option != rest.end()) return name + ": " + unknown_option(sub, *option) + all + "lists them.";
  if (has_subcommands) return name + ": " + unknown_subcommand(sub, rest) + ";" + help + "explains them.";
  if (!rest.empty()) return name + ": " + quoted(rest.front()) + " is one argument too many.";
  const std::string_view what = error.what();
  if (error.get_name() == "ArgumentMismatch" && what.starts_with("scan:"))
    return name + ": too many files. A scan may have up to " + std::to_string(kMostScans) + ".";
  const std::string missing = error.get_name() == "RequiredError" ? missing_options(sub) : "";
  const std::string said = missing.empty() ? std::string(what) : missing;
  return name + ": " + said + (said.ends_with('?') ? "" : ".") + (missing.empty() ? all : help) + "lists the options.";
}

}  // namespace plumbline::firmware
