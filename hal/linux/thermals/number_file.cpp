#include "hal/linux/thermals/number_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <utility>

namespace plumbline::inline hal::inline linux_board {

Expected<NumberFile> NumberFile::open(const std::string& path, Access access) {
  const int file = ::open(path.c_str(), (access == Access::kRead ? O_RDONLY : O_RDWR) | O_CLOEXEC);
  if (file < 0) return fail(ErrorCode::kCannotOpen, "%s: %s", path.c_str(), std::strerror(errno));
  return NumberFile(file);
}

NumberFile::NumberFile(NumberFile&& other) noexcept : file_(std::exchange(other.file_, -1)) {}

NumberFile::~NumberFile() {
  if (file_ >= 0) ::close(file_);
}

std::optional<std::int64_t> NumberFile::read() const noexcept {
  std::array<char, 32> text{};
  errno = 0;
  const auto got = ::pread(file_, text.data(), text.size(), 0);
  if (got <= 0) return std::nullopt;
  std::int64_t number = 0;
  const auto [stop, problem] = std::from_chars(text.data(), text.data() + got, number);
  if (problem != std::errc() || (stop != text.data() + got && *stop != '\n')) return std::nullopt;
  return number;
}

bool NumberFile::write(std::int64_t number) noexcept {
  std::array<char, 32> text{};
  char* end = std::to_chars(text.data(), text.data() + text.size() - 1, number).ptr;
  *end++ = '\n';
  const auto size = static_cast<std::size_t>(end - text.data());
  return ::pwrite(file_, text.data(), size, 0) == static_cast<ssize_t>(size);
}

}  // namespace plumbline::inline hal::inline linux_board
