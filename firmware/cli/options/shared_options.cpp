#include "firmware/cli/options/shared_options.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/cli/options/accepted_values.hpp"
#include "firmware/settings/print_length.hpp"
#include "firmware/settings/print_profile.hpp"
#include "firmware/settings/setting_words.hpp"
#include "slicer/checks/issue.hpp"
#include "slicer/reader/scan_sources.hpp"

namespace plumbline::firmware {
namespace {

constexpr std::array kUnits = {Units::kMillimetres, Units::kCentimetres, Units::kMetres, Units::kInches, Units::kAuto};

std::vector<std::string> unit_names() {
  std::vector<std::string> names;
  names.reserve(kUnits.size());
  for (const Units units : kUnits) names.emplace_back(to_string(units));
  return names;
}

/// @param name  one of unit_names()
Units units_named(const std::string& name) {
  return *std::find_if(kUnits.begin(), kUnits.end(), [&](Units units) { return name == to_string(units); });
}

/// @param name  "none", "flat" or "auto"
BaseChoice base_named(const std::string& name) {
  for (const BaseChoice choice : {BaseChoice::kNone, BaseChoice::kFlat}) {
    if (name == to_string(choice)) return choice;
  }
  return BaseChoice::kAuto;
}

/// @param name  "auto", "points" or "mesh"
ReadAs as_named(const std::string& name) {
  for (const ReadAs as : {ReadAs::kPoints, ReadAs::kMesh}) {
    if (name == to_string(as)) return as;
  }
  return ReadAs::kAuto;
}

/// @param name  one of the words
std::size_t index_of(std::span<const std::string_view> words, const std::string& name) {
  return static_cast<std::size_t>(std::find(words.begin(), words.end(), name) - words.begin());
}

/// "light 0.3, 0.3 and 0.8; medium 0.4, 0.4 and 1; ..."
std::string preset_figures() {
  std::string text;
  for (const SupportPreset& preset : kSupportPresets) {
    text += (text.empty() ? "" : "; ") + std::string(preset.name) + " " + number(preset.head_front_diameter) + ", " +
            number(preset.head_penetration) + " and " + number(preset.pillar_diameter);
  }
  return text;
}

/// @returns --printer, which others depend on
CLI::Option* add_printer_options(CLI::App& app, JobOptions& job) {
  auto* printer = app.add_option("--printer", job.printer,
                                 "A printer's name, such as mono2k, or its board file. Without it the grid fits the "
                                 "object")
                      ->type_name("NAME")
                      ->group(kPrinterGroup);
  app.add_option("--layer-height", job.layer_height_mm,
                 "Height of a layer, 0.005 to 1 mm [0.05, or the printer's]. A print may also have \"adaptive\": as "
                 "the surface allows, thin "
                 "where shallow tops make stairs, thick where walls are steep")
      ->type_name("MM")
      ->transform(layer_height())
      ->group(kPrinterGroup);
  app.add_option("--pixel-pitch", job.pixel_pitch_mm, "Pixel size without a printer, 0.005 to 1 mm [0.05]")
      ->type_name("MM")
      ->check(number_from(kFinestMm, kCoarsestMm, "mm"))
      ->excludes(printer)
      ->group(kPrinterGroup);
  return printer;
}

/// --height and its like, which exclude each other and the options given.
void add_size_options(CLI::App& app, JobOptions& job, CLI::Option* scale, CLI::Option* fit) {
  std::vector<CLI::Option*> others = {scale, fit};
  for (const Side side : {Side::kHeight, Side::kWidth, Side::kDepth, Side::kLength}) {
    auto* size = app.add_option_function<std::string>(
                        std::string("--") + to_string(side),
                        [&job, side](const std::string& text) {
                          job.size = PrintSize{side, *parse_length(text)};
                        },
                        side == Side::kHeight  ? "Make it this high along the scan's z, such as 80mm, 8cm or 3.15in "
                                                 "[as scanned]. Sizes are those of the scan as it came: turning it "
                                                 "changes none"
                        : side == Side::kWidth ? "Make it this wide along the scan's x"
                        : side == Side::kDepth ? "Make it this deep along the scan's y: the height where y points up"
                                               : "Make the longest of these three sides this long")
                     ->type_name("LENGTH")
                     ->check(CLI::Validator(
                         [](std::string& text) -> std::string {
                           if (parse_length(text)) return {};
                           return "'" + printable(text, 40) + "' is not " + kLengthForm;
                         },
                         ""))
                     ->group(kObjectGroup);
    for (CLI::Option* other : others) size->excludes(other);
    others.push_back(size);
  }
}

void add_object_options(CLI::App& app, JobOptions& job, CLI::Option* printer) {
  app.add_option_function<std::string>(
         "--as", [&job](const std::string& name) { job.as = as_named(name); },
         "A PLY or OBJ file with faces is a mesh if they are the surface of an object, else a scan: points ignores its "
         "faces, mesh uses them [auto]")
      ->type_name("KIND")
      ->check(one_of({"auto", "points", "mesh"}))
      ->group(kObjectGroup);
  app.add_option_function<std::string>(
         "--units", [&job](const std::string& name) { job.units = units_named(name); },
         "Unit of the scan: mm, cm, m, in, or auto, the one that makes a plausible size [mm]")
      ->type_name("UNIT")
      ->check(one_of(unit_names()))
      ->group(kObjectGroup);
  auto* scale = app.add_option("--scale", job.scale, "Print it this many times as large as it was scanned [1]")
                    ->type_name("F")
                    ->check(number_from(kSmallestScale, kLargestScale))
                    ->group(kObjectGroup);
  auto* fit = app.add_flag("--fit", job.fit, "Print it as large as the printer can")
                  ->needs(printer)
                  ->excludes(scale)
                  ->group(kObjectGroup);
  add_size_options(app, job, scale, fit);
  auto* orient =
      app.add_option_function<std::string>(
             "--orient", [&job](const std::string& word) { job.orient = word == "auto"; },
             "auto turns it to its best orientation, none leaves it as it is [none]. See 'plumbline orient --help'")
          ->type_name("KIND")
          ->check(one_of({"none", "auto"}))
          ->group(kObjectGroup);
  app.add_option_function<std::string>(
         "--keep-clean", [&job](const std::string& word) { job.keep_clean = *clean_side_named(word); },
         "Choose an orientation that keeps supports off this side of the scan as it came, such as a face: " +
             std::string(kCleanSideForm) + " [none]")
      ->type_name("SIDE")
      ->check(one_of({kCleanSideWords.begin(), kCleanSideWords.end()}))
      ->needs(orient)
      ->group(kObjectGroup);
  const char* const names[] = {"--rotate-x", "--rotate-y", "--rotate-z"};
  const char* const help[] = {"Turn it about x by so many degrees, right-handed; done first [0]",
                              "Turn it about y; done second [0]", "Turn it about z; done last [0]"};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    app.add_option(names[axis], job.rotate_degrees[axis], help[axis])
        ->type_name("DEG")
        ->check(number_from(-360, 360, "degrees"))
        ->excludes(orient)
        ->group(kObjectGroup);
  }
  app.add_option_function<std::string>(
         "--floor", [&job](const std::string& text) { job.floor = *parse_floor(text); },
         "A floor or turntable that the object stands on: auto finds it and cuts it off, keep prints it, a number cuts "
         "at that height of the scan, in its unit [auto]")
      ->type_name("KIND")
      ->check(CLI::Validator(
          [](std::string& text) -> std::string {
            if (parse_floor(text)) return {};
            return "'" + printable(text, 40) + "' is not " + kFloorForm;
          },
          ""))
      ->group(kObjectGroup);
  app.add_option_function<std::string>(
         "--base", [&job](const std::string& name) { job.base = base_named(name); },
         "Underside: auto closes it flat if the surface is open there, flat always does, none closes it like any other "
         "hole [auto]")
      ->type_name("KIND")
      ->check(one_of({"none", "flat", "auto"}))
      ->group(kObjectGroup);
  app.add_flag("--keep-all", job.keep_all, "Keep stray pieces apart from the object, and small cavities in it")
      ->group(kObjectGroup);
}

/// "island, overhang, ..."
std::string issue_keys() {
  std::string text;
  for (const IssueWords& words : kIssueWords) {
    if (!text.empty()) text += ", ";
    text += words.key;
  }
  return text;
}

/// @param text  "island=refuse"
void set_check(const std::string& text, CheckChoice& choice) {
  const auto equals = text.find('=');
  const std::string kind = text.substr(0, equals);
  const std::string word = equals == std::string::npos ? "" : text.substr(equals + 1);
  const auto* const action = std::find(kCheckActionWords.begin(), kCheckActionWords.end(), word);
  bool found = false;
  for (std::size_t i = 0; action != kCheckActionWords.end() && i < kIssueKindCount; ++i) {
    if (kind != "all" && kind != kIssueWords[i].key) continue;
    choice.actions[i] = static_cast<CheckAction>(action - kCheckActionWords.begin());
    found = true;
  }
  if (found) return;
  throw CLI::ValidationError("--check: '" + printable(text) + "' is not KIND=ACTION. KIND is all, " + issue_keys() +
                             "; ACTION is ignore, warn, ask or refuse");
}

}  // namespace

