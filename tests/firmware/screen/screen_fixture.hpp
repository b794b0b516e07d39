#pragma once
/// Records of every state that a screen has, and a screen to draw them on.

#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "firmware/messages/printer_code.hpp"
#include "firmware/print/job/kept_prints.hpp"
#include "firmware/screen/kept_preview.hpp"
#include "firmware/screen/screens.hpp"
#include "tests/firmware/support/job_fixture.hpp"

namespace plumbline::firmware {

struct DrawnScreen {
  DrawnScreen(int columns, int rows, const PrinterRecord& record, const ScreenView& view, Language language)
      : pixels(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows)),
        canvas(pixels, columns, rows),
        page(canvas, look_of(columns, rows)) {
    const ScreenView open = still_open(record, view);
    const auto wanted = preview_wanted(record, open);
    auto previews = KeptPreview::create();
    const QrCode code(record.address.view());
    draw_screen(page, record, open, language, wanted ? previews->of(*record.prints, *wanted) : nullptr, &code);
  }
  /// Made once for each size.
  static const Look& look_of(int columns, int rows) {
    static std::map<std::pair<int, int>, Look> looks;
    return looks.try_emplace({columns, rows}, columns, rows).first->second;
  }
  std::vector<Colour> pixels;
  Canvas canvas;
  Page page;
};

struct ScreenCase {
  std::string name;  ///< of its golden picture
  std::function<void(PrinterRecord&, ScreenView&)> change;
};

/// A ball from three sides, and its middle layer: shapes that a picture of the test's can have without a slicer.
inline const JobPictures& ball_pictures() {
  static const auto pictures = [] {
    auto made = std::make_unique<JobPictures>();
    made->preview.columns = 320;
    made->preview.rows = 100;
    made->layers[0].columns = 180;
    made->layers[0].rows = 320;
    for (std::uint32_t y = 0; y < made->preview.rows; ++y) {
      for (std::uint32_t x = 0; x < made->preview.columns; ++x) {
        const double dx = static_cast<double>(x % 107) - 53, dy = static_cast<double>(y) - 50;
        const double r = std::sqrt(dx * dx + dy * dy) / 45;
        const double shade = r < 1 ? 60 + 190 * std::sqrt(1 - r * r) : 20;
        for (std::size_t c = 0; c < 3; ++c) {
          made->preview.memory[3 * (std::size_t{y} * made->preview.columns + x) + c] = static_cast<std::uint8_t>(shade);
        }
      }
    }
    for (std::uint32_t y = 0; y < made->layers[0].rows; ++y) {
      for (std::uint32_t x = 0; x < made->layers[0].columns; ++x) {
        const double dx = static_cast<double>(x) - 90, dy = static_cast<double>(y) - 160;
        made->layers[0].memory[std::size_t{y} * made->layers[0].columns + x] = dx * dx + dy * dy < 70 * 70 ? 255 : 0;
      }
    }
    return made;
  }();
  return *pictures;
}

/// The same, with two red islands in a grey ball's layer.
inline const JobPictures& pictures_with_issues() {
  static const auto pictures = [] {
    auto made = std::make_unique<JobPictures>(ball_pictures());
    IssuesPicture& issues = made->issues;
    issues.columns = IssuesPicture::kMostColumns;
    issues.rows = IssuesPicture::kMostRows;
    for (std::uint32_t y = 0; y < issues.rows; ++y) {
      for (std::uint32_t x = 0; x < issues.columns; ++x) {
        const double dx = static_cast<double>(x % 162) - 79, dy = static_cast<double>(y) - 90;
        const double r2 = dx * dx + dy * dy;
        const std::array<std::uint8_t, 3> colour = r2 < 30 * 30   ? std::array<std::uint8_t, 3>{232, 78, 56}
                                                   : r2 < 60 * 60 ? std::array<std::uint8_t, 3>{86, 95, 107}
                                                                  : std::array<std::uint8_t, 3>{28, 33, 40};
        std::ranges::copy(colour, &issues.memory[3 * (std::size_t{y} * issues.columns + x)]);
      }
    }
    return made;
  }();
  return *pictures;
}

