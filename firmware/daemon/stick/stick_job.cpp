#include "firmware/daemon/stick/stick_job.hpp"

#include <algorithm>
#include <cctype>
#include <string>
#include <vector>

#include "firmware/archive/layer_archive.hpp"
#include "firmware/settings/job_options.hpp"
#include "firmware/settings/print_length.hpp"
#include "firmware/settings/settings_file.hpp"
#include "slicer/core/printable_text.hpp"
#include "slicer/reader/formats/scan_endings.hpp"
#include "slicer/reader/formats/sliced_formats.hpp"

namespace plumbline {
namespace {

/// Keys of the size, and their texts.
constexpr std::array<std::string_view, 4> kSizeWords = {"width", "depth", "height", "length"};
struct JobTexts {
  std::array<std::string, kSizeWords.size()> sizes;
  std::string floor;
};
static_assert(static_cast<int>(Side::kWidth) == 0 && static_cast<int>(Side::kLength) == 3);

std::vector<SettingRule> rules_for(StickJob& job, JobTexts& texts) {
  constexpr auto kOptional = Presence::kOptional;
  return {
      {"job", "scan", TextSetting{&job.scan, TextKind::kPath}, 1, 255},
      {"job", "profile", TextSetting{&job.profile}, 1, 63, "", kOptional},
      {"job", "supports", ChoiceSetting{kSupportWords, [&job](std::size_t word) { job.supports = word == 1; }}, 0, 0,
       "", kOptional},
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
      {"placement", "rotate_x_deg", &job.rotate_x_deg, -360, 360, " degrees", kOptional},
      {"placement", "rotate_y_deg", &job.rotate_y_deg, -360, 360, " degrees", kOptional},
      {"placement", "rotate_z_deg", &job.rotate_z_deg, -360, 360, " degrees", kOptional},
      {"placement", "layer_height", &job.layer_height, kFinestMm, kCoarsestMm, " mm", kOptional},
  };
}

/// Sets the job's size and floor from their texts.
/// @returns what is wrong with a key; empty if nothing is
std::string take_text(StickJob& job, const JobTexts& texts, std::string_view key) {
  if (key == "floor" && !texts.floor.empty()) {
    const auto floor = parse_floor(texts.floor);
    if (!floor) return std::string("is not ") + kFloorForm;
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
  if (!mm) return std::string("is not ") + kLengthForm;
  if (job.size || job.fit || job.scale != 1)
    return "is one size too many: keep one of width, depth, height, length, scale and fit";
  job.size = PrintSize{static_cast<Side>(side), *mm};
  return {};
}

std::string in_lower_case(std::string_view name) {
  std::string lower(name);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); });
  return lower;
}

/// Collects scans and job.toml. Anything that may have been meant as one of them is an error, never skipped: without its
/// job.toml a scan would be printed at the wrong size.
struct StickListing final : StickMount::FileVisitor {
  void on_file(std::string_view name, std::uint64_t bytes) override {
    const auto length = static_cast<int>(name.size());
    const std::string lower = in_lower_case(name);
    if (lower == kJobFile) {
      if (!scans.job_file.view().empty()) {
        wrong_job = Error::format(ErrorCode::kBadSetting, "%s and %.*s: the stick has two jobs.\tLeave one of them",
                                  scans.job_file.c_str(), length, name.data());
        return;
      }
      scans.job_file.add("%.*s", length, name.data());
    } else if (lower.starts_with(kJobFile)) {
      nearly_job =
          Error::format(ErrorCode::kBadSetting, "%.*s: looks like the stick's job.\tCall it job.toml, or remove it",
                        length, name.data());
    } else if (const ForeignFormat* const foreign = foreign_format(name)) {
      if (!scans.foreign) {
        scans.foreign = Error::format(ErrorCode::kUnknownFormat, "%s %s (%s);\t%s", PrintableText(name).c_str(),
                                      foreign->what, foreign->program, foreign->advice);
      }
    } else if (is_scan_name(name)) {
      if (scans.count == StickScans::kMost) {
        ++scans.left_out;
      } else {
        StickScan& scan = scans.list[scans.count++];
        scan.name.add("%.*s", length, name.data());
        scan.bytes = bytes;
      }
    }
  }
  void on_other(std::string_view name, const char* what) override {
    const auto length = static_cast<int>(name.size());
    if (in_lower_case(name) == kJobFile) {
      wrong_job = Error::format(ErrorCode::kBadSetting, "%.*s: %s, not a file.\tPut a file there, or remove it", length,
                                name.data(), what);
    } else if (is_scan_name(name)) {
      wrong_scan =
          Error::format(ErrorCode::kCannotOpen, "%.*s: %s, not a file.\tRemove it, or name the scan in job.toml",
                        length, name.data(), what);
    }
  }

  StickScans scans;
  std::optional<Error> wrong_job, nearly_job, wrong_scan;
};

}  // namespace

Error as_setting_error(const Error& error) {
  const auto finding = error.finding();
  const auto advice = error.advice();
  if (advice.empty()) return Error::format(ErrorCode::kBadSetting, "%s", error.message());
  return Error::format(ErrorCode::kBadSetting, "%.*s.\t%.*s", static_cast<int>(finding.size()), finding.data(),
                       static_cast<int>(advice.size()), advice.data());
}

Expected<StickJob> parse_stick_job(std::string_view text, std::string_view path) {
  StickJob job;
  JobTexts texts;
  const auto rules = rules_for(job, texts);
  const auto check = [&](const SettingRule& rule) { return take_text(job, texts, rule.key); };
  const auto parsed = parse_settings(text, path, {"a job file", rules, nullptr, check});
  if (!parsed) return tl::unexpected<Error>(as_setting_error(parsed.error()));
  return job;
}

bool is_scan_name(std::string_view name) {
  // Text files that come with scans; no scan has such a name.
  constexpr std::array<std::string_view, 7> kTexts = {"readme.txt",  "read me.txt",   "license.txt", "licence.txt",
                                                      "copying.txt", "changelog.txt", "notes.txt"};
  const std::string lower = in_lower_case(name);
  if (std::find(kTexts.begin(), kTexts.end(), lower) != kTexts.end() || lower.starts_with(kJobFile)) return false;
  const auto has_ending = [&lower](std::string_view ending) {
    return lower.size() > ending.size() && std::string_view(lower).ends_with(ending);
  };
  return is_archive_name(name) || std::any_of(kMarkedEndings.begin(), kMarkedEndings.end(), has_ending) ||
         std::any_of(kXyzEndings.begin(), kXyzEndings.end(), has_ending);
}

Expected<StickScans> list_scans(const StickMount& mount) {
  StickListing listing;
  PLUMBLINE_TRY(mount.for_each_file(listing));
  if (listing.wrong_job) return tl::unexpected<Error>(*listing.wrong_job);
  StickScans& scans = listing.scans;
  const bool has_job = !scans.job_file.view().empty();
  if (!has_job && listing.nearly_job) return tl::unexpected<Error>(*listing.nearly_job);
  if (!has_job && listing.wrong_scan) return tl::unexpected<Error>(*listing.wrong_scan);
  std::sort(scans.list.begin(), scans.list.begin() + static_cast<std::ptrdiff_t>(scans.count),
            [](const auto& a, const auto& b) { return a.name.view() < b.name.view(); });
  return scans;
}

}  // namespace plumbline
