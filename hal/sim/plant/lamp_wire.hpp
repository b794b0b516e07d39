#pragma once
/// A real line that follows the simulated lamp, so that another process can observe it.

#include <chrono>

namespace plumbline::inline hal::inline sim {

class LampWire {
 public:
  LampWire() = default;
  LampWire(const LampWire&) = delete;
  LampWire& operator=(const LampWire&) = delete;
  virtual ~LampWire() = default;

  /// Arms off, then turns on.
  /// @param cure  virtual time after which the line goes off by itself
  /// @returns false if off could not be armed; then the line is off
  virtual bool light(std::chrono::nanoseconds cure) = 0;
  virtual void turn_off() noexcept = 0;
};

}  // namespace plumbline::inline hal::inline sim
