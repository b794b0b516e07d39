/// Every screen, against a picture that a person has looked at, and against what must hold for all of them: all texts of the table fit,
/// none lies on another one.

#include "firmware/screen/screens.hpp"

#include <gtest/gtest.h>
#include <lodepng.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "firmware/messages/catalogue.hpp"
#include "firmware/messages/printer_code.hpp"
#include "firmware/messages/told_text.hpp"
#include "firmware/print/status/fault.hpp"
#include "firmware/screen/light_card.hpp"
#include "firmware/screen/remedy_rows.hpp"
#include "firmware/screen/screen_kind.hpp"
#include "firmware/screen/setting_rows.hpp"
#include "tests/firmware/screen/screen_fixture.hpp"

namespace plumbline::firmware {
namespace {

using enum PrintState;

struct Size {
  int columns, rows;
};
constexpr Size kSmall{320, 240}, kMiddle{800, 480};
/// Panels that one can buy, upright ones too.
constexpr std::array kSizes = {kSmall, Size{480, 320}, kMiddle, Size{1024, 600}, Size{480, 800}, Size{1280, 720}};

void find_units_guessed(PrinterRecord& record) {
  Remedies remedies;
  for (const char* unit : {"cm", "m", "in"}) remedies.add("units", unit);
  record.add_finding(
      Severity::kWarning,
      "the scan's unit is not stated: mm is a guess, and makes it 62.1 mm long. If that is wrong, choose "
      "a height under Settings",
      {PrinterCode::kUnitsGuessed, {{Fact::kLongestMm, 62.1}}, "mm"}, remedies);
}

/// The screens that have a golden picture.
std::vector<ScreenCase> golden_cases() {
  const auto with = [](PrintState state, const std::function<void(PrinterRecord&, ScreenView&)>& change = {}) {
    return [=](PrinterRecord& record, ScreenView& view) {
      fill_in(record, state);
      if (change) change(record, view);
    };
  };
  const auto some_checks = [](PrinterRecord& record, std::size_t passed) {
    for (std::size_t i = 0; i < passed; ++i) record.checks[i].outcome = CheckOutcome::kPassed;
    record.checks[2].outcome = CheckOutcome::kWarned;
  };
  const auto upload = [](PrinterRecord& record) {
    record.has_stick = false;
    record.scans_uploaded = true;
    record.scan_count = 1;
    assign(record.stored.emplace().name, record.scans[0].name.view());
  };
  return {
      {"idle", with(kIdle, [](auto& record, auto&) { record.has_stick = false, record.scan_count = 0; })},
      {"idle-with-machine", with(kIdle,
                                 [](auto& record, auto&) {
                                   record.has_stick = false, record.scan_count = 0;
                                   record.machine = &some_machine();
                                 })},
      {"idle-with-address", with(kIdle,
                                 [](auto& record, auto&) {
                                   record.has_stick = false, record.scan_count = 0;
                                   record.machine = &some_machine();
                                   assign(record.address, "http://192.168.178.105:8080");
                                 })},
      {"idle-with-stick", with(kIdle)},
      {"idle-with-upload", with(kIdle,
                                [](auto& record, auto&) {
                                  record.has_stick = false, record.scan_count = 0;
                                  assign(record.stored.emplace().name, "bust.ply");
                                })},
      {"idle-with-prints", with(kIdle,
                                [](auto& record, auto&) {
                                  record.has_stick = false, record.scan_count = 0;
                                  record.prints = &some_prints();
                                })},
      {"prints", with(kIdle,
                      [](auto& record, auto& view) {
                        record.prints = &some_prints();
                        view.prints_open = true;
                        view.print = 1;
                      })},
      {"prints-resumed", with(kIdle,
                              [](auto& record, auto& view) {
                                record.prints = &some_prints();
                                view.prints_open = true;
                                view.print = 2;
                              })},
      {"lights", with(kIdle,
                      [](auto&, auto& view) {
                        view.lights_open = true;
                        view.pattern = 5;
                      })},
      {"scans", with(kOffered)},
      {"scans-seen", with(kOffered,
                          [](auto& record, auto&) {
                            record.scan_pictures = &some_scan_pictures();
                            record.scans[0].picture = 1;
                            record.scans[2].picture = 2;
                            record.job->chosen = 2;
                            assign(record.job->scan, "gear wheel 40 teeth.xyz");
                          })},
      {"scans-as-one", with(kOffered,
                            [](auto& record, auto&) {
                              ScanRecord& scan = record.scans[record.scan_count++];
                              assign(scan.name, "statue/back.ply");
                              scan.files = 3;
                              scan.bytes = 61'400'000;
                              record.job->chosen = 3;
                              assign(record.job->scan, "statue/back.ply and 2 more");
                              for (const char* file : {"statue/back.ply", "statue/front.ply", "statue/top.ply"}) {
                                assign(record.job->files[record.job->file_count++], file);
                              }
                            })},
      {"scans-folders", with(kOffered,
                             [](auto& record, auto& view) {
                               record.scan_count = 1;
                               record.folder_count = 2;
                               assign(record.folders[0].name, "Büsten");
                               record.folders[0].entries = 3;
                               assign(record.folders[1].name, "prints of the last two years");
                               record.folders[1].entries = 212;
                               assign(record.folder, "projects/museum");
                               record.left_out = {20'123, 121, 2, {}, PrinterCode::kStickNotListed};
                               assign(record.left_out.text,
                                      "not listed: 20123 files, 121 folders, 2 partitions that can't be read");
                               record.left_out.told.add(Fact::kCount, 20'123);
                               record.left_out.told.add(static_cast<Fact>(PrinterFact::kFolders), 121);
                               record.left_out.told.add(static_cast<Fact>(PrinterFact::kPartitions), 2);
                               view.row = ListRow::kFolder;
                               view.folder = 1;
                             })},
      {"scans-broken", with(kOffered,
                            [](auto& record, auto&) {
                              record.job->chosen = 1;
                              assign(record.job->scan, "broken.ply");
                            })},
      {"scans-uploaded", with(kOffered,
                              [=](auto& record, auto& view) {
                                upload(record);
                                view.row = ListRow::kRemove;
                              })},
      {"delete-question", with(kOffered,
                               [=](auto& record, auto& view) {
                                 upload(record);
                                 view.row = ListRow::kRemove;
                                 view.asks_to_remove = true;
                               })},
      {"settings", with(kOffered,
                        [](auto&, auto& view) {
                          view.row = ListRow::kSettings;
                          view.settings_open = true;
                          view.setting = 1;
                        })},
      {"proposals", with(kOffered,
                         [](auto& record, auto& view) {
                           record.proposals = some_proposals();
                           record.pictures = &pictures_with_proposals();
                           record.job->rotate_x_deg = -90;
                           view.row = ListRow::kSettings;
                           view.settings_open = view.proposals_open = true;
                           view.setting = 4;
                           view.proposal = 2;
                         })},
      {"settings-way", with(kOffered,
                            [](auto& record, auto& view) {
                              record.proposals = some_proposals();
                              record.job->rotate_x_deg = -65;
                              record.job->rotate_y_deg = 10.5;
                              view.row = ListRow::kSettings;
                              view.settings_open = true;
                              view.setting = 4;
                            })},
      {"proposing", with(kSlicing,
                         [](auto& record, auto& view) {
                           record.slicing = SlicingRecord{Stage::kTrees, 0.4, true, 0.4};
                           view.settings_open = view.proposals_open = true;
                         })},
      {"reading", with(kSlicing,
                       [](auto& record, auto&) {
                         record.slicing = SlicingRecord{Stage::kRays, 0.62, false, 0.62};
                       })},
      {"preview", with(kOffered,
                       [](auto& record, auto&) {
                         record.sliced = a_sliced_job();
                         record.pictures = &pictures_with_issues();
                         record.add_finding(Severity::kWarning,
                                            "2 overhangs, the largest of 12.1 mm2 (4850 px) at x 34.2, y 61.0 mm in "
                                            "layer 803 (40.15 mm): add supports, set them closer with "
                                            "support_overhang_span, or turn the object",
                                            {PrinterCode::kOverhang,
                                             {{Fact::kCount, 2},
                                              {Fact::kAreaMm2, 12.13},
                                              {Fact::kXMm, 34.2},
                                              {Fact::kYMm, 61},
                                              {Fact::kLayer, 803},
                                              {Fact::kFromMm, 40.15}}});
                         record.add_finding(Severity::kWarning, "1 suction cup at layer 20, 3.2 ml");
                       })},
      {"preview-mended", with(kOffered,
                              [](auto& record, auto&) {
                                record.sliced = a_sliced_job();
                                find_units_guessed(record);
                              })},
      {"remedies", with(kOffered,
                        [](auto& record, auto& view) {
                          record.sliced = a_sliced_job();
                          find_units_guessed(record);
                          record.add_finding(Severity::kWarning, "1 suction cup at layer 20, 3.2 ml");
                          view.remedies_open = true;
                          view.remedy = 1;
                        })},
      {"remedies-size", with(kOffered,
                             [](auto& record, auto& view) {
                               record.sliced = a_sliced_job();
                               Remedies remedies;
                               remedies.add("height", "40.15mm");
                               record.add_finding(Severity::kWarning,
                                                  "the object will be 39.85 mm high instead of 40 mm: what reaches "
                                                  "beyond that is noise, or too thin to print",
                                                  {PrinterCode::kSizeOff,
                                                   {{PrinterFact::kDeliveredMm, 39.85}, {PrinterFact::kAskedMm, 40}}},
                                                  remedies);
                               view.remedies_open = true;
                             })},
      {"preview-clean", with(kOffered, [](auto& record, auto&) { record.sliced = a_sliced_job(); })},
      {"contract", with(kOffered,
                        [](auto& record, auto& view) {
                          record.sliced = a_sliced_job();
                          view.contract_open = true;
                          view.value = index_of(PrintKey::kExposureTime) + 1;
                        })},
      {"contract-settings", with(kOffered,
                                 [](auto& record, auto& view) {
                                   record.sliced = a_sliced_job();
                                   view.contract_open = true;
                                 })},
      {"checks", with(kChecks, [=](auto& record, auto&) { some_checks(record, 7); })},
      {"homing", with(kHoming, [=](auto& record, auto&) { some_checks(record, 10); })},
      {"printing", with(kPrinting)},
      {"cancel-question", with(kPrinting, [](auto&, auto& view) { view.asks_to_cancel = true; })},
      {"paused", with(kPaused)},
      {"paused-question",
       with(kPaused,
            [](auto& record, auto&) {
              assign(record.question,
                     "the part must be 30.65 mm tall (613 layers). Measure it: press start if it is, cancel if it is "
                     "taller");
              record.question_told = {PrinterCode::kMeasurePart, {{Fact::kHeightMm, 30.65}, {Fact::kLayers, 613}}};
            })},
      {"cover-open", with(kCoverOpen)},
      {"cooling-down", with(kCoolingDown)},
      {"resin-low", with(kFeedMe)},
      {"raising", with(kFinishing)},
      {"finished", with(kPlateInUse,
                        [](auto& record, auto&) {
                          record.result = kFinished;
                          PrintStatus status = status_of(kFinished);
                          status.layer = status.layers;
                          status.height = ZPosition(Distance::millimetres(80.2));
                          status.resin_ml = 34.4;
                          record.set_progress(status, 1'900'000'000);
                          record.state = kPlateInUse;
                        })},
      {"plate-in-use", with(kPlateInUse)},
      {"interrupted", with(kInterrupted)},
      {"fault", with(kFault,
                     [](auto& record, auto&) {
                       record.set_fault(FaultCode::kStageStalled, "the motor lost 240 steps at 30.65 mm",
                                        info(FaultCode::kStageStalled).next);
                     })},
      {"fault-of-scan",
       with(kFault,
            [](auto& record, auto&) {
              const Told told(
                  ToldCode::kTooHigh,
                  {{Fact::kHeightMm, 182.4}, {Fact::kLimitMm, 150}, {Fact::kExcessMm, 32.4}, {Fact::kMostScale, 0.82}});
              record.set_fault(
                  FaultCode::kDoesNotFit,
                  "the object is 182.40 mm high (z), but the printer has room for 150.00 mm: 32.40 mm too much",
                  filled_in(english_remedies(told.code).remedy, told, Language::kEnglish).view(), told);
            })},
      {"ending", with(kSuspended)},
      {"page-code", with(kPrinting, [](auto& record, auto&) { assign(record.code, "482913"); })},
  };
}

std::string name_of(const std::string& name, Size size, Language language) {
  return name + "-" + std::to_string(size.columns) + (language == Language::kGerman ? "-de" : "");
}

std::vector<std::uint8_t> rgb_of(const DrawnScreen& screen) {
  std::vector<std::uint8_t> rgb;
  for (const Colour pixel : screen.pixels) {
    rgb.insert(rgb.end(), {red_of(pixel), green_of(pixel), blue_of(pixel)});
  }
  return rgb;
}

void write_png(const std::string& path, std::span<const std::uint8_t> rgb, Size size) {
  lodepng::State state;
  state.info_raw.colortype = LCT_RGB;
  state.encoder.zlibsettings.windowsize = 32768;
  state.encoder.zlibsettings.nicematch = 258;
  std::vector<unsigned char> file;
  ASSERT_EQ(
      lodepng::encode(file, rgb.data(), static_cast<unsigned>(size.columns), static_cast<unsigned>(size.rows), state),
      0U);
  ASSERT_EQ(lodepng::save_file(file, path), 0U) << path;
}

/// FNV-1a of the pixels.
std::string hash_of(std::span<const std::uint8_t> bytes) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const std::uint8_t byte : bytes) hash = (hash ^ byte) * 0x100000001b3;
  std::ostringstream text;
  text << std::hex << hash;
  return text.str();
}

constexpr const char* kGolden = PLUMBLINE_SOURCE_DIR "/tests/firmware/screen/golden";

/// The hashes of the screens that are too large to be kept as pictures: "preview-800 0123456789abcdef", a line each.
std::map<std::string, std::string> golden_hashes() {
  std::map<std::string, std::string> hashes;
  std::ifstream file(std::string(kGolden) + "/hashes.txt");
  for (std::string name, hash; file >> name >> hash;) hashes[name] = hash;
  return hashes;
}

std::vector<std::uint8_t> drawn(const ScreenCase& what, Size size, Language language) {
  const auto record = std::make_unique<PrinterRecord>();
  ScreenView view;
  what.change(*record, view);
  return rgb_of(DrawnScreen(size.columns, size.rows, *record, view, language));
}

// PLUMBLINE_LOOK_AT=FOLDER writes all pictures there. Look at them, then copy those for 320 and hashes.txt to golden/.
TEST(Screens, LookAsTheyDidWhenAPersonLookedAtThem) {
  const char* const folder = std::getenv("PLUMBLINE_LOOK_AT");
  std::ofstream hashes;
  if (folder != nullptr) hashes.open(std::string(folder) + "/hashes.txt");
  const auto known = golden_hashes();
  for (const ScreenCase& one : golden_cases()) {
    for (const auto& [size, language] : {std::pair(kSmall, Language::kEnglish), std::pair(kMiddle, Language::kEnglish),
                                         std::pair(kSmall, Language::kGerman)}) {
      const std::string name = name_of(one.name, size, language);
      SCOPED_TRACE(name);
      if (one.name == "idle-with-address" && !QrCode::is_built()) continue;
      const std::vector<std::uint8_t> rgb = drawn(one, size, language);
      if (folder != nullptr) {
        write_png(folder + ("/" + name) + ".png", rgb, size);
        hashes << name << ' ' << hash_of(rgb) << '\n';
        continue;
      }
      ASSERT_TRUE(known.contains(name));
      EXPECT_EQ(known.at(name), hash_of(rgb)) << "the screen has changed";
      if (size.columns != kSmall.columns || language != Language::kEnglish) continue;
      std::vector<std::uint8_t> golden;
      unsigned columns = 0, rows = 0;
      ASSERT_EQ(lodepng::decode(golden, columns, rows, std::string(kGolden) + "/" + name + ".png", LCT_RGB, 8), 0U);
      EXPECT_TRUE(golden == rgb) << "hashes.txt is not that of the picture";
    }
  }
}

TEST(Screens, ThereIsAGoldenPictureOfEachKind) {
  std::set<ScreenKind> kinds;
  for (const ScreenCase& one : golden_cases()) {
    const auto record = std::make_unique<PrinterRecord>();
    ScreenView view;
    one.change(*record, view);
    kinds.insert(screen_of(*record));
  }
  EXPECT_EQ(kinds.size(), kScreenKindCount);
}

/// What is wrong with the texts of a screen.
void expect_fits(const DrawnScreen& screen) {
  const auto notes = screen.page.notes();
  EXPECT_GT(notes.size(), 0U);
  for (std::size_t i = 0; i < notes.size(); ++i) {
    const PixelBox& box = notes[i].box;
    EXPECT_FALSE(notes[i].too_long) << "text " << i << " at " << box.x << ", " << box.y << " is cut";
    EXPECT_EQ(common(box, screen.canvas.all()), box) << "text " << i << " leaves the screen";
    for (std::size_t k = i + 1; k < notes.size(); ++k) {
      const PixelBox both = common(box, notes[k].box);
      EXPECT_TRUE(both.empty()) << "texts " << i << " and " << k << " meet at " << both.x << ", " << both.y;
    }
  }
}

/// Each case in each size and language.
template <class Change>
void expect_all_fit(const Change& change) {
  for (const Size size : kSizes) {
    for (const Language language : {Language::kEnglish, Language::kGerman}) {
      SCOPED_TRACE(std::to_string(size.columns) + " x " + std::to_string(size.rows) +
                   (language == Language::kGerman ? ", German" : ", English"));
      const auto record = std::make_unique<PrinterRecord>();
      ScreenView view;
      change(*record, view);
      expect_fits(DrawnScreen(size.columns, size.rows, *record, view, language));
    }
  }
}

TEST(Screens, AllTextsFitAndNoneLiesOnAnother) {
  for (const ScreenCase& one : golden_cases()) {
    SCOPED_TRACE(one.name);
    expect_all_fit(one.change);
  }
}

TEST(Screens, AnyAddressFitsWithItsCode) {
  MachineRecord machine(9999);
  ASSERT_TRUE(machine.fill(9999));
  for (std::size_t i = 0; i < kTemperatureSiteCount; ++i) {
    machine.feels(static_cast<TemperatureSite>(i), Celsius(149.6));
  }
  for (const std::string host :
       {"10.0.0.1", "255.255.255.255", "printer.local", "a-printer-with-a-longer-name.local"}) {
    for (const bool has_stick : {false, true}) {
      expect_all_fit([&](PrinterRecord& record, ScreenView&) {
        fill_in(record, kIdle);
        record.has_stick = has_stick;
        record.machine = &machine;
        assign(record.address, "http://" + host + ":65535");
      });
    }
  }
}

TEST(Screens, EachFaultFitsWithWhatToDo) {
  for (const FaultWords& fault : fault_words(Language::kEnglish)) {
    SCOPED_TRACE(fault.title);
    expect_all_fit([&](PrinterRecord& record, ScreenView&) {
      fill_in(record, kFault);
      record.set_fault(static_cast<FaultCode>(fault.number), std::string(440, 'w'), fault.next);
    });
  }
}

/// A code with all facts of its words, each as long as a printer of 350 mm and 9,999 layers has it, and a long name.
Told longest_told(ToldCode code) {
  Told told(code, {}, "a file with a long name.ply");
  const std::string_view text = told_words(code, Language::kGerman)->sentence;
  for (std::size_t i = 0; i < kAllFacts; ++i) {
    const auto fact = static_cast<Fact>(i);
    const std::string name(format_of(fact).name);
    const bool used = text.find("{" + name + "}") != text.npos || text.find("{" + name + "?") != text.npos;
    // A range of layers is longer than one.
    if (used && fact != Fact::kLayer)
      told.add(fact, fact <= Fact::kLayers ? 4567 : name.ends_with("mm") ? 234.56 : 1234.5);
  }
  return told;
}

/// The codes from `first` to `last`.
template <class Code>
std::vector<ToldCode> codes(Code first, Code last) {
  std::vector<ToldCode> all;
  for (int i = static_cast<int>(first); i <= static_cast<int>(last); ++i) all.push_back(static_cast<ToldCode>(i));
  return all;
}

TEST(Screens, EachFindingFitsInGermanWithWhatToDo) {
  for (const ToldCode code : codes(PrinterCode::kIsland, PrinterCode::kReportFull)) {
    SCOPED_TRACE(to_string(code));
    expect_all_fit([&](PrinterRecord& record, ScreenView&) {
      fill_in(record, kOffered);
      record.sliced = a_sliced_job();
      for (int i = 0; i < 12; ++i) record.add_finding(Severity::kWarning, std::string(150, 'w'), longest_told(code));
    });
  }
}

TEST(Screens, EachFindingFitsWithAsManyRemediesAsItCanHave) {
  for (const ToldCode code : codes(PrinterCode::kIsland, PrinterCode::kReportFull)) {
    SCOPED_TRACE(to_string(code));
    expect_all_fit([&](PrinterRecord& record, ScreenView& view) {
      fill_in(record, kOffered);
      record.sliced = a_sliced_job();
      Remedies remedies;
      const auto finding = static_cast<PrinterCode>(code);
      const bool is_of_units = finding == PrinterCode::kUnitsGuessed || finding == PrinterCode::kObjectSmall ||
                               finding == PrinterCode::kObjectLarge;
      for (int i = 0; i < (is_of_units ? 3 : 1); ++i) remedies.add("units", "mm");
      for (int i = 0; i < 12; ++i) {
        record.add_finding(Severity::kWarning, std::string(150, 'w'), longest_told(code), remedies);
      }
      view.remedies_open = true;
    });
  }
}

TEST(Screens, EachRemedyFits) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 11> kAll = {{{"supports", "auto"},
                                                                                   {"orient", "auto"},
                                                                                   {"rotate_x_deg", "180"},
                                                                                   {"rotate_y_deg", "-90"},
                                                                                   {"units", "cm"},
                                                                                   {"floor", "keep"},
                                                                                   {"keep_all", "true"},
                                                                                   {"height", "1240.15mm"},
                                                                                   {"width", "1240.15mm"},
                                                                                   {"depth", "1240.15mm"},
                                                                                   {"length", "1240.15mm"}}};
  for (const auto& [key, value] : kAll) {
    SCOPED_TRACE(key);
    expect_all_fit([&, key = key, value = value](PrinterRecord& record, ScreenView& view) {
      fill_in(record, kOffered);
      record.sliced = a_sliced_job();
      Remedies remedies;
      remedies.add(key, value);
      record.add_finding(Severity::kWarning, "an issue", {}, remedies);
      view.remedies_open = true;
    });
  }
  const auto text = [](std::string_view key, std::string_view value, Language language) {
    Remedies remedies;
    remedies.add(key, value);
    return std::string(remedy_text(remedies.list[0], language).view());
  };
  EXPECT_EQ(text("supports", "auto", Language::kEnglish), "Add supports");
  EXPECT_EQ(text("units", "mm", Language::kEnglish), "It is in mm");
  EXPECT_EQ(text("units", "in", Language::kGerman), "Es ist in Zoll");
  EXPECT_EQ(text("height", "40.15mm", Language::kEnglish), "Make the height 40.15 mm");
  EXPECT_EQ(text("height", "40.15mm", Language::kGerman), "Höhe ändern auf 40,15 mm");
}

TEST(Screens, EachRefusalFitsInGermanWithWhatToDo) {
  std::vector<ToldCode> refusals = codes(ToldCode::kTooWide, ToldCode::kWideText);
  std::ranges::copy(codes(PrinterCode::kFileNotOpened, PrinterCode::kSettingValue), std::back_inserter(refusals));
  for (const ToldCode code : refusals) {
    SCOPED_TRACE(to_string(code));
    expect_all_fit([&](PrinterRecord& record, ScreenView&) {
      fill_in(record, kFault);
      record.set_fault(FaultCode::kOutOfMemory, std::string(440, 'w'), info(FaultCode::kOutOfMemory).next,
                       longest_told(code));
    });
  }
}

TEST(Screens, EachQuestionFitsInGerman) {
  for (const ToldCode code : codes(PrinterCode::kMeasurePart, PrinterCode::kLookAtPlate)) {
    expect_all_fit([&](PrinterRecord& record, ScreenView&) {
      fill_in(record, kPaused);
      assign(record.question, std::string(150, 'w'));
      record.question_told = longest_told(code);
    });
  }
}

TEST(Screens, EachPatternOfLightsFitsWithItsMeaning) {
  for (std::size_t pattern = 0; pattern < kLightPatternCount; ++pattern) {
    expect_all_fit([&](PrinterRecord& record, ScreenView& view) {
      fill_in(record, kPlateInUse);
      view.lights_open = true;
      view.pattern = pattern;
    });
  }
}

TEST(Screens, TheCardHasEachPatternOfLightsOnce) {
  for (std::size_t i = 0; i < kPrintStateCount; ++i) {
    const auto state = static_cast<PrintState>(i);
    const auto rows =
        std::ranges::count_if(kLightPatterns, [&](const auto& row) { return same_lights(row.state, state); });
    EXPECT_EQ(rows, 1) << to_string(state);
  }
}

TEST(Screens, EachValueOfASettingFits) {
  for (std::size_t row = 0; row < kMostSettingRows; ++row) {
    for (int turns = 0; turns < 12; ++turns) {
      expect_all_fit([&](PrinterRecord& record, ScreenView& view) {
        fill_in(record, kOffered);
        view.settings_open = true;
        view.setting = row;
        JobRecord& job = *record.job;
        job.size = PrintSize{Side::kHeight, 20.5 + turns};
        job.rotate_z_deg = job.rotate_x_deg = 90 * (turns % 4);
        job.orient = turns % 2 == 1;
        job.supports.enable = turns % 3 == 0 ? std::nullopt : std::optional(turns % 3 == 1);
        job.layer_height = turns % 2 == 1 ? 0.025 : 0;
        if (turns > 7) job.orient = false, job.rotate_x_deg = -359.9, job.rotate_y_deg = -359.9;
        if (turns == 11) job.size.reset(), job.scale = 1234.567;
        if (turns == 10) job.size.reset(), job.scale = 1;
      });
    }
  }
}

// What a stick or a slicer can say has any length: it is cut, and lies on nothing else.
TEST(Screens, AFindingIsShortenedByWholeParts) {
  const Look look(320, 240);
  constexpr std::string_view kText =
      "2 islands, the largest of 1.46 mm2 (582 px) at x 34.2, y 61.0 mm in layer 70 (3.50 mm): add supports, or turn "
      "the object";
  std::string_view before = kText;
  for (int lines = 6; lines > 0; --lines) {
    const auto shown = Page::whole_parts(kText, 300, lines, look.plain);
    EXPECT_TRUE(shown == kText || shown.ends_with("(3.50 mm)") || shown == "2 islands") << shown;
    EXPECT_LE(Page::lines_of(shown, 300, look.plain), lines);
    EXPECT_LE(shown.size(), before.size());
    before = shown;
  }
  EXPECT_EQ(before, "2 islands");
  EXPECT_EQ(Page::whole_parts("no colon in here at all, and much too long", 30, 1, look.plain),
            "no colon in here at all, and much too long");
}

TEST(Screens, TheLongestRecordFits) {
  const std::string wide(1000, 'W');
  for (const ScreenCase& one : golden_cases()) {
    SCOPED_TRACE(one.name);
    expect_all_fit([&](PrinterRecord& record, ScreenView& view) {
      one.change(record, view);
      assign(record.printer, wide);
      assign(record.message, wide);
      if (!record.address.view().empty()) assign(record.address, "http://" + std::string(63, 'W') + ".local:65535");
      if (!record.code.view().empty()) assign(record.code, "4829138");
      if (!record.question.view().empty()) assign(record.question, wide);
      for (std::size_t i = record.scan_count; i < PrinterRecord::kMostScans; ++i) record.scans[i] = record.scans[0];
      record.scan_count = PrinterRecord::kMostScans;
      for (ScanRecord& scan : record.scans) {
        assign(scan.name, wide);
        if (scan.files > 1) scan.files = 64;
        scan.bytes = 9'999'999'999'999;
        if (!scan.problem.view().empty()) assign(scan.problem, wide);
      }
      if (record.folder_count > 0) record.folder_count = record.folders.size();
      for (FolderRecord& folder : record.folders) {
        assign(folder.name, wide);
        folder.entries = 99'999;
      }
      if (!record.folder.view().empty()) assign(record.folder, wide);
      if (!record.left_out.text.view().empty()) assign(record.left_out.text, wide);
      if (record.job) {
        assign(record.job->scan, wide);
        if (record.job->file_count > 1) record.job->file_count = record.job->files.size();
        for (auto& file : record.job->files) assign(file, wide);
      }
      for (FindingRecord& finding : record.findings) assign(finding.text, wide);
      if (record.fault) record.set_fault(FaultCode::kJournalOfAnother, wide, wide);
      if (record.proposals) record.proposals->fill(Proposal{{-359.9, -359.9}, 9, 99'999, 9'999'999, 999'999, 9999, 9});
      if (record.sliced) {
        record.sliced->width_mm = record.sliced->depth_mm = record.sliced->height_mm = 1999.9;
        record.sliced->plan.layers = 40'000;
        record.sliced->resin_ml = 9999.9;
        record.sliced->time = std::chrono::hours(99);
      }
      if (record.progress) {
        record.progress->layers = 40'000;
        record.progress->layers_done = 39'999;
        record.progress->height_mm = 1999.95;
        record.progress->left = std::chrono::hours(99) + std::chrono::minutes(59);
        record.progress->resin_ml = 9999.9;
      }
    });
  }
}

}  // namespace
}  // namespace plumbline::firmware
