#pragma once

#include "hal/clock.hpp"

namespace plumbline::firmware {

/// A lamp line that the keeper process holds. The keeper turns it off at the end of the time, and when this process dies.
class KeptLampLine {
 public:
  KeptLampLine() = default;
  KeptLampLine(const KeptLampLine&) = delete;
  KeptLampLine& operator=(const KeptLampLine&) = delete;
  virtual ~KeptLampLine() = default;

  /// @param cure  host time, above 0
  /// @returns false: the line is off, because turning it off could not be armed
  virtual bool light(nanoseconds cure) = 0;
  virtual void turn_off() noexcept = 0;
};

}  // namespace plumbline::firmware
