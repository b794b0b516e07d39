#pragma once
/// Progress on standard error: a bar that moves on a terminal, a line for each finished step elsewhere.

#include <chrono>
#include <cstddef>
#include <string_view>

#include "firmware/io/job_progress.hpp"
#include "firmware/io/text/fixed_text.hpp"
#include "firmware/io/whole_progress.hpp"
#include "slicer/core/words/printable_text.hpp"

namespace plumbline::firmware {

/// "2 h 05 min", "3 min 20 s", "45 min": whole seconds below 10 min, else minutes.
FixedText<24> duration_text(std::chrono::nanoseconds time);

/// "  slicing              ############............  50 %   12.0 s, 12 s left". The time left follows from the time so far.
/// @param fraction  of the work, 0 to 1
/// @param seconds   since the work began
FixedText<128> progress_text(std::string_view words, double fraction, double seconds);

/// One line of progress_text(), which replaces itself. Takes no memory from the heap. Draws on a terminal only, at
/// most 10 times a second.
class ProgressBar {
 public:
  ProgressBar();
  ~ProgressBar() { clear(); }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// @param fraction, seconds  of progress_text()
  void update(std::string_view words, double fraction, double seconds);
  /// Removes the bar, if one is shown.
  void clear();

 private:
  bool terminal_;
  bool shown_ = false;
  double drawn_at_ = 0;  ///< seconds, as in update()
};

/// The progress of slicing: one bar for the whole of it, and a line at the end of each step. Stages that mean nothing to a user
/// are joined to steps: "reading the scan", "finding the surface".
class ProgressLines final : public ProgressDisplay {
 public:
  /// @param verbose  a line for each stage of the slicer, with its time and its memory
  /// @param whole    what the bar is about
  explicit ProgressLines(bool verbose = false, const WholeProgress& whole = WholeProgress())
      : verbose_(verbose), whole_(whole) {}

  void begin(Stage stage) override;
  void update(Stage stage, double fraction, double seconds) override;
  void end(Stage stage, double seconds, std::size_t peak_bytes) override;
  void averages(std::uint32_t points) override;
  void lies_wrong(double x_degrees, double y_degrees) override;

  /// Writes a warning on a line of its own, unless lies_wrong() has written the same sentence.
  void warn(std::string_view sentence);

 private:
  bool verbose_;
  WholeProgress whole_;
  ProgressBar bar_;
  std::string_view step_;     ///< words of the step that runs
  double step_seconds_ = 0;   ///< of its stages that have ended
  double ended_seconds_ = 0;  ///< of all stages that have ended
  FixedText<128> told_;       ///< by lies_wrong(); empty: nothing
};

/// Writes a line to standard error. A failure of this and of the others is ignored: there is nowhere left to report it.
void write_line(const PrintableText& line);
/// Puts `line` in the place of the terminal's last line, which it leaves open for the next one.
void draw_line(const PrintableText& line);
/// Clears the terminal's last line.
void erase_line();

}  // namespace plumbline::firmware
