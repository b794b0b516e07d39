#include "firmware/daemon/upload/upload_port.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "firmware/messages/printer_code.hpp"

namespace plumbline::firmware {
namespace {

tl::unexpected<Error> none() { return fail(ErrorCode::kNoStick, "no scan has been uploaded:\tupload one"); }

}  // namespace

Expected<StickIdentity> UploadPort::do_identity() const {
  if (!do_has_stick()) return none();
  return StickIdentity{};
}

Expected<StickParts> UploadPort::do_mount() {
  if (!do_has_stick()) return none();
  const int folder = store_.open_folder();
  if (folder < 0) return fail(ErrorCode::kMountFailed, "the uploaded scan can't be read: %s", std::strerror(errno));
  mounted_ = store_.kept_count();
  return StickParts{{folder}, 1};
}

Expected<bool> UploadPort::do_store(const StickReport& /*report*/) { return not_stored(EROFS); }

Expected<std::size_t> UploadPort::do_read(int file, std::span<std::byte> buffer) {
  for (;;) {
    const ssize_t got = ::read(file, buffer.data(), buffer.size());
    if (got >= 0) return static_cast<std::size_t>(got);
    if (errno != EINTR) return fail(ErrorCode::kCannotRead, "%s", std::strerror(errno));
  }
}

Status UploadPort::do_check_mounted() const {
  if (mounted_ == store_.kept_count()) return {};
  if (!do_has_stick()) return none();
  return telling(
      Told(PrinterCode::kUploadReplaced),
      fail(ErrorCode::kStickGone, "another scan was uploaded meanwhile:\tstart that one, or upload this one again"));
}

}  // namespace plumbline::firmware
