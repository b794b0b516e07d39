#pragma once
/// The simulated lamp's line as a wire that exists, for who looks at it from outside.

#include <chrono>

namespace plumbline {

class LampWire {
 public:
  LampWire() = default;
  LampWire(const LampWire&) = delete;
  LampWire& operator=(const LampWire&) = delete;
  virtual ~LampWire() = default;

  /// Arms off, then turns on.
  /// @param cure  virtual time after which it is to be off by itself
  /// @returns false: it is off, for off could not be armed
  virtual bool light(std::chrono::nanoseconds cure) = 0;
  virtual void darken() noexcept = 0;
};

}  // namespace plumbline
