#include "hal/linux/keeper/file_lamp_line.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <string_view>
#include <utility>

namespace plumbline::inline hal::inline linux_board {
namespace {

constexpr std::size_t kLongestChange = 48;  // bytes

}  // namespace

FileLampLine::FileLampLine(const std::string& path)
    : file_(::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644)) {
  if (file_ >= 0 && ::flock(file_, LOCK_EX | LOCK_NB) != 0) ::close(std::exchange(file_, -1));
  lit_ = was_left_lit();
  if (lit_) static_cast<void>(set(false));
}

FileLampLine::~FileLampLine() {
  if (lit_) static_cast<void>(set(false));
  if (file_ >= 0) ::close(file_);
}

bool FileLampLine::was_left_lit() const {
  std::array<char, kLongestChange> tail{};
  const off_t size = ::lseek(file_, 0, SEEK_END);
  const ssize_t got = ::pread(file_, tail.data(), tail.size(), std::max<off_t>(0, size - std::ssize(tail)));
  const std::string_view text(tail.data(), got > 0 ? static_cast<std::size_t>(got) : 0);
  const auto on = text.rfind("on ");
  return on != std::string_view::npos && text.find("off ", on) == std::string_view::npos;
}

bool FileLampLine::set(bool lit) noexcept {
  if (lit == lit_) return true;
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  char text[kLongestChange];
  const int size = std::snprintf(text, sizeof text, "%s %lld\n", lit ? "on" : "off",
                                 static_cast<long long>(now.tv_sec) * 1'000'000'000 + now.tv_nsec);
  if (::write(file_, text, static_cast<std::size_t>(size)) != size) return false;
  lit_ = lit;
  return true;
}

}  // namespace plumbline::inline hal::inline linux_board
