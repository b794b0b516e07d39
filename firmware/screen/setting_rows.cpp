#include "firmware/screen/setting_rows.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "firmware/archive/layer_archive.hpp"
#include "firmware/screen/screen_parts.hpp"

namespace plumbline::firmware::inline screen {
namespace {

enum class Row : std::uint8_t { kProfile, kHeight, kTurn, kTilt, kUpright, kSupports, kLayerHeight };
static_assert(static_cast<std::size_t>(Row::kLayerHeight) + 1 == kMostSettingRows);

/// Heights of a print, mm: about a quarter more each. Any other one can be set in job.toml or by plumbline ctl.
constexpr std::array kHeights = {20, 25, 30, 40, 50, 60, 80, 100, 120, 150};
/// mm, of the usual resins and steps of 5 um. The text is what job.toml takes.
constexpr std::array<std::string_view, 4> kLayerHeights = {"0.025", "0.03", "0.05", "0.1"};

template <std::size_t Capacity>
void put(FixedText<Capacity>& to, std::string_view text) {
  to.add("%.*s", static_cast<int>(text.size()), text.data());
}

void add_mm(FixedText<64>& to, double mm, int digits, Language language) {
  put(to, decimal(mm, digits, language).view());
  to.add(" mm");
}

void add_height(FixedText<64>& to, const JobRecord& job, Language language) {
  if (job.size) {
    add_mm(to, job.size->mm, job.size->mm == std::floor(job.size->mm) ? 0 : 1, language);
  } else if (job.scale == 1) {  // NOLINT(clang-diagnostic-float-equal): what was set, not computed
    put(to, words(Words::kAsScanned, language));
  } else {
    to.add("× ");
    put(to, decimal(job.scale, 3, language).view());
  }
}

void add_way(FixedText<64>& to, const PrinterRecord& record, Language language) {
  const JobRecord& job = *record.job;
  const auto proposal = record.proposal();
  if (job.orient) {
    put(to, words(Words::kYes, language));
  } else if (proposal && *proposal > 0) {
    put(to, filled_in(words(Words::kProposal, language), static_cast<unsigned>(*proposal)).view());
  } else if (job.rotate_x_deg == 0 && job.rotate_y_deg == 0) {  // NOLINT(clang-diagnostic-float-equal): as it was set
    put(to, words(Words::kAsScanned, language));
  } else {
    to.add("%.0f° / %.0f°", job.rotate_x_deg, job.rotate_y_deg);
  }
}

/// The next quarter of a turn, in degrees.
int next_quarter(double degrees) { return (static_cast<int>(std::lround(degrees / 90)) + 5) % 4 * 90; }

/// The next of a job's heights, mm; 0: the scan's own.
int next_height(const JobRecord& job) {
  const double now = job.size ? job.size->mm : 0;
  const auto* const next = std::find_if(kHeights.begin(), kHeights.end(), [now](int mm) { return mm > now; });
  return next == kHeights.end() ? 0 : *next;
}

std::string_view next_profile(const PrinterRecord& record, const JobRecord& job) {
  for (std::size_t i = 0; i < record.profile_count; ++i) {
    if (record.profiles[i].view() == job.profile.view()) {
      return record.profiles[(i + 1) % record.profile_count].view();
    }
  }
  return record.profile_count > 0 ? record.profiles[0].view() : job.profile.view();
}

std::string_view next_layer_height(const JobRecord& job) {
  if (job.is_adaptive()) return "";
  if (job.layer_height <= 0) return kLayerHeights[0];
  FixedText<16> now;
  now.add("%g", job.layer_height);
  for (std::size_t i = 0; i + 1 < kLayerHeights.size(); ++i) {
    if (now.view() == kLayerHeights[i]) return kLayerHeights[i + 1];
  }
  return kAdaptiveWord;
}

}  // namespace

FixedText<32> decimal(double value, int digits, Language language) {
  FixedText<32> number;
  number.add("%.*f", digits, value);
  if (language == Language::kEnglish || digits == 0) return number;
  const auto point = number.view().find('.');
  if (point == std::string_view::npos) return number;
  FixedText<32> german;
  put(german, number.view().substr(0, point));
  german.add(",");
  put(german, number.view().substr(point + 1));
  return german;
}

std::size_t setting_rows(const PrinterRecord& record) {
  return is_archive_name(record.job->files[0].view()) ? 1 : kMostSettingRows;
}

bool opens_proposals(std::size_t row) { return static_cast<Row>(row) == Row::kUpright; }

SettingRow setting_row(std::size_t row, const PrinterRecord& record, Language language) {
  const JobRecord& job = *record.job;
  SettingRow shown{};
  const auto say = [&](Words which) { put(shown.value, words(which, language)); };
  switch (static_cast<Row>(row)) {
    case Row::kProfile:
      shown.label = Words::kProfile;
      put(shown.value, job.profile.view());
      break;
    case Row::kHeight:
      shown.label = Words::kSize;
      add_height(shown.value, job, language);
      break;
    case Row::kTurn:
      shown.label = Words::kTurn;
      shown.value.add("%.0f°", job.rotate_z_deg);
      break;
    case Row::kTilt:
      shown.label = Words::kTilt;
      shown.value.add("%.0f°", job.rotate_x_deg);
      break;
    case Row::kUpright:
      shown.label = Words::kUpright;
      add_way(shown.value, record, language);
      break;
    case Row::kSupports:
      shown.label = Words::kSupports;
      say(!job.supports.enable ? Words::kOfProfile : *job.supports.enable ? Words::kYes : Words::kNo);
      break;
    case Row::kLayerHeight:
      shown.label = Words::kLayerHeight;
      if (job.is_adaptive()) {
        say(Words::kAdaptive);
      } else if (job.layer_height > 0) {
        add_mm(shown.value, job.layer_height, 3, language);
      } else {
        say(Words::kOfProfile);
      }
      break;
  }
  return shown;
}

ClientRequest next_value(std::size_t row, const PrinterRecord& record, const JobRecord& job) {
  ClientRequest request;
  request.command = Command::kSet;
  switch (static_cast<Row>(row)) {
    case Row::kProfile:
      request.key.add("profile");
      put(request.value, next_profile(record, job));
      break;
    case Row::kHeight:
      if (const int mm = next_height(job); mm > 0) {
        request.key.add("height");
        request.value.add("%dmm", mm);
      } else {
        request.key.add("scale");
        request.value.add("1");
      }
      break;
    case Row::kTurn:
      request.key.add("rotate_z_deg");
      request.value.add("%d", next_quarter(job.rotate_z_deg));
      break;
    case Row::kTilt:
      request.key.add("rotate_x_deg");
      request.value.add("%d", next_quarter(job.rotate_x_deg));
      break;
    case Row::kUpright: break;
    case Row::kSupports:
      request.key.add("supports");
      request.value.add("%s", !job.supports.enable ? "auto" : *job.supports.enable ? "none" : "");
      break;
    case Row::kLayerHeight:
      request.key.add("layer_height");
      put(request.value, next_layer_height(job));
      break;
  }
  return request;
}

ClientRequest changed_value(std::size_t field, const Contract& contract, bool up) {
  const PrintField& row = kPrintFields[field];
  const double steps = std::round(value_of(contract.plan, row.key) / row.step) + (up ? 1 : -1);
  ClientRequest request;
  request.command = Command::kSet;
  put(request.key, row.name);
  request.value.add("%.6g", std::clamp(steps * row.step, row.low, row.high));
  return request;
}

}  // namespace plumbline::firmware::inline screen
