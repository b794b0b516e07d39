#include <CLI/CLI.hpp>
#include <vector>

#include "firmware/cli/commands.hpp"
#include "firmware/cli/options/accepted_values.hpp"
#include "firmware/cli/reports/status_text.hpp"
#include "firmware/cli/scan_upload.hpp"
#include "firmware/io/progress_lines.hpp"
#include "firmware/io/text/json_cursor.hpp"
#include "firmware/io/text/json_writer.hpp"
#include "firmware/state/client_request.hpp"
#include "firmware/state/state_link.hpp"

namespace plumbline::firmware {
namespace {

constexpr const char* kControlFooter =
    "\nExamples:\n"
    "  plumbline ctl start                    print what is on the stick\n"
    "  plumbline ctl choose 2                 take the second scan of 'plumbline status'\n"
    "  plumbline ctl open 1                   list its first folder; 0 goes back up\n"
    "  plumbline ctl set scale 1.5            a key of job.toml for this print; board/README.md has all of them\n"
    "  plumbline ctl set reset \"\"             take all of them back\n"
    "  plumbline ctl settings                 instead of printing what has been sliced, change its settings\n"
    "  plumbline ctl propose                  find the best orientations: 'plumbline status' lists them\n"
    "  plumbline ctl set proposal 2           take the second of them; 0 keeps the scan as it is\n"
    "  plumbline ctl upload bust.ply          put a scan into the printer's store: it is offered as on a stick\n"
    "  plumbline ctl remove bust.ply          remove it from there; 'plumbline status' has its name\n"
    "  plumbline ctl plate-empty              after a print: somebody has looked, and the plate is empty\n"
    "  plumbline ctl filled                   the tank is full; 'filled 50': it holds 50 ml\n"
    "  plumbline ctl resume --socket PATH     of a daemon with another socket\n"
    "\n"
    "Who may command is who may write to the socket: root and the group plumbline.\n";

struct Word {
  Command command;
  const char* about;
};
constexpr Word kWords[] = {
    {Command::kStart, "Print what is offered"},
    {Command::kPause, "Raise the part after this layer, and wait"},
    {Command::kResume, "Go on after a pause, or with an interrupted print"},
    {Command::kCancel, "Leave what is offered, stop reading, or end the print"},
    {Command::kPlateEmpty, "Say that the plate is empty"},
    {Command::kFilled, "Say that the tank is full, or how much resin it holds"},
    {Command::kSeen, "Say that you have read the fault"},
    {Command::kOffer, "Offer what is on the stick again"},
    {Command::kChoose, "Choose a scan by its number in 'plumbline status'"},
    {Command::kOpen, "List a folder of the stick by its number in 'plumbline status'"},
    {Command::kSet, "Change a setting of the print that is offered"},
    {Command::kSettings, "Go back from what has been sliced to its settings"},
    {Command::kPropose, "Find the best orientations of the scan that is offered"},
    {Command::kUpload, "Put a scan into the printer's store, in place of the one there"},
    {Command::kRemove, "Remove the scan from the printer's store"},
};

std::string request_line(const ControlOptions& options) {
  TextBuffer<1024> line;
  JsonWriter json(line);
  json.begin_object(JsonWriter::Layout::kOneLine);
  json.member("do", options.command);
  json.member("id", std::uint32_t{1});
  if (!options.about.empty()) json.member("for", options.about);
  if (options.command == to_string(Command::kChoose)) json.member("scan", options.scan);
  if (options.command == to_string(Command::kOpen)) json.member("folder", options.folder);
  if (options.command == to_string(Command::kSet)) {
    json.member("key", options.key);
    json.member("value", options.value);
  }
  if (options.command == to_string(Command::kRemove)) json.member("name", options.name);
  if (options.command == to_string(Command::kFilled) && options.ml) json.member("ml", *options.ml);
  json.end_object();
  if (!json.finish()) return {};
  return std::string(line.view());
}

}  // namespace

CLI::App* add_control_command(CLI::App& app, ControlOptions& options) {
  auto* command = app.add_subcommand("ctl", "Command the running daemon: start, pause, resume, cancel, ...");
  command->footer(kControlFooter);
  command->require_subcommand(1);
  command->fallthrough();
  command->add_option("--socket", options.socket, "The daemon's state socket [/run/plumbline/state]")
      ->type_name("PATH");
  command
      ->add_option(
          "--for", options.about,
          "Only if it is still about this: \"asks\", or the job's \"id\", of 'plumbline status --json'. Without it an\n"
          "answer counts from a second after the question on")
      ->type_name("ID");
  for (const Word& word : kWords) {
    auto* verb = command->add_subcommand(std::string(to_string(word.command)), word.about);
    verb->callback([&options, verb] { options.command = verb->get_name(); });
    if (word.command == Command::kChoose) {
      verb->add_option("number", options.scan, "1 is the first")
          ->required()
          ->type_name("N")
          ->check(whole_number_from(1, UINT32_MAX));
    }
    if (word.command == Command::kOpen) {
      verb->add_option("number", options.folder, "1 is the first; 0 is the folder above")
          ->required()
          ->type_name("N")
          ->check(whole_number_from(0, UINT32_MAX));
    }
    if (word.command == Command::kSet) {
      verb->add_option("key", options.key, "Such as scale, supports, layer_height")->required()->type_name("KEY");
      verb->add_option("value", options.value,
                       "A number, a word, true, false, or places such as \"12.5,3,20.1; 40,22,8\"")
          ->required()
          ->type_name("VALUE");
    }
    if (word.command == Command::kFilled) {
      verb->add_option("ml", options.ml, "Resin in the tank [a full tank]")
          ->type_name("ML")
          ->check(number_from(0, 20000));
    }
    if (word.command == Command::kUpload) {
      verb->add_option("file", options.file, "A scan, a mesh or a sliced archive")->required()->type_name("FILE");
    }
    if (word.command == Command::kRemove) {
      verb->add_option("name", options.name, "Its name in 'plumbline status'")->required()->type_name("NAME");
    }
  }
  return command;
}

ExitCode run_control(const ControlOptions& options) {
  if (options.command == to_string(Command::kUpload)) {
    const auto name = upload_scan(options.socket, options.file);
    if (!name) return report_error(name.error());
    write_line("in the printer's store: " + *name);
    return ExitCode::kDone;
  }
  const std::string line = request_line(options);
  if (line.empty() || line.size() > kLongestRequest) {
    return report_error(Error::format(ErrorCode::kBadSetting, "%s: the value is too long",
                                      options.key.empty() ? "name" : options.key.c_str()));
  }
  auto link = StateLink::open(options.socket, true);
  if (!link) return report_error(link.error());
  if (const auto sent = link->send(line); !sent) return report_error(sent.error());
  const auto reply = link->next_of_type("reply");
  if (!reply) return report_error(reply.error());
  if (json_member(*reply, "ok") == "true") return ExitCode::kDone;
  return report_error(Error::format(ErrorCode::kBadSetting, "%s.\t%s", json_text(*reply, "error").c_str(),
                                    json_text(*reply, "advice").c_str()));
}

}  // namespace plumbline::firmware
