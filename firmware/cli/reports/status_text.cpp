#include "firmware/cli/reports/status_text.hpp"

#include <charconv>
#include <functional>
#include <optional>
#include <vector>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/io/text/json_cursor.hpp"

namespace plumbline::firmware {
namespace {

/// 0 if it is null, no number, or not there.
double json_number(std::string_view object, std::string_view key) {
  double number = 0;
  if (const auto value = json_member(object, key))
    std::from_chars(value->data(), value->data() + value->size(), number);
  return number;
}

/// Whether an object has a member that is not null.
bool has(std::string_view object, std::string_view key) {
  const auto value = json_member(object, key);
  return value && value != "null";
}

std::string_view object_of(std::string_view object, std::string_view key) {
  return json_member(object, key).value_or(std::string_view());
}

void for_each_element(std::string_view array, const std::function<void(std::string_view)>& visit) {
  JsonCursor cursor(array);
  if (!cursor.take('[') || cursor.take(']')) return;
  do {
    const auto element = cursor.take_value(4);
    if (!element) return;
    visit(*element);
  } while (cursor.take(','));
}

std::string text_of(std::string_view value) {
  std::string room(value.size() + 1, '\0');
  JsonCursor cursor(value);
  const auto text = cursor.take_text(room);
  return text ? std::string(*text) : std::string();
}

void add_line(std::string& page, std::string_view name, std::string_view text) {
  FixedText<16> column;
  column.add("%-10.*s", static_cast<int>(name.size()), name.data());
  page += column.view();
  page += text;
  page += '\n';
}

void add_stick(std::string& page, std::string_view state) {
  const auto stick = object_of(state, "stick");
  const bool is_uploaded = json_member(stick, "uploaded") == "true";
  if (json_member(stick, "present") != "true" && !is_uploaded) return;
  const auto chosen = json_number(object_of(state, "job"), "number");
  bool any = false;
  for_each_element(object_of(stick, "scans"), [&](std::string_view scan) {
    const double number = json_number(scan, "number");
    const std::string problem = json_text(scan, "problem");
    FixedText<512> line;
    FixedText<160> name;
    const double files = json_number(scan, "files");
    if (files > 1) name.add("%.0f scans as one: ", files);
    name.add("%s%s", json_text(scan, "name").c_str(), files > 1 ? ", ..." : "");
    line.add("%c %2.0f  %-30s %9.1f MB%s%s", number == chosen ? '*' : ' ', number, name.c_str(),
             json_number(scan, "bytes") / 1e6, problem.empty() ? "" : "  ", problem.c_str());
    add_line(page, any ? "" : is_uploaded ? "uploaded" : "scans", line.view());
    any = true;
  });
  if (!any && !is_uploaded) add_line(page, "stick", "in the port");
  const std::string folder = json_text(stick, "folder");
  any = false;
  const auto add_folder = [&](double number, const std::string& name, double entries) {
    FixedText<200> line;
    line.add("  %2.0f  %s", number, name.c_str());
    if (entries > 0) line.add("/, %.0f inside", entries);
    add_line(page, any ? "" : "folders", line.view());
    any = true;
  };
  if (!folder.empty()) add_folder(0, "back up: this is " + folder, 0);
  for_each_element(object_of(stick, "folders"), [&](std::string_view one) {
    add_folder(json_number(one, "number"), json_text(one, "name"), json_number(one, "entries"));
  });
  if (has(stick, "not_listed")) add_line(page, "", json_text(stick, "not_listed"));
}

void add_proposals(std::string& page, std::string_view state) {
  if (!has(state, "proposals")) return;
  const auto job = object_of(state, "job");
  for_each_element(object_of(state, "proposals"), [&](std::string_view way) {
    const double number = json_number(way, "number");
    const bool chosen = has(job, "proposal") && json_number(job, "proposal") == number;
    FixedText<200> line;
    line.add("%c %.0f  x %.4g, y %.4g degrees: %.3g ml to support, %.4g mm high, largest layer %.3g cm2",
             chosen ? '*' : ' ', number, json_number(way, "rotate_x_deg"), json_number(way, "rotate_y_deg"),
             json_number(way, "support_ml"), json_number(way, "height_mm"), json_number(way, "peel_mm2") / 100);
    add_line(page, number == 0 ? "oriented" : "", line.view());
  });
}

void add_stored(std::string& page, std::string_view state) {
  if (!has(state, "stored")) return;
  const auto stored = object_of(state, "stored");
  FixedText<200> line;
  line.add("%s, %.1f MB, uploaded", json_text(stored, "name").c_str(), json_number(stored, "bytes") / 1e6);
  add_line(page, "stored", line.view());
}

void add_progress(std::string& page, std::string_view state) {
  if (has(state, "progress")) {
    const auto progress = object_of(state, "progress");
    FixedText<200> line;
    line.add("%.0f of %.0f, at %.2f mm", json_number(progress, "layers_done"), json_number(progress, "layers"),
             json_number(progress, "height_mm"));
    if (has(progress, "slack_s")) line.add(", masks ready %.1f s early", json_number(progress, "slack_s"));
    add_line(page, "layers", line.view());
    if (has(progress, "ends_at")) add_line(page, "ends", json_text(progress, "ends_at"));
  }
  if (has(state, "resin")) {
    const auto resin = object_of(state, "resin");
    FixedText<200> line;
    line.add("%.1f of %.1f ml, a full tank has %.0f ml", json_number(resin, "used_ml"), json_number(resin, "needed_ml"),
             json_number(resin, "tank_ml"));
    add_line(page, "resin", line.view());
  }
  if (has(state, "machine")) {
    const auto machine = object_of(state, "machine");
    FixedText<200> tank, used;
    tank.add("%.1f ml of resin", json_number(machine, "resin_ml"));
    add_line(page, "tank", has(machine, "resin_ml") ? tank.view() : "nobody has said how much resin");
    used.add("lamp %.1f h, film %.0f layers", json_number(machine, "lamp_h"), json_number(machine, "film_layers"));
    add_line(page, "used", used.view());
  }
}

void add_fault(std::string& page, std::string_view state) {
  if (!has(state, "fault")) return;
  const auto fault = object_of(state, "fault");
  const std::string message = json_text(fault, "message");
  add_line(page, "fault",
           json_text(fault, "code") + ", " + json_text(fault, "title") + (message.empty() ? "" : ": ") + message);
  add_line(page, "", json_text(fault, "meaning"));
  add_line(page, "do", json_text(fault, "remedy"));
}

}  // namespace

std::string json_text(std::string_view object, std::string_view key) {
  const auto value = json_member(object, key);
  return value ? text_of(*value) : std::string();
}

std::string status_page(std::string_view state) {
  std::string page;
  add_line(page, "printer",
           json_text(state, "printer") + (json_member(state, "simulated") == "true" ? ", simulated" : ""));
  add_line(page, "state", json_text(state, "state"));
  if (has(state, "message")) add_line(page, "", json_text(state, "message"));
  if (has(state, "question")) add_line(page, "question", json_text(state, "question"));
  if (has(state, "job")) {
    const auto job = object_of(state, "job");
    add_line(page, "job",
             json_text(job, "scan") + ", profile " + json_text(job, "profile") +
                 (has(job, "result") ? ": " + json_text(job, "result") : ""));
    std::vector<std::string> files;
    for_each_element(object_of(job, "files"), [&](std::string_view file) { files.push_back(text_of(file)); });
    for (std::size_t i = 0; files.size() > 1 && i < files.size(); ++i) add_line(page, i == 0 ? "files" : "", files[i]);
  }
  add_progress(page, state);
  add_stick(page, state);
  add_stored(page, state);
  add_proposals(page, state);
  for_each_element(object_of(state, "findings"), [&](std::string_view finding) {
    add_line(page, json_text(finding, "severity"), json_text(finding, "text"));
  });
  add_fault(page, state);
  std::string commands;
  for_each_element(object_of(state, "commands"),
                   [&](std::string_view command) { commands += (commands.empty() ? "" : ", ") + text_of(command); });
  if (!commands.empty()) add_line(page, "ctl", commands);
  return page;
}

std::string prints_page(std::string_view state) {
  std::string page;
  for_each_element(object_of(state, "prints"), [&page](std::string_view print) {
    FixedText<400> line;
    FixedText<40> layers;
    layers.add("%.0f of %.0f layers", json_number(print, "layers_done"), json_number(print, "layers"));
    line.add("%4.0f  %-20s  %-9s  %-19s  %7.1f ml  %s%s\n", json_number(print, "number"),
             json_text(print, "ended_at").c_str(), json_text(print, "result").c_str(), layers.c_str(),
             json_number(print, "resin_ml"), json_text(print, "scan").c_str(),
             json_member(print, "preview") == "true" ? "" : "  (no preview)");
    page += line.view();
  });
  return page.empty() ? "no print is kept yet\n" : page;
}

std::string status_line(std::string_view state) {
  if (!has(state, "fault")) return json_text(state, "state") + ": " + json_text(state, "message");
  const auto fault = object_of(state, "fault");
  return json_text(fault, "code") + ", " + json_text(fault, "title") + ". " + json_text(fault, "remedy");
}

}  // namespace plumbline::firmware
