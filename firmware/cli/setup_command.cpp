#include <fcntl.h>
#include <linux/fs.h>
#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "firmware/cli/doctor.hpp"
#include "firmware/cli/options/accepted_values.hpp"
#include "firmware/io/interrupt.hpp"
#include "firmware/io/progress_lines.hpp"
#include "firmware/settings/settings_file.hpp"
#include "firmware/settings/settings_folders.hpp"
#include "firmware/setup/setup.hpp"

namespace plumbline::firmware {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSetupFooter =
    "\nExamples:\n"
    "  plumbline setup my_printer.toml                      begin as a Raspberry Pi with a monochrome panel\n"
    "  plumbline setup my_printer.toml --like pine64_ls055  begin as another printer\n"
    "  plumbline setup --list                               what this board has, as a board file names it\n"
    "  plumbline setup my_printer.toml --answers FILE       no questions: lines such as panel.columns = 1440\n"
    "  plumbline setup try.toml --simulated board/sim2k.toml   try it on a simulated printer that is built like that "
    "file\n"
    "\n"
    "Run it on the printer's own board, as root or as the user plumbline, while plumblined is stopped. It asks what\n"
    "nobody can measure, then measures with you: which way the panel shows a picture, which way and how far the stage\n"
    "moves, how bright the lamp is. The lamp lights only after a yes, once, for seconds; Ctrl-C, stop and the end "
    "stop\n"
    "end every move. It writes the file only at the end, and never over another; then plumbline doctor checks it.\n"
    "\n"
    "Exit status: 0 written and ready to print, 1 something is wrong, 2 wrong command line, 130 stopped: nothing was "
    "written.\n";

tl::unexpected<Error> cannot_write(const std::string& path, int reason) {
  if (reason == EEXIST) {
    return fail(ErrorCode::kCannotWrite, "%s: exists already.\tName another file, or move this one away",
                PrintableText(path, 200).c_str());
  }
  return fail(ErrorCode::kCannotWrite, "%s: %s", PrintableText(path, 200).c_str(), std::strerror(reason));
}

/// Writes a file that does not exist, whole or not at all.
Status write_new(const std::string& path, const std::string& text) {
  const std::string made = path + ".new-" + std::to_string(::getpid());
  const auto written = write_file(made.c_str(), std::as_bytes(std::span(text)));
  if (!written) ::unlink(made.c_str());
  PLUMBLINE_TRY(written);
  if (::renameat2(AT_FDCWD, made.c_str(), AT_FDCWD, path.c_str(), RENAME_NOREPLACE) == 0) return {};
  const int reason = errno;
  ::unlink(made.c_str());
  return cannot_write(path, reason);
}

/// A measurement that fails leaves the answers as they are. A person reads why and goes on; a file of answers ends.
Status measure(Dialogue& dialogue, bool may_go_on, const Status& measured) {
  if (measured || !may_go_on) return measured;
  // With a lamp that does not go dark nothing else is measured.
  const ErrorCode code = measured.error().code();
  if (code == ErrorCode::kCancelled || code == ErrorCode::kLampStuckOn) return measured;
  dialogue.say(std::string("  Not measured: ") + measured.error().message());
  return {};
}

Expected<BoardFile> set_up(const SetupOptions& options, Dialogue& dialogue, BoardDraft& draft) {
  const std::string name = fs::path(options.output).stem().string();
  if (const auto named = draft.set("printer", "name", name, ""); !named) {
    return fail(ErrorCode::kBadSetting, "%s: the file's name becomes the printer's: %s",
                PrintableText(options.output, 150).c_str(), named.error().message());
  }
  SimulationOptions simulation;
  if (!options.simulated.empty()) {
    auto built = read_board_file(options.simulated);
    PLUMBLINE_TRY(built);
    PLUMBLINE_TRY(machine_of(*built, built->path));
    simulation.simulate = true;
    simulation.computing = 0;
    simulation.speedup = options.speedup;
    simulation.lamp_line = options.lamp_line;
    simulation.faults = options.faults;
    simulation.built = std::move(*built);
  }
  if (!simulation.simulate) dialogue.say(to_text(board_parts()));
  dialogue.say("Press return to take what is in [ ]: the value of " + draft.like_name() + ".");
  PLUMBLINE_TRY(ask_about_printer(dialogue, draft, name));
  const auto profile = read_print_profile(draft.value("print", "profile"), draft.values().path);
  PLUMBLINE_TRY(profile);
  const auto ready = dialogue.ask_yes(
      {"measure", "measure now? The printer is switched on, its cover closes, and nothing is in its way", "", "yes"});
  PLUMBLINE_TRY(ready);
  if (*ready) {
    const OpenMachine open = [&](const BoardFile& board) {
      return open_back_end(board, *board.machine, *profile, simulation);
    };
    const bool person = options.answers.empty();
    PLUMBLINE_TRY(measure(dialogue, person, measure_panel(dialogue, draft, open)));
    PLUMBLINE_TRY(measure(dialogue, person, measure_stage(dialogue, draft, open)));
    PLUMBLINE_TRY(measure(dialogue, person, measure_lamp(dialogue, draft, open, *profile)));
  }
  return draft.board();
}

/// What doctor finds on this board.
ExitCode examine(Dialogue& dialogue, const BoardFile& board) {
  dialogue.say("\nplumbline doctor --printer " + board.name + ".toml");
  const auto findings = examine_machine(board, *board.machine);
  if (!findings) return report_error(findings.error());
  OutputFile out = OutputFile::standard_output();
  if (const auto written = write_findings(out, board.name, *findings); !written) return report_error(written.error());
  return prints(*findings) ? ExitCode::kDone : ExitCode::kWorldError;
}

}  // namespace

