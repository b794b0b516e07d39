#include "hal/linux/keeper/file_cover_line.hpp"

#include <fcntl.h>
#include <unistd.h>

#include "hal/linux/events/clock.hpp"

namespace plumbline::inline hal::inline linux_board {

// O_RDWR: a FIFO without a writer would always be readable, at end of file.
FileCoverLine::FileCoverLine(const std::string& path) : file_(::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC)) {}

FileCoverLine::~FileCoverLine() {
  if (file_ >= 0) ::close(file_);
}

std::optional<CoverLine::Edge> FileCoverLine::next_edge() noexcept {
  char word = 0;
  if (::read(file_, &word, 1) != 1) return std::nullopt;
  open_ = word == 'o';
  return Edge{open_, monotonic_now()};
}

}  // namespace plumbline::inline hal::inline linux_board