/// The same, with an egg in five ways up whose underside is orange.
inline const JobPictures& pictures_with_proposals() {
  static const auto pictures = [] {
    auto made = std::make_unique<JobPictures>(ball_pictures());
    for (std::size_t i = 0; i < made->proposals.size(); ++i) {
      ProposalPicture& picture = made->proposals[i];
      picture.columns = ProposalPicture::kMostColumns;
      picture.rows = ProposalPicture::kMostRows;
      const double turn = static_cast<double>(i) * 0.6, c = std::cos(turn), s = std::sin(turn);
      for (std::uint32_t y = 0; y < picture.rows; ++y) {
        for (std::uint32_t x = 0; x < picture.columns; ++x) {
          const double dx = static_cast<double>(x) - 80, dy = static_cast<double>(y) - 80;
          const double u = (c * dx + s * dy) / 40, v = (c * dy - s * dx) / 68, r2 = u * u + v * v;
          const double shade = r2 < 1 ? 0.3 + 0.7 * std::sqrt(1 - r2) : 0.12;
          const bool below = r2 < 1 && dy > 40;
          const std::array<double, 3> colour = below    ? std::array{232.0, 150.0, 56.0}
                                               : r2 < 1 ? std::array{222.0, 222.0, 212.0}
                                                        : std::array{180.0, 190.0, 200.0};
          for (std::size_t k = 0; k < 3; ++k) {
            picture.memory[3 * (std::size_t{y} * picture.columns + x) + k] =
                static_cast<std::uint8_t>(shade * colour[k]);
          }
        }
      }
    }
    return made;
  }();
  return *pictures;
}

/// A ball and a flat egg: small pictures of the first and the last scan.
inline const ScanPictures& some_scan_pictures() {
  static const auto pictures = [] {
    auto made = std::make_unique<ScanPictures>();
    for (std::size_t i = 0; i < made->size(); ++i) {
      ScanPicture& picture = (*made)[i];
      picture.columns = ScanPicture::kMostColumns;
      picture.rows = ScanPicture::kMostRows;
      for (std::uint32_t y = 0; y < picture.rows; ++y) {
        for (std::uint32_t x = 0; x < picture.columns; ++x) {
          const double dx = (static_cast<double>(x) - 32) / 28, dy = (static_cast<double>(y) - 32) / (i == 2 ? 12 : 28);
          const double r2 = dx * dx + dy * dy;
          const auto shade = static_cast<std::uint8_t>(r2 < 1 ? 60 + 180 * std::sqrt(1 - r2) : 24);
          for (std::size_t k = 0; k < 3; ++k) picture.memory[3 * (std::size_t{y} * picture.columns + x) + k] = shade;
        }
      }
    }
    return made;
  }();
  return *pictures;
}