CLI::App* add_setup_command(CLI::App& app, SetupOptions& options) {
  auto* command = app.add_subcommand("setup", "Make the board file of a printer: asks, and measures with you");
  command->footer(kSetupFooter);
  command->add_option("file", options.output, "The board file to write; its name is the printer's")
      ->type_name("NAME.toml");
  command->add_option("--like", options.like, "The board file whose values are offered: rpi4_dxq608 by default")
      ->type_name("NAME");
  command->add_option("--answers", options.answers, "Answers instead of questions: a line NAME = ANSWER for each")
      ->type_name("FILE");
  command
      ->add_option("--simulated", options.simulated,
                   "Measure a simulated printer that is built as this board file says")
      ->type_name("NAME");
  command
      ->add_option("--speedup", options.speedup,
                   "Simulated seconds per second, 0.1 to 1000000 [as fast as this machine can]")
      ->type_name("N")
      ->check(number_from(0.1, 1e6));
  command
      ->add_option("--lamp-line", options.lamp_line,
                   "Line that plumbline-keeper switches together with the simulated lamp; file:PATH records the "
                   "changes. Needs --speedup")
      ->type_name("LINE");
  command
      ->add_option("--fault", options.faults,
                   "What goes wrong with the simulated printer, such as lamp.stuck_on@t=0s; may be repeated")
      ->type_name("FAULT")
      ->take_all();
  command->add_flag("--list", options.list, "List what this board has, and nothing else");
  command->callback([&options] {
    if (options.list == options.output.empty()) return;
    throw CLI::ValidationError("name the board file to write, or --list, not both");
  });
  return command;
}

ExitCode run_setup(const SetupOptions& options) {
  if (options.list) {
    OutputFile out = OutputFile::standard_output();
    const auto listed = out.write(to_text(board_parts()) + "\n");
    return listed ? ExitCode::kDone : report_error(listed.error());
  }
  catch_interrupts();
  if (!options.output.ends_with(".toml")) {
    return report_error(Error::format(ErrorCode::kBadSetting, "%s: a board file's name ends with .toml",
                                      PrintableText(options.output, 200).c_str()));
  }
  // Said before the questions; that it can't be overwritten is made sure of at the end.
  if (::access(options.output.c_str(), F_OK) == 0) return report_error(cannot_write(options.output, EEXIST).value());
  if (const auto can = check_can_create(options.output.c_str()); !can) return report_error(can.error());
  // A simulated printer is like itself, unless somebody wants to see setup find the difference.
  auto draft = BoardDraft::like(!options.like.empty()        ? options.like
                                : !options.simulated.empty() ? options.simulated
                                                             : "rpi4_dxq608");
  if (!draft) return report_error(draft.error());
  std::unique_ptr<Dialogue> dialogue = std::make_unique<TerminalDialogue>();
  const WrittenAnswers* written_answers = nullptr;
  if (!options.answers.empty()) {
    const auto text = read_settings_text(options.answers, "a file of answers");
    if (!text) return report_error(text.error());
    auto answers = WrittenAnswers::parse(*text, options.answers);
    if (!answers) return report_error(answers.error());
    written_answers = answers->get();
    dialogue = std::move(*answers);
  }
  const auto board = set_up(options, *dialogue, *draft);
  if (!board) return report_error(board.error());
  if (written_answers != nullptr) {
    if (const auto used = written_answers->check_all_used(); !used) return report_error(used.error());
  }
  if (const auto written = write_new(options.output, draft->text()); !written) {
    // Nobody answers all that twice.
    OutputFile out = OutputFile::standard_output();
    static_cast<void>(out.write(draft->text()));
    return report_error(written.error());
  }
  dialogue->say("\nWrote " + options.output + ".");
  if (!options.simulated.empty() || board->machine->simulated) return ExitCode::kDone;
  return examine(*dialogue, *board);
}

}  // namespace plumbline::firmware
