#pragma once
/// Progress on standard error: a bar that moves on a terminal, a line for each finished stage elsewhere.

#include <cstddef>
#include <string_view>

#include "firmware/io/job_progress.hpp"

namespace plumbline {

/// Takes no memory from the heap. A terminal is drawn to at most 10 times a second.
class ProgressLines final : public ProgressDisplay {
 public:
  static constexpr double kSecondsBetween = 0.1;

  ProgressLines();

  void begin(std::string_view stage) override;
  void update(std::string_view stage, double fraction, double seconds) override;
  void end(std::string_view stage, double seconds, std::size_t peak_bytes) override;

  /// Takes an unfinished bar away.
  void clear();

 private:
  void draw(std::string_view stage, double fraction, double seconds);

  bool terminal_;
  double drawn_at_ = 0;  ///< seconds into the stage
};

/// Writes text to standard error, and asks no questions: who closed it does not want to hear.
void write_to_stderr(std::string_view text);

}  // namespace plumbline
