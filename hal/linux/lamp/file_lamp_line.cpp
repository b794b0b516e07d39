#include "hal/linux/lamp/file_lamp_line.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <ctime>

namespace plumbline {

FileLampLine::FileLampLine(const std::string& path)
    : file_(::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644)) {}

FileLampLine::~FileLampLine() {
  if (lit_) static_cast<void>(set(false));
  if (file_ >= 0) ::close(file_);
}

bool FileLampLine::set(bool lit) noexcept {
  if (lit == lit_) return true;
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  char text[48];
  const int size = std::snprintf(text, sizeof text, "%s %lld\n", lit ? "on" : "off",
                                 static_cast<long long>(now.tv_sec) * 1'000'000'000 + now.tv_nsec);
  if (::write(file_, text, static_cast<std::size_t>(size)) != size) return false;
  lit_ = lit;
  return true;
}

}  // namespace plumbline
