#pragma once
/// A machine under test with somebody at it: what every back end is tested through.

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hal/machine.hpp"

namespace plumbline {

class Rig {
 public:
  Rig() = default;
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;
  virtual ~Rig() = default;

  virtual Machine machine() = 0;

  // Somebody's hands. Each acts `after` from now, while the machine may be at work.
  virtual void open_cover(nanoseconds after) = 0;
  virtual void close_cover(nanoseconds after) = 0;
  virtual void press(EventKind button, nanoseconds after) = 0;
  virtual void plug_stick(const std::string& folder, nanoseconds after) = 0;
  virtual void pull_stick(nanoseconds after) = 0;

  // Somebody's eyes.
  virtual bool light() = 0;             ///< a photodiode of the tester's own
  virtual nanoseconds time_lit() = 0;   ///< in all
  virtual Distance plate_height() = 0;  ///< a gauge of the tester's own
};

/// One way to make a rig, and its name.
struct RigMaker {
  const char* name;
  std::function<std::unique_ptr<Rig>()> make;
};

/// The rigs of all back ends in this build: rigs.cpp.
std::vector<RigMaker> rig_makers();

}  // namespace plumbline