CLI::Option* add_job_options(CLI::App& app, JobOptions& job) {
  auto* scan = app.add_option("scan", job.scans,
                              "A scan (PLY, PCD, OBJ, E57, LAS, PTX, SPZ, or text: XYZ, XYZRGB, PTS, ASC, TXT, CSV) or "
                              "a mesh (STL, OBJ, PLY, OFF, 3MF). Several files in one frame make one object, and so do "
                              "the files of a folder. A .conf beside them that says where they lie is used")
                   ->required()
                   ->expected(1, static_cast<int>(kMostScans))
                   ->type_name("SCAN");
  CLI::Option* printer = add_printer_options(app, job);
  add_object_options(app, job, printer);
  return scan;
}

void add_program_options(CLI::App& app, JobOptions& job) {
  app.add_option("--arena-mib", job.arena_mib,
                 "Memory for slicing, MiB; a scan too large for it is thinned [the printer's, or all there is]")
      ->type_name("N")
      ->check(whole_number_from(1, 1U << 20U))
      ->group(kProgramGroup);
  app.add_option("--threads", job.threads, "1 to 64; the layers are the same [OMP_NUM_THREADS, or up to 8 cores]")
      ->type_name("N")
      ->check(whole_number_from(1, kMostThreads))
      ->group(kProgramGroup);
  auto* verbose =
      app.add_flag("-v,--verbose", job.verbose, "Also print times, memory and counts")->group(kProgramGroup);
  app.add_flag("--quiet", job.quiet, "Print errors only")->excludes(verbose)->group(kProgramGroup);
  app.add_flag("--json", job.json, "Print the report as one JSON object and nothing else")
      ->excludes(verbose)
      ->group(kProgramGroup);
}

