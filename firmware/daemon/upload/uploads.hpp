#pragma once
/// Stores scans that clients of the state socket upload, and offers the newest one as a stick would.

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "firmware/daemon/upload/upload_port.hpp"
#include "firmware/daemon/upload/upload_store.hpp"
#include "firmware/io/descriptor.hpp"
#include "firmware/messages/printer_code.hpp"
#include "firmware/state/client_request.hpp"
#include "firmware/state/printer_record.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

/// Times by the host's clock.
struct UploadTimes {
  /// Nothing has come for so long: whoever sends has gone, or the network has.
  std::chrono::nanoseconds silence = std::chrono::seconds(15);
  /// Between two numbers of bytes in the record, each of which becomes a state line.
  std::chrono::nanoseconds told = std::chrono::milliseconds(200);
  /// One turn takes bytes for no longer.
  std::chrono::nanoseconds turn = std::chrono::milliseconds(10);
};

class Uploads {
 public:
  using HostClock = std::chrono::steady_clock;

  /// Slower than this on average, and after the first minute, an upload is ended: it would hold its place for ever.
  static constexpr std::uint64_t kSlowestBytesPerSecond = std::uint64_t{16} << 10U;

  /// @param record  must outlive it; what comes is written there
  Uploads(UploadStore store, PrinterRecord& record, const UploadTimes& times = {});
  Uploads(const Uploads&) = delete;
  Uploads& operator=(const Uploads&) = delete;

  /// Begins to take a scan.
  /// @param from  what was handed over: a connected stream socket of this machine, else it is refused, since reading anything else may block
  /// @returns the number of PrinterRecord::upload
  /// @retval ErrorCode::kBadSetting  the printer is not at rest, takes none or is taking one; or the errors of check_upload_name()
  /// @retval the errors of UploadStore::begin()
  [[nodiscard]] Expected<std::uint32_t> begin(const ClientRequest& request, Descriptor from);

  /// Removes the scan that is kept.
  /// @param name  of PrinterRecord::stored, so that nobody removes another one than they have seen
  /// @retval ErrorCode::kBadSetting   there is none of that name: which one there is
  /// @retval the errors of UploadStore::remove()
  [[nodiscard]] Status remove(std::string_view name);

  /// Takes what has come, without waiting, unless a mask could become late: then the upload ends.
  /// @returns whether a scan has just become whole
  bool receive();
  bool is_coming() const { return from_.is_open(); }

  /// The scan that is kept, as on a stick.
  StickPort& port() { return port_; }
  /// Whether there is a scan that has come since the last call.
  bool take_new() { return std::exchange(is_new_, false); }
  bool is_new() const { return is_new_; }

 private:
  bool keep();
  void end(const Error& error);
  /// A code, and how much has come of how much.
  Told how_far(PrinterCode code) const;
  void tell(HostClock::time_point now);
  void record_kept();

  UploadStore store_;
  PrinterRecord& record_;
  UploadTimes times_;
  UploadPort port_{store_};
  Descriptor from_;
  std::uint32_t number_ = 0;
  std::uint64_t received_ = 0;
  HostClock::time_point heard_at_, told_at_, until_;
  bool is_new_ = false;
  std::array<std::byte, std::size_t{64} * 1024> bytes_{};
};

}  // namespace plumbline::firmware
