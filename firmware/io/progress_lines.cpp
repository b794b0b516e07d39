#include "firmware/io/progress_lines.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "firmware/io/fixed_text.hpp"

namespace plumbline {
namespace {

constexpr int kBarWidth = 24;  ///< characters
constexpr std::string_view kFull = "########################";
constexpr std::string_view kEmpty = "........................";
static_assert(kFull.size() == kBarWidth && kEmpty.size() == kBarWidth);

/// Back to the start of the line, and nothing on it.
constexpr const char* kEraseLine = "\r\033[K";

}  // namespace

void write_to_stderr(std::string_view text) {
  while (!text.empty()) {
    const ssize_t put = ::write(STDERR_FILENO, text.data(), text.size());
    if (put < 0 && errno != EINTR) return;
    if (put > 0) text.remove_prefix(static_cast<std::size_t>(put));
  }
}

ProgressLines::ProgressLines() : terminal_(::isatty(STDERR_FILENO) == 1) {}

void ProgressLines::begin(std::string_view stage) {
  drawn_at_ = 0;
  draw(stage, 0, 0);
}

void ProgressLines::update(std::string_view stage, double fraction, double seconds) {
  if (seconds - drawn_at_ < kSecondsBetween) return;
  drawn_at_ = seconds;
  draw(stage, fraction, seconds);
}

void ProgressLines::draw(std::string_view stage, double fraction, double seconds) {
  if (!terminal_) return;
  const double shown = std::clamp(fraction, 0.0, 1.0);
  const int full = static_cast<int>(shown * kBarWidth);
  FixedText<128> line;
  line.add("%s  %-11.*s %.*s%.*s %3d %% %6.1f s", kEraseLine, static_cast<int>(stage.size()), stage.data(), full,
           kFull.data(), kBarWidth - full, kEmpty.data(), static_cast<int>(shown * 100), seconds);
  write_to_stderr(line.view());
}

void ProgressLines::clear() {
  if (terminal_) write_to_stderr(kEraseLine);
}

void ProgressLines::end(std::string_view stage, double seconds, std::size_t peak_bytes) {
  FixedText<128> line;
  line.add("%s  %-11.*s %7.2f s   arena %7.1f MiB\n", terminal_ ? kEraseLine : "", static_cast<int>(stage.size()),
           stage.data(), seconds, static_cast<double>(peak_bytes) / (1024.0 * 1024.0));
  write_to_stderr(line.view());
}

}  // namespace plumbline
