#pragma once

#include "hal/sim/plant/plant.hpp"
#include "hal/stick_port.hpp"

namespace plumbline::inline hal::inline sim {

/// A folder that plays a stick. If its path is "stick", folders "stick.2", "stick.3", ... beside it play further partitions.
class SimStickPort final : public StickPort {
 public:
  SimStickPort(Plant& plant, Interlock& interlock) : StickPort(interlock), plant_(plant) {}

 private:
  bool do_has_stick() const override;
  Expected<StickIdentity> do_identity() const override;
  Expected<StickParts> do_mount() override;
  Expected<bool> do_store(const StickReport& report) override;
  Expected<std::size_t> do_read(int file, std::span<std::byte> buffer) override;
  Status do_check_mounted() const override;
  /// Reading takes virtual time and can fail, which only do_read() knows.
  bool do_has_real_files() const override { return false; }

  Plant& plant_;
  std::uint32_t mounted_stick_ = 0;  ///< Plant::sticks_plugged() when it was mounted
};

}  // namespace plumbline::inline hal::inline sim
