#include "firmware/cli/doctor.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "firmware/io/output_file.hpp"
#include "firmware/io/text/json_writer.hpp"

namespace plumbline::firmware {
namespace {

constexpr const char* kDoctorFooter =
    "\nExamples:\n"
    "  plumbline doctor --printer my_printer.toml\n"
    "\n"
    "Run it on the printer's own board. It looks for every line, panel, sensor, fan, stick port and permission that a "
    "print\n"
    "needs, and says what it found, what is wrong and what to do. It moves and lights nothing and disturbs no print.\n"
    "\n"
    "Exit status: 0 ready to print, 1 something is wrong, 2 wrong command line.\n";

using Verdict = MachineFinding::Verdict;

const char* word_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::kGood: return "ok";
    case Verdict::kPoor: return "poor";
    case Verdict::kWrong: return "WRONG";
  }
  return "";
}

std::size_t count(std::span<const MachineFinding> findings, Verdict verdict) {
  return static_cast<std::size_t>(std::count_if(
      findings.begin(), findings.end(), [verdict](const MachineFinding& one) { return one.verdict == verdict; }));
}

std::string padded(std::string text, std::size_t width) {
  text.resize(std::max(width, text.size() + 1), ' ');
  return text;
}

}  // namespace

CLI::App* add_doctor_command(CLI::App& app, DoctorOptions& options) {
  auto* command = app.add_subcommand("doctor", "Check the hardware of the printer this runs on");
  command->footer(kDoctorFooter);
  command->add_option("--printer", options.printer, "The printer's name or board file")->required()->type_name("NAME");
  command->add_flag("--json", options.json, "Print the findings as one JSON object and nothing else");
  return command;
}

bool prints(std::span<const MachineFinding> findings) { return count(findings, Verdict::kWrong) == 0; }

Status write_findings(OutputFile& out, const std::string& printer, std::span<const MachineFinding> findings) {
  constexpr std::size_t kVerdict = 7;
  std::size_t widest = 0;
  for (const auto& one : findings) widest = std::max(widest, one.what.size());
  const auto shown = [](const std::string& from_the_board) {
    return std::string(PrintableText(from_the_board).view());
  };
  std::string text = "printer " + printer + "\n";
  for (const auto& one : findings) {
    text +=
        "  " + padded(word_of(one.verdict), kVerdict) + padded(shown(one.what), widest + 2) + shown(one.found) + "\n";
    if (!one.advice.empty()) text += std::string(2 + kVerdict, ' ') + "-> " + shown(one.advice) + "\n";
  }
  text += std::to_string(count(findings, Verdict::kGood)) + " good, " +
          std::to_string(count(findings, Verdict::kPoor)) + " poor, " +
          std::to_string(count(findings, Verdict::kWrong)) +
          " wrong: " + (prints(findings) ? "ready to print" : "it can't print until what is wrong is fixed") + "\n";
  return out.write(text);
}

Status write_findings_json(OutputFile& out, const std::string& printer, std::span<const MachineFinding> findings) {
  JsonWriter json(out);
  json.begin_object();
  json.member("printer", std::string_view(printer));
  json.member("prints", prints(findings));
  json.begin_array("findings");
  for (const auto& one : findings) {
    json.begin_object();
    json.member("verdict", std::string_view(one.verdict == Verdict::kWrong  ? "wrong"
                                            : one.verdict == Verdict::kPoor ? "poor"
                                                                            : "good"));
    json.member("what", std::string_view(one.what));
    json.member("found", std::string_view(one.found));
    json.member("advice", std::string_view(one.advice));
    json.end_object();
  }
  json.end_array();
  json.end_object();
  return json.finish();
}

ExitCode run_doctor(const DoctorOptions& options) {
  const auto board = read_board_file(options.printer);
  if (!board) return report_error(board.error());
  const auto machine = machine_of(*board, board->path);
  if (!machine) return report_error(machine.error());
  const auto findings = examine_machine(*board, *machine);
  if (!findings) return report_error(findings.error());
  OutputFile out = OutputFile::standard_output();
  const auto written =
      options.json ? write_findings_json(out, board->name, *findings) : write_findings(out, board->name, *findings);
  if (!written) return report_error(written.error());
  return prints(*findings) ? ExitCode::kDone : ExitCode::kWorldError;
}

}  // namespace plumbline::firmware
