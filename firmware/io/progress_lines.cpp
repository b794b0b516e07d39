#include "firmware/io/progress_lines.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "firmware/io/text/fixed_text.hpp"

namespace plumbline::firmware {
namespace {

constexpr double kSecondsBetween = 0.1;  ///< two drawings: the eye sees motion, a serial console keeps up

/// Before so much time and so much of the work the time left is not told: it would be a guess.
constexpr double kTellsAfterS = 1;
constexpr double kTellsAfterShare = 0.05;

constexpr int kBarWidth = 24;  ///< characters
constexpr std::string_view kFull = "########################";
constexpr std::string_view kEmpty = "........................";
static_assert(kFull.size() == kBarWidth && kEmpty.size() == kBarWidth);

/// Clears the line and returns to its start.
constexpr const char* kEraseLine = "\r\033[K";

/// A stage as users see it: a part of a step.
struct StepPart {
  std::string_view step;
  bool ends_step = true;
};

/// @param writes  the layers, instead of only checking them
StepPart part_of(Stage stage, bool writes) {
  constexpr std::string_view kSurface = "finding the surface";
  constexpr std::string_view kSlicing = "slicing";
  switch (stage) {
    case Stage::kRead: return {"reading the scan"};
    case Stage::kTrees:
    case Stage::kNormals:
    case Stage::kViews:
    case Stage::kClustering:
    case Stage::kWindingTree: return {kSurface, false};
    case Stage::kRayGrid: return {kSurface};
    case Stage::kRays: return {kSlicing, false};
    case Stage::kRRep: return {kSlicing};
    case Stage::kSupports: return {"placing supports"};
    case Stage::kLayers: return {writes ? "writing the layers" : "checking the layers"};
  }
  return {};
}

void write_to_stderr(std::string_view text) {
  while (!text.empty()) {
    const ssize_t put = ::write(STDERR_FILENO, text.data(), text.size());
    if (put < 0 && errno != EINTR) return;
    if (put > 0) text.remove_prefix(static_cast<std::size_t>(put));
  }
}

}  // namespace

void write_line(const PrintableText& line) {
  FixedText<PrintableText::kCapacity + 1> text;
  text.add("%s\n", line.c_str());
  write_to_stderr(text.view());
}

void draw_line(const PrintableText& line) {
  FixedText<PrintableText::kCapacity + 8> text;
  text.add("%s%s", kEraseLine, line.c_str());
  write_to_stderr(text.view());
}

void erase_line() { write_to_stderr(kEraseLine); }

FixedText<24> duration_text(std::chrono::nanoseconds time) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(time).count();
  const auto minutes = static_cast<long long>(seconds / 60);
  FixedText<24> text;
  if (minutes >= 60) {
    text.add("%lld h %02lld min", minutes / 60, minutes % 60);
  } else if (minutes >= 10) {
    text.add("%lld min", minutes);
  } else if (minutes > 0) {
    text.add("%lld min %02lld s", minutes, static_cast<long long>(seconds % 60));
  } else {
    text.add("%lld s", static_cast<long long>(seconds));
  }
  return text;
}

FixedText<128> progress_text(std::string_view words, double fraction, double seconds) {
  const double part = std::clamp(fraction, 0.0, 1.0);
  const int full = static_cast<int>(part * kBarWidth);
  FixedText<128> line;
  line.add("  %-20.*s %.*s%.*s %3d %% %6.1f s", static_cast<int>(words.size()), words.data(), full, kFull.data(),
           kBarWidth - full, kEmpty.data(), static_cast<int>(part * 100), seconds);
  if (seconds < kTellsAfterS || part < kTellsAfterShare) return line;
  const std::chrono::duration<double> left(seconds * (1 - part) / part);
  line.add(", %s left", duration_text(std::chrono::ceil<std::chrono::seconds>(left)).c_str());
  return line;
}

ProgressBar::ProgressBar() : terminal_(::isatty(STDERR_FILENO) == 1) {}

void ProgressBar::update(std::string_view words, double fraction, double seconds) {
  if (!terminal_) return;
  if (shown_ && fraction < 1 && seconds >= drawn_at_ && seconds - drawn_at_ < kSecondsBetween) return;
  shown_ = true;
  drawn_at_ = seconds;
  draw_line(progress_text(words, fraction, seconds).view());
}

void ProgressBar::clear() {
  if (shown_) erase_line();
  shown_ = false;
}

void ProgressLines::begin(Stage stage) {
  const StepPart part = part_of(stage, whole_.writes());
  if (verbose_ || part.step != step_) step_seconds_ = 0;
  step_ = part.step;
  update(stage, 0, 0);
}

void ProgressLines::update(Stage stage, double fraction, double seconds) {
  const StepPart part = part_of(stage, whole_.writes());
  bar_.update(verbose_ ? to_string(stage) : part.step, whole_.reach(stage, fraction), ended_seconds_ + seconds);
}

void ProgressLines::averages(std::uint32_t points) {
  FixedText<128> line;
  line.add("  no surface found in %u points, averaging neighbours", points);
  bar_.clear();
  write_line(line.view());
}

void ProgressLines::lies_wrong(double x_degrees, double y_degrees) {
  FixedText<128> text;
  text.add("the scan seems to lie on its side or its head. To stand it up:");
  if (x_degrees != 0) text.add(" --rotate-x %.4g", x_degrees);
  if (y_degrees != 0) text.add(" --rotate-y %.4g", y_degrees);
  text.add(".");
  warn(text.view());
  told_ = text;
}

void ProgressLines::warn(std::string_view sentence) {
  if (sentence == told_.view()) return;
  FixedText<512> line;
  line.add("plumbline: warning: %.*s", static_cast<int>(sentence.size()), sentence.data());
  bar_.clear();
  write_line(line.view());
}

void ProgressLines::end(Stage stage, double seconds, std::size_t peak_bytes) {
  const StepPart part = part_of(stage, whole_.writes());
  update(stage, 1, seconds);
  step_seconds_ += seconds;
  ended_seconds_ += seconds;
  FixedText<128> line;
  if (verbose_) {
    const std::string_view name = to_string(stage);
    line.add("  %-20.*s %7.2f s   arena %7.1f MiB", static_cast<int>(name.size()), name.data(), seconds,
             static_cast<double>(peak_bytes) / (1024.0 * 1024.0));
  } else if (part.ends_step) {
    line.add("  %-20.*s %7.1f s", static_cast<int>(part.step.size()), part.step.data(), step_seconds_);
  } else {
    return;
  }
  bar_.clear();
  write_line(line.view());
}

}  // namespace plumbline::firmware