std::string option_name(std::string_view key) {
  std::string name = "--" + std::string(key);
  std::replace(name.begin(), name.end(), '_', '-');
  return name;
}

void add_correction_option(CLI::App& app, JobOptions& job) {
  app.add_option("--absolute-correction", job.absolute_correction_mm,
                 "Move the outlines of all layers by this much, inwards if below 0, since light cures walls too far "
                 "out: -0.5 to 0.5 mm [the profile's, or 0]")
      ->type_name("MM")
      ->check(number_from(-kMostMoved, kMostMoved, "mm"))
      ->group(kObjectGroup);
}

void add_check_options(CLI::App& app, CheckChoice& choice) {
  app.add_option_function<std::vector<std::string>>(
         "--check",
         [&choice](const std::vector<std::string>& texts) {
           for (const std::string& text : texts) set_check(text, choice);
         },
         "What to do about an issue, such as all=refuse [the printer's profile, or warn]. KIND is all, or one of " +
             issue_keys() + "; ACTION is ignore, warn, ask or refuse. May be repeated")
      ->type_name("KIND=ACTION")
      ->take_all()
      ->group(kChecksGroup);
  app.add_flag("--accept", choice.accept, "Go on with issues that the profile asks about")->group(kChecksGroup);
}

void add_support_options(CLI::App& app, SupportChoice& choice, const char* default_kind) {
  app.add_option_function<std::string>(
         "--supports", [&choice](const std::string& kind) { choice.enable = kind == "auto"; },
         std::string("auto puts supports under islands and overhangs, none leaves them out ") + default_kind)
      ->type_name("KIND")
      ->check(one_of({"none", "auto"}))
      ->group(kSupportsGroup);
  app.add_option_function<std::string>(
         "--support-stand",
         [&choice](const std::string& name) { choice.stand = static_cast<SupportStand>(index_of(kStandWords, name)); },
         "plate puts any object on the plate, raised lifts any by --support-object-elevation and the raft, auto lifts "
         "those without a flat underside [auto; raised with --support-object-elevation]")
      ->type_name("KIND")
      ->check(one_of({kStandWords.begin(), kStandWords.end()}))
      ->group(kSupportsGroup);
  app.add_option_function<std::string>(
         "--support-preset", [&choice](const std::string& name) { choice.preset = index_of(kPresetWords, name); },
         "Head front diameter, head penetration and pillar diameter at once, mm, each of which may also be given: " +
             preset_figures() + " [medium]")
      ->type_name("KIND")
      ->check(one_of({kPresetWords.begin(), kPresetWords.end()}))
      ->group(kSupportsGroup);
  app.add_flag_function(
         "--support-buildplate-only", [&choice](std::int64_t count) { choice.buildplate_only = count > 0; },
         "Let no support end on the object; a place that none reaches from the plate gets none")
      ->group(kSupportsGroup);
  constexpr const char* kFrame =
      "Places are in mm as findings give them: x and y from the corner of the mask, z from the plate. They hold for "
      "one "
      "size and orientation. May be repeated, such as ";
  const std::array help = {
      std::string("Add a support here, even where none is needed. ") + kFrame + "--support-at 12.5,3,20.1",
      std::string("Let no other support touch the object within R mm of this place [2]. ") + kFrame +
          "--no-support-at 40,22,8,1.5"};
  for (std::size_t i = 0; i < kPlaceFields.size(); ++i) {
    const std::string name = option_name(kPlaceFields[i].key);
    app.add_option_function<std::vector<std::string>>(
           name,
           [&choice, name, i](const std::vector<std::string>& texts) {
             for (const std::string& text : texts) {
               const std::string_view wrong = text.empty() ? " " : add_places(text, kPlaceFields[i], choice.places[i]);
               if (wrong.empty()) continue;
               throw CLI::ValidationError(name + ": '" + printable(wrong) + "' is not one of up to 32 " +
                                          kPlaceFields[i].allowed);
             }
           },
           help[i])
        ->type_name(kPlaceFields[i].has_radius() ? "X,Y,Z[,R]" : "X,Y,Z")
        ->take_all()
        ->allow_extra_args(false)
        ->group(kSupportsGroup);
  }
  for (std::size_t i = 0; i < kSupportFields.size(); ++i) {
    const SupportField& field = kSupportFields[i];
    const std::string name = option_name(field.key);
    char range[64];
    std::snprintf(range, sizeof range, ", %g to %g %s [%g]", field.low, field.high, field.unit.data(),
                  SupportSettings().*field.member);
    app.add_option(name, choice.values[i], std::string(field.help) + range)
        ->type_name(field.unit == "deg"   ? "DEG"
                    : field.unit == "mm2" ? "MM2"
                    : field.unit == "%"   ? "PERCENT"
                                          : "MM")
        ->check(number_from(field.low, field.high, field.unit.data()))
        ->group(kSupportsGroup);
  }
}

CLI::Option* add_slicing_options(CLI::App& app, JobOptions& job, SupportChoice& supports, CheckChoice& checks) {
  CLI::Option* scan = add_job_options(app, job);
  add_correction_option(app, job);
  add_support_options(app, supports, "[auto]");
  add_check_options(app, checks);
  add_program_options(app, job);
  app.callback([&supports] {
    if (const auto settings = supports.over(true, {}); !settings) {
      throw CLI::ValidationError(settings.error().message());
    }
  });
  return scan;
}

void add_look_options(CLI::App& app, JobOptions& job, std::string& picture, const char* drawn) {
  app.add_option("--picture", picture, drawn)->type_name("PNG");
  add_job_options(app, job);
  add_program_options(app, job);
}

}  // namespace plumbline::firmware
