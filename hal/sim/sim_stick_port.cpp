#include "hal/sim/sim_stick_port.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "hal/process/report_folder.hpp"
#include "hal/sim/sim_call.hpp"

namespace plumbline::inline hal::inline sim {
namespace {

tl::unexpected<Error> none() { return fail(ErrorCode::kNoStick, "no stick:\tplug one in"); }

}  // namespace

bool SimStickPort::do_has_stick() const {
  const SimCall call(plant_);
  return !plant_.stick().empty();
}

Expected<StickIdentity> SimStickPort::do_identity() const {
  if (!do_has_stick()) return none();
  StickIdentity identity{.vendor_id = 0x1209, .product_id = 0x0001, .maker = {}, .product = {}, .serial = {}};
  std::copy_n("plumbline", 9, identity.maker.begin());
  std::copy_n("simulated stick", 15, identity.product.begin());
  const auto& folder = plant_.stick();
  const auto kept = std::min(folder.size(), identity.serial.size() - 1);
  std::copy(folder.end() - static_cast<std::ptrdiff_t>(kept), folder.end(), identity.serial.begin());
  return identity;
}

Expected<StickParts> SimStickPort::do_mount() {
  if (!do_has_stick()) return none();
  const auto& folder = plant_.stick();
  if (plant_.has_fault(FaultKind::kStickMountFails)) {
    return fail(ErrorCode::kMountFailed, "the stick's file system can't be read:\tformat it as FAT32 or exFAT");
  }
  StickParts parts;
  for (std::size_t number = 1; number <= StickParts::kMost; ++number) {
    const std::string part = number == 1 ? folder : folder + "." + std::to_string(number);
    const int top = ::open(part.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (top < 0 && number > 1) break;
    if (top < 0) return fail(ErrorCode::kMountFailed, "%s: %s", folder.c_str(), std::strerror(errno));
    parts.folders[parts.count++] = top;
  }
  mounted_stick_ = plant_.sticks_plugged();
  return parts;
}

Expected<bool> SimStickPort::do_store(const StickReport& report) {
  auto parts = do_mount();
  PLUMBLINE_TRY(parts);
  int reason = ENOENT;
  for (std::size_t i = 0; i < parts->count && reason == ENOENT; ++i) {
    reason = copy_report(parts->folders[i], report.name, report.file, report.from, report.bytes);
  }
  parts->close();
  if (reason == EEXIST) return false;
  if (reason != 0) return not_stored(reason);
  return true;
}

Status SimStickPort::do_check_mounted() const {
  if (do_has_stick() && mounted_stick_ == plant_.sticks_plugged()) return {};
  return fail(ErrorCode::kStickGone, "the stick was pulled:\tplug it in and start again");
}

Expected<std::size_t> SimStickPort::do_read(int file, std::span<std::byte> buffer) {
  const SimCall call(plant_);
  PLUMBLINE_TRY(do_check_mounted());
  // Small reads, so that a pull can also hit the middle of a file.
  buffer = buffer.first(std::min<std::size_t>(buffer.size(), 65536));
  const auto got = ::read(file, buffer.data(), buffer.size());
  if (got < 0) return fail(ErrorCode::kCannotRead, "%s", std::strerror(errno));
  const double slower = plant_.has_fault(FaultKind::kStickSlow) ? plant_.amount(FaultKind::kStickSlow) : 1;
  const std::chrono::duration<double> takes(static_cast<double>(got) /
                                            (plant_.settings().stick_bytes_per_second * slower));
  PLUMBLINE_TRY(plant_.wait_until(plant_.now() + std::chrono::duration_cast<nanoseconds>(takes),
                                  [this] { return !do_check_mounted(); }));
  PLUMBLINE_TRY(do_check_mounted());
  if (plant_.has_fault(FaultKind::kStickBadSector)) {
    return fail(ErrorCode::kCannotRead, "the stick has bad sectors:\tcopy the scan to another stick");
  }
  return static_cast<std::size_t>(got);
}

}  // namespace plumbline::inline hal::inline sim
