#include "firmware/daemon/stick/stick_task.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "firmware/child/answer_check.hpp"
#include "firmware/child/archive_task.hpp"
#include "firmware/child/given_file.hpp"
#include "firmware/child/rights.hpp"
#include "firmware/child/scan_task.hpp"
#include "firmware/settings/job_options.hpp"
#include "firmware/settings/settings_file.hpp"

namespace plumbline::firmware {
namespace {

Expected<StickJob> read_job(const ScanRequest& request) {
  GivenFile file(STDIN_FILENO, request.file[0]);
  std::string text(kMaxSettingsFileBytes + 1, '\0');
  std::size_t filled = 0;
  while (filled < text.size()) {
    const auto got = file.read(std::as_writable_bytes(std::span(text).subspan(filled)));
    PLUMBLINE_TRY(got);
    if (*got == 0) break;
    filled += *got;
  }
  text.resize(filled);
  return parse_stick_job(text, request.name.view());
}

void hand_back(const StickJob& job, ScanAnswer& answer) {
  JobAnswer& fields = answer.job;
  for (const std::string& scan : job.scans) {
    auto& field = fields.scan[fields.scans++];
    scan.copy(field.data(), field.size() - 1);
  }
  job.profile.copy(fields.profile.data(), fields.profile.size() - 1);
  fields.units = static_cast<std::uint32_t>(job.units);
  fields.as = static_cast<std::uint32_t>(job.as);
  fields.base = static_cast<std::uint32_t>(job.base);
  fields.fit = job.fit ? 1 : 0;
  fields.keep_all = job.keep_all ? 1 : 0;
  if (job.size) {
    fields.side = static_cast<std::uint32_t>(job.size->side);
    fields.size_mm = job.size->mm;
  }
  fields.orient = job.orient ? 1 : 0;
  fields.keep_clean = static_cast<std::uint32_t>(job.keep_clean);
  fields.floor = static_cast<std::uint32_t>(job.floor.kind);
  fields.floor_height = job.floor.height;
  fields.scale = job.scale;
  fields.rotate_deg = {job.rotate_x_deg, job.rotate_y_deg, job.rotate_z_deg};
  fields.layer_height = job.layer_height;
  fields.values = pass(job.values);
  fields.supports = pass(job.supports);
  answer.kind = ScanAnswer::kJob;
}

template <std::size_t Size>
std::string text_of(const std::array<char, Size>& text) {
  return {text.begin(), std::find(text.begin(), text.end() - 1, '\0')};
}

bool is_within(double value, double low, double high) { return value >= low && value <= high; }  // NaN is not

}  // namespace

void run_stick_task(SharedMemory& memory, std::uint32_t threads) {
  MessagePage& page = memory.page();
  if (page.request.archive.ask != ArchiveRequest::Ask::kNothing) return run_archive_task(memory, threads);
  if (!page.request.is_job_file) return run_scan_task(memory, threads);
  if (!filter_system_calls()) return refuse_without_filter(page.answer);
  const auto job = read_job(page.request);
  if (job) {
    hand_back(*job, page.answer);
  } else {
    hand_back_error(job.error(), page.answer);
  }
}

Expected<StickJob> check_job_answer(const ScanAnswer& answer) {
  constexpr std::array kErrors = {ErrorCode::kBadSetting, ErrorCode::kMalformed, ErrorCode::kCannotRead,
                                  ErrorCode::kUnsupported};
  if (answer.kind == ScanAnswer::kRefused) return child_error(answer, kErrors);
  const JobAnswer& fields = answer.job;
  StickJob job;
  for (std::size_t i = 0; i < std::min<std::size_t>(fields.scans, kMostScans); ++i) {
    job.scans.push_back(text_of(fields.scan[i]));
  }
  const bool named = fields.scans >= 1 && fields.scans <= kMostScans &&
                     std::none_of(job.scans.begin(), job.scans.end(), [](const auto& scan) { return scan.empty(); });
  job.profile = text_of(fields.profile);
  const bool angles = std::all_of(fields.rotate_deg.begin(), fields.rotate_deg.end(),
                                  [](double degrees) { return is_within(degrees, -360, 360); });
  const bool choices = fields.units <= static_cast<std::uint32_t>(Units::kAuto) &&
                       fields.as <= static_cast<std::uint32_t>(ReadAs::kMesh) &&
                       fields.base <= static_cast<std::uint32_t>(BaseChoice::kFlat) && fields.fit <= 1 &&
                       fields.keep_all <= 1 && fields.side <= static_cast<std::uint32_t>(Side::kLength) &&
                       fields.orient <= 1 && fields.keep_clean < kCleanSideWords.size() &&
                       fields.floor <= static_cast<std::uint32_t>(FloorChoice::Kind::kHeight);
  const bool lengths = (fields.size_mm == 0 || is_within(fields.size_mm, kSmallestSizeMm, kLargestSizeMm)) &&
                       is_within(fields.floor_height, -kLargestFloorHeight, kLargestFloorHeight) &&
                       is_within(fields.scale, kSmallestScale, kLargestScale) &&
                       (fields.layer_height == 0 || fields.layer_height == kAdaptiveHeight ||
                        is_within(fields.layer_height, kFinestMm, kCoarsestMm));
  const bool values = receive(fields.values, job.values) == nullptr && receive(fields.supports, job.supports);
  if (answer.kind != ScanAnswer::kJob || !values || !named || !is_setting_name(job.profile) || !angles || !choices ||
      !lengths) {
    return fail(ErrorCode::kBadSetting, "what was read of it does not add up");
  }
  job.units = static_cast<Units>(fields.units);
  job.as = static_cast<ReadAs>(fields.as);
  job.base = static_cast<BaseChoice>(fields.base);
  job.fit = fields.fit == 1;
  job.keep_all = fields.keep_all == 1;
  job.orient = fields.orient == 1;
  job.keep_clean = static_cast<CleanSide>(fields.keep_clean);
  job.floor = {static_cast<FloorChoice::Kind>(fields.floor), fields.floor_height};
  if (fields.size_mm != 0) job.size = PrintSize{static_cast<Side>(fields.side), fields.size_mm};
  job.scale = fields.scale;
  job.rotate_x_deg = fields.rotate_deg[0];
  job.rotate_y_deg = fields.rotate_deg[1];
  job.rotate_z_deg = fields.rotate_deg[2];
  job.layer_height = fields.layer_height;
  return job;
}

}  // namespace plumbline::firmware
