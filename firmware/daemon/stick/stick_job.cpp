#include "firmware/daemon/stick/stick_job.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "firmware/io/scan_names.hpp"
#include "firmware/messages/printer_code.hpp"
#include "firmware/settings/job_options.hpp"
#include "firmware/settings/print_length.hpp"
#include "firmware/settings/settings_file.hpp"
#include "slicer/reader/scan_sources.hpp"

namespace plumbline::firmware {
namespace {

/// Keys of the size, and their texts.
constexpr std::array<std::string_view, 4> kSizeWords = {"width", "depth", "height", "length"};
struct JobTexts {
  std::array<std::string, kSizeWords.size()> sizes;
  std::string floor;
  std::array<std::uint32_t, kPrintKeyCount> counts;  ///< of print settings, where the file has them
  JobTexts() { counts.fill(UINT32_MAX); }
};
static_assert(static_cast<int>(Side::kWidth) == 0 && static_cast<int>(Side::kLength) == 3);

std::vector<SettingRule> rules_for(StickJob& job, JobTexts& texts) {
  constexpr auto kOptional = Presence::kOptional;
  std::vector<SettingRule> rules = {
      {"job", "scan", PathListSetting{&job.scans, kMostScans}, 1, 255},
      {"job", "profile", TextSetting{&job.profile}, 1, 63, "", kOptional},
      {"job", "supports", ChoiceSetting{kSupportWords, [&job](std::size_t word) { job.supports.enable = word == 1; }},
       0, 0, "", kOptional},
      {"job", "as", choice(kAsWords, job.as), 0, 0, "", kOptional},
      {"job", "base", choice(kBaseWords, job.base), 0, 0, "", kOptional},
      {"job", "floor", TextSetting{&texts.floor, TextKind::kPath}, 1, 32, "", kOptional},
      {"job", "keep_all", &job.keep_all, 0, 0, "", kOptional},
      {"placement", "units", choice(kUnitWords, job.units), 0, 0, "", kOptional},
      {"placement", "scale", &job.scale, kSmallestScale, kLargestScale, "", kOptional},
      {"placement", "fit", &job.fit, 0, 0, "", kOptional},
      {"placement", kSizeWords[0], TextSetting{&texts.sizes[0], TextKind::kPath}, 1, 32, "", kOptional},
      {"placement", kSizeWords[1], TextSetting{&texts.sizes[1], TextKind::kPath}, 1, 32, "", kOptional},
      {"placement", kSizeWords[2], TextSetting{&texts.sizes[2], TextKind::kPath}, 1, 32, "", kOptional},
      {"placement", kSizeWords[3], TextSetting{&texts.sizes[3], TextKind::kPath}, 1, 32, "", kOptional},
      {"placement", "orient", ChoiceSetting{kSupportWords, [&job](std::size_t word) { job.orient = word == 1; }}, 0, 0,
       "", kOptional},
      {"placement", "keep_clean", choice(kCleanSideWords, job.keep_clean), 0, 0, "", kOptional},
      {"placement", "rotate_x_deg", &job.rotate_x_deg, -360, 360, " degrees", kOptional},
      {"placement", "rotate_y_deg", &job.rotate_y_deg, -360, 360, " degrees", kOptional},
      {"placement", "rotate_z_deg", &job.rotate_z_deg, -360, 360, " degrees", kOptional},
      {"placement", "layer_height", NumberOrWord{&job.layer_height, kAdaptiveWord, kAdaptiveHeight}, kFinestMm,
       kCoarsestMm, " mm", kOptional},
  };
  for (const PrintField& field : kPrintFields) {
    if (!field.can_be_changed()) continue;
    const std::size_t i = index_of(field.key);
    SettingRule& rule = rules.emplace_back();
    rule = {"print", field.name, &job.values[i], field.low, field.high, field.unit, kOptional};
    if (field.is_whole()) rule.value = &texts.counts[i];
  }
  add_support_rules(rules, job.supports);
  add_place_rules(rules, job.supports);
  return rules;
}

/// Sets the job's size and floor from their texts.
/// @returns what is wrong with a key; empty if nothing is
std::string take_text(StickJob& job, const JobTexts& texts, std::string_view key) {
  if (key == "floor" && !texts.floor.empty()) {
    const auto floor = parse_floor(texts.floor);
    if (!floor) return std::string("is not ").append(kFloorForm);
    job.floor = *floor;
  }
  if (key == "orient" && job.orient && (job.rotate_x_deg != 0 || job.rotate_y_deg != 0 || job.rotate_z_deg != 0)) {
    return "finds the rotation: leave out rotate_x_deg, rotate_y_deg and rotate_z_deg";
  }
  const auto word = std::find(kSizeWords.begin(), kSizeWords.end(), key);
  if (word == kSizeWords.end()) return {};
  const auto side = static_cast<std::size_t>(word - kSizeWords.begin());
  if (texts.sizes[side].empty()) return {};
  const auto mm = parse_length(texts.sizes[side]);
  if (!mm) return std::string("is not ").append(kLengthForm);
  if (job.size || job.fit || job.scale != 1)
    return "is one size too many: keep one of width, depth, height, length, scale and fit";
  job.size = PrintSize{static_cast<Side>(side), *mm};
  return {};
}

}  // namespace

Error as_setting_error(const Error& error) {
  const auto finding = error.finding();
  const auto advice = error.advice();
  if (advice.empty()) return Error::format(ErrorCode::kBadSetting, "%s", error.message()).tell(error.told());
  return Error::format(ErrorCode::kBadSetting, "%.*s.\t%.*s", static_cast<int>(finding.size()), finding.data(),
                       static_cast<int>(advice.size()), advice.data())
      .tell(error.told());
}

Expected<StickJob> parse_stick_job(std::string_view text, std::string_view path) {
  StickJob job;
  JobTexts texts;
  const auto rules = rules_for(job, texts);
  const auto check = [&](const SettingRule& rule) { return take_text(job, texts, rule.key); };
  const auto parsed = parse_settings(text, path, {"a job file", rules, nullptr, check});
  if (!parsed) return tl::unexpected<Error>(as_setting_error(parsed.error()));
  for (std::size_t i = 0; i < kPrintKeyCount; ++i) {
    if (texts.counts[i] != UINT32_MAX) job.values[i] = texts.counts[i];
  }
  return job;
}

std::string StickJob::title() const { return scans.empty() ? "" : title_of(scans.front(), scans.size()).c_str(); }

Status find_files(StickJob& job, const StickMount& mount) {
  put_poses_last(job.scans);
  if (job.scans.size() != 1 || !mount.is_folder(job.scans[0])) return {};
  struct Listing final : StickMount::FileVisitor {
    void on_file(std::string_view name, const StickFileFacts& facts) override {
      if (facts.partition == 0) scans.add(name);
    }
    void on_other(std::string_view /*name*/, const char* /*what*/) override {}
    FolderScans scans;
  } listing;
  const std::string_view folder = without_slash(job.scans[0]);
  PLUMBLINE_TRY(mount.for_each_file(listing, folder));
  auto paths = listing.scans.paths(folder);
  PLUMBLINE_TRY(paths);
  job.scans = std::move(*paths);
  return {};
}

Expected<std::vector<StickFile>> open_scan(const StickJob& job, const StickMount& mount) {
  if (job.scans.size() > kMostScans) {
    return telling(
        Told(PrinterCode::kTooManyFiles, {{Fact::kCount, kMostScans}}),
        fail(ErrorCode::kBadSetting,
             "%s: one scan may have %zu files at most:\tjoin some of them, or name those that are needed in job.toml",
             job.title().c_str(), kMostScans));
  }
  std::vector<StickFile> files;
  for (const std::string& name : job.scans) {
    auto file = mount.open(name);
    PLUMBLINE_TRY(file);
    files.push_back(std::move(*file));
  }
  return files;
}

}  // namespace plumbline::firmware
