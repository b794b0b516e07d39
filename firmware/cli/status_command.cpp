#include <CLI/CLI.hpp>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "firmware/cli/commands.hpp"
#include "firmware/cli/options/accepted_values.hpp"
#include "firmware/cli/reports/status_text.hpp"
#include "firmware/io/output_file.hpp"
#include "firmware/io/text/json_cursor.hpp"
#include "firmware/state/state_link.hpp"

namespace plumbline::firmware {
namespace {

constexpr const char* kStatusFooter =
    "\nExamples:\n"
    "  plumbline status                                what the printer does, what it waits for, and what is wrong\n"
    "  plumbline status --follow                       a line for each change, until the daemon ends\n"
    "  plumbline status --json --follow                the same for programs: firmware/state/README.md explains each "
    "member\n"
    "  plumbline status --picture layer -o layer.png   the mask of the layer that is printed\n"
    "  plumbline status --prints                       the last prints, whose reports the printer keeps\n"
    "  plumbline status --report 12 -o 12.json         the report of print 12; --preview 12 writes its picture\n"
    "  plumbline status --socket state/state           of another daemon, such as a simulated printer's\n";

/// Bytes of a base64 text without line breaks. @returns none: it is none
std::optional<std::vector<std::byte>> bytes_of_base64(std::string_view text) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<std::byte> bytes;
  unsigned bits = 0;
  int count = 0;
  while (text.ends_with('=')) text.remove_suffix(1);
  for (const char c : text) {
    const auto digit = kDigits.find(c);
    if (digit == std::string_view::npos) return std::nullopt;
    bits = bits << 6U | static_cast<unsigned>(digit);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<std::byte>(bits >> count & 255U));
  }
  return bytes;
}

}  // namespace

CLI::App* add_status_command(CLI::App& app, StatusOptions& options) {
  auto* command = app.add_subcommand("status", "Show what the running daemon does");
  command->footer(kStatusFooter);
  command->add_option("--socket", options.socket, "The daemon's state socket [/run/plumbline/state]")
      ->type_name("PATH");
  command->add_flag("--follow", options.follow, "Go on: a line for each change");
  command->add_flag("--json", options.json, "For programs: the socket's own lines");
  auto* picture = command
                      ->add_option("--picture", options.picture,
                                   "Write a picture to --output: the preview of what was sliced, where its masks have "
                                   "issues, or the layer being printed")
                      ->type_name("NAME")
                      ->check(one_of({"preview", "issues", "layer"}));
  auto* output =
      command->add_option("-o,--output", options.output, "File for the picture or the report")->type_name("FILE");
  auto* prints = command->add_flag("--prints", options.prints, "List the last prints, newest first");
  auto* report =
      command
          ->add_option(
              "--report", options.report,
              "Write the report (JSON) of a print that --prints lists to --output; the printer must be at rest")
          ->type_name("N")
          ->check(whole_number_from(1, UINT32_MAX));
  auto* preview =
      command->add_option("--preview", options.preview, "The same for the picture (PNG) of what was printed")
          ->type_name("N")
          ->check(whole_number_from(1, UINT32_MAX));
  const std::array<CLI::Option*, 4> choices = {prints, picture, report, preview};
  for (CLI::Option* const choice : choices) {
    if (choice != prints) choice->needs(output)->excludes("--json");
    choice->excludes("--follow");
    for (CLI::Option* const other : choices) {
      if (other != choice) choice->excludes(other);
    }
  }
  return command;
}

namespace {

struct Fetched {
  std::vector<std::byte> bytes;
  std::size_t size = 0;  ///< of the whole report; 0: it is a picture
};

/// @param member  of the reply: that with the bytes, in base64
Expected<Fetched> fetch(StateLink& link, const std::string& question, std::string_view member) {
  PLUMBLINE_TRY(link.send(question + "\n"));
  const auto reply = link.next_of_type("reply");
  PLUMBLINE_TRY(reply);
  if (json_member(*reply, "ok") != "true") {
    std::array<char, 1024> room;
    JsonCursor error(json_member(*reply, "error").value_or("null"));
    const auto said = error.take_text(room).value_or("the daemon refused");
    return fail(ErrorCode::kCannotRead, "%.*s", static_cast<int>(said.size()), said.data());
  }
  std::string_view text = json_member(*reply, member).value_or("");
  auto bytes = text.size() < 2 ? std::nullopt : bytes_of_base64(text.substr(1, text.size() - 2));
  if (!bytes) return fail(ErrorCode::kMalformed, "the daemon's reply has no bytes");
  Fetched fetched{std::move(*bytes)};
  const std::string_view size = json_member(*reply, "size").value_or("0");
  std::from_chars(size.data(), size.data() + size.size(), fetched.size);
  return fetched;
}

/// Asks for a picture or a report and writes it into a file.
Status fetch_file(const StatusOptions& options) {
  auto link = StateLink::open(options.socket, false);
  PLUMBLINE_TRY(link);
  if (options.report == 0) {
    const std::string print = options.preview > 0 ? ", \"print\": " + std::to_string(options.preview) : "";
    const std::string name = options.preview > 0 ? "preview" : options.picture;
    const auto picture = fetch(*link, R"({"do": "picture", "picture": ")" + name + "\"" + print + "}", "png");
    PLUMBLINE_TRY(picture);
    return write_file(options.output.c_str(), picture->bytes);
  }
  std::vector<std::byte> report;
  for (;;) {
    const auto part = fetch(*link,
                            R"({"do": "report", "print": )" + std::to_string(options.report) +
                                ", \"from\": " + std::to_string(report.size()) + "}",
                            "data");
    PLUMBLINE_TRY(part);
    report.insert(report.end(), part->bytes.begin(), part->bytes.end());
    if (report.size() >= part->size) break;
    if (part->bytes.empty()) return fail(ErrorCode::kTruncated, "the report ends early");
  }
  return write_file(options.output.c_str(), report);
}

}  // namespace

ExitCode run_status(const StatusOptions& options) {
  if (!options.output.empty() && options.picture.empty() && options.report == 0 && options.preview == 0) {
    return report_error(Error::format(ErrorCode::kBadSetting,
                                      "--output has nothing to write;\tname it with --picture, --report or --preview"));
  }
  if (!options.output.empty()) {
    const auto fetched = fetch_file(options);
    return fetched ? ExitCode::kDone : report_error(fetched.error());
  }
  auto link = StateLink::open(options.socket, false);
  if (!link) return report_error(link.error());
  const auto first = link->next_of_type("state");
  if (!first) return report_error(first.error());
  OutputFile out = OutputFile::standard_output();
  if (const auto told = out.write(options.json     ? *first + "\n"
                                  : options.prints ? prints_page(*first)
                                                   : status_page(*first));
      !told) {
    return report_error(told.error());
  }
  std::string shown = status_line(*first);
  while (options.follow) {
    const auto line = link->next_line(std::nullopt);
    if (!line) return report_error(line.error());
    if (!*line) break;
    std::string text = options.json ? **line : status_line(**line);
    if (!options.json && text == shown) continue;
    if (const auto told = out.write(text + "\n"); !told) return report_error(told.error());
    shown = std::move(text);
  }
  return ExitCode::kDone;
}

}  // namespace plumbline::firmware