/// Of a bust that lies on its back.
inline Proposals some_proposals() {
  return {Proposal{{0, 0}, 2.1, 1840, 31'500, 2310, 48.2, 900}, Proposal{{-90, 0}, 0.8, 212, 2900, 1180, 80.2, 150},
          Proposal{{-65, 10.5}, 0.9, 240, 3400, 1010, 76.4, 160},
          Proposal{{-120, -15}, 1.2, 530, 12'700, 1240, 71.9, 300},
          Proposal{{15, 75}, 1.4, 760, 8800, 1690, 62.1, 410}};
}

/// Five prints, kept in a folder of their own: two balls, then one without a preview, as a resumed print has none, and two more balls.
inline const KeptPrints& some_prints() {
  struct Row {
    const char* scan;
    PrintState result;
    std::uint32_t layers_done;
    double resin_ml;
  };
  static const TemporaryFolder folder;
  static const KeptPrints prints = [] {
    auto opened = KeptPrints::open(folder / ".", [](std::string_view) {});
    constexpr std::array kRows = {
        Row{"bust.ply", PrintState::kFinished, 1604, 34.4}, Row{"gear.stl", PrintState::kCancelled, 152, 2.1},
        Row{"a statue with a very long name.ply and 3 more", PrintState::kFinished, 1604, 120.9},
        Row{"ring.3mf", PrintState::kFault, 12, 0.4}, Row{"bust.ply", PrintState::kFinished, 1604, 34.4}};
    auto encoder = PictureEncoder::create(sizeof(PreviewPicture::memory));
    std::int64_t day = 1'795'000'000;
    for (const Row& row : kRows) {
      KeptPrint print;
      print.scan = short_name(row.scan);
      print.profile = short_name("standard");
      print.result = static_cast<std::uint32_t>(row.result);
      print.layers = 1604;
      print.layers_done = row.layers_done;
      print.resin_ml = row.resin_ml;
      print.ended_at = day += 86'400;
      const PreviewPicture& ball = ball_pictures().preview;
      const bool resumed = print.layers_done == print.layers && print.resin_ml > 100;
      const auto png = encoder->encode(ball.bytes(), ball.columns, ball.rows, PreviewPicture::kChannels);
      EXPECT_TRUE(opened->keep(
          print, [](TextSink& out) { return out.write("{}"); }, resumed ? std::span<const std::byte>() : png));
    }
    return std::move(*opened);
  }();
  return prints;
}

/// A tank that is not full, and sensors that answer.
inline const MachineRecord& some_machine() {
  static const MachineRecord machine = [] {
    MachineRecord made(180);
    EXPECT_TRUE(made.fill(134.5));
    made.feels(TemperatureSite::kLamp, Celsius(31.2));
    made.feels(TemperatureSite::kResin, Celsius(24.4));
    made.feels(TemperatureSite::kBoard, Celsius(45.6));
    return made;
  }();
  return machine;
}

inline PrintStatus status_of(PrintState state) {
  PrintStatus status;
  status.state = state;
  status.layer = 612;
  status.layers = 1604;
  status.height = ZPosition(Distance::millimetres(30.65));
  status.elapsed = std::chrono::minutes(101);
  status.remaining = std::chrono::minutes(165);
  status.resin_ml = 13.2;
  return status;
}

/// A printer in a state, with a stick of three scans and a job.
inline void fill_in(PrinterRecord& record, PrintState state) {
  assign(record.printer, "sim2k");
  record.state = state;
  record.waits = at_rest(state);
  record.has_stick = true;
  record.scan_count = 3;
  for (std::size_t i = 0; i < 3; ++i) {
    static constexpr const char* kNames[] = {"bust of a young woman.ply", "broken.ply", "gear wheel 40 teeth.xyz"};
    static constexpr std::uint64_t kBytes[] = {48'200'112, 106, 1'204'300};
    assign(record.scans[i].name, kNames[i]);
    record.scans[i].bytes = kBytes[i];
  }
  assign(record.scans[1].problem, "PL-102, not a scan: broken.ply: the file ends after line 8, with 1 of the 5 points");
  record.scans[1].told = PrinterCode::kFileCut;
  JobRecord& job = record.job.emplace();
  assign(job.scan, "bust of a young woman.ply");
  assign(job.profile, "standard");
  job.chosen = 0;
  for (const char* profile : {"draft", "fine", "standard"}) assign(record.profiles[record.profile_count++], profile);
  record.pictures = &ball_pictures();
  if (!at_rest(state) && state != PrintState::kSlicing) record.set_progress(status_of(state), 1'900'000'000);
}

inline Contract a_sliced_job() {
  Contract contract;
  contract.width_mm = 62.1;
  contract.depth_mm = 48.2;
  contract.height_mm = 80.2;
  contract.resin_ml = 34.5;
  contract.time = std::chrono::minutes(266);
  PrintPlan& plan = contract.plan;
  plan.layers = 1604;
  plan.layer_height = Distance::micrometres(50);
  plan.exposure = std::chrono::milliseconds(2500);
  plan.initial_exposure = std::chrono::seconds(30);
  plan.bottom_layers = 5;
  plan.faded_layers = 8;
  plan.lift = Distance::millimetres(5);
  plan.lift_speed = plan.lift_speed2 = plan.retract_speed = plan.retract_speed2 = mm_per_min(60);
  contract.sources[index_of(PrintKey::kExposureTime)] = ValueSource::kPerson;
  contract.sources[index_of(PrintKey::kLayerHeight)] = ValueSource::kArchive;
  return contract;
}

}  // namespace plumbline::firmware
