#include "firmware/daemon/stick_request.hpp"

#include <algorithm>

#include "firmware/messages/printer_code.hpp"
#include "firmware/print/job/print_plan.hpp"
#include "firmware/settings/support_choice.hpp"
#include "slicer/core/words/printable_text.hpp"
#include "slicer/support_building.hpp"

namespace plumbline::firmware {

Expected<ScanRequest> stick_request(const StickJob& job, std::span<const StickFile> scan, const PrintProfile& profile,
                                    const DaemonSettings& daemon) {
  ScanRequest request;
  request.name.add("%s", job.title().c_str());
  for (const StickFile& file : scan) {
    if (scan.size() > 1 && is_archive_name(file.name())) {
      return telling(Told(PrinterCode::kArchiveSettings, {}, file.name()),
                     fail(ErrorCode::kBadSetting,
                          "%s: is sliced already, so it can't be part of a scan.\tTake it out of the list `scan`",
                          PrintableText(file.name()).c_str()));
    }
    request.add_file(file.name(), file.size());
  }
  request.settings.threads = daemon.threads;
  request.settings.as = job.as;
  request.settings.base = job.base;
  request.settings.floor = job.floor;
  request.settings.orient = job.orient;
  request.settings.keep_clean = job.keep_clean;
  request.settings.keep_all = job.keep_all;
  request.settings.confidence = true;  // for the picture of what was scanned
  PlacementSettings& placement = request.settings.placement;
  placement.units = job.units;
  placement.scale = job.scale;
  placement.fit = job.fit;
  placement.size = job.size;
  placement.rotation_degrees = {job.rotate_x_deg, job.rotate_y_deg, job.rotate_z_deg};
  placement.layer_height_mm = static_cast<float>(finest_layer_mm(profile));
  placement.printer = printer_volume(daemon.board);
  const bool is_sliced = is_archive_name(scan[0].name());
  if (!is_sliced) correct_sizes(profile, daemon.board, request.settings);
  tell_checks(profile, daemon.machine, request.settings);
  request.settings.grey = shown_grey(profile, daemon.machine);
  const auto supports = job.supports.over(profile.supports_enable, profile.supports);
  if (!supports) {
    Error wrong = supports.error();
    return tl::unexpected<Error>(wrong.tell(Told(PrinterCode::kSettingValue, {}, "supports")));
  }
  request.settings.supports = *supports;
  if (*supports) placement.room = support_room(**supports);
  placement.room.beside_mm += std::max(0.0, request.settings.absolute_correction_mm);
  if (is_sliced) {
    JobSettings settings = job;
    if (!job.is_adaptive()) settings.layer_height = 0;
    settings.values = {};
    if (settings != JobSettings()) {
      return telling(Told(PrinterCode::kArchiveSettings, {}, job.title()),
                     fail(ErrorCode::kBadSetting,
                          "%s: is sliced already, so of the job's settings only the profile, exposures, lifts and "
                          "waits count.\tLeave out the others, or "
                          "put the mesh or scan that it was made of on the stick",
                          job.title().c_str()));
    }
    request.archive.ask = ArchiveRequest::Ask::kCheck;
    request.archive.shows_grey = daemon.machine.panel.grey.has_grey();
    request.settings.supports.reset();
  }
  PLUMBLINE_TRY(plan_print(profile, daemon.machine, finest_layer_mm(profile), 1));
  return request;
}

}  // namespace plumbline::firmware
