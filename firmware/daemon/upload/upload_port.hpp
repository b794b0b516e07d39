#pragma once

#include "firmware/daemon/upload/upload_store.hpp"
#include "hal/stick_port.hpp"

namespace plumbline::firmware {

/// The interlock that StickPort asks for. It stands for no device, since uploads are files of the printer.
struct UploadPortPower {
  Interlock interlock;
};

/// The scan that was uploaded, as on a stick.
class UploadPort final : private UploadPortPower, public StickPort {
 public:
  /// @param store  must outlive it
  explicit UploadPort(const UploadStore& store) : StickPort(interlock), store_(store) {}

 private:
  bool do_has_stick() const override { return !store_.kept().empty(); }
  Expected<StickIdentity> do_identity() const override;
  Expected<StickParts> do_mount() override;
  Expected<bool> do_store(const StickReport& report) override;
  Expected<std::size_t> do_read(int file, std::span<std::byte> buffer) override;
  /// @retval ErrorCode::kStickGone  another scan is kept since
  /// @retval ErrorCode::kNoStick    it was removed
  Status do_check_mounted() const override;
  bool do_has_real_files() const override { return true; }

  const UploadStore& store_;
  std::uint32_t mounted_ = 0;  ///< UploadStore::kept_count() then
};

}  // namespace plumbline::firmware
