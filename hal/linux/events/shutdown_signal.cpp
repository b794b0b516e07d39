#include "hal/linux/events/shutdown_signal.hpp"

#include <sys/signalfd.h>
#include <unistd.h>

namespace plumbline::inline hal::inline linux_board {

ShutdownSignal::ShutdownSignal(EventQueue& events) : events_(events) {
  sigset_t signals;
  ::sigemptyset(&signals);
  ::sigaddset(&signals, SIGTERM);
  ::pthread_sigmask(SIG_BLOCK, &signals, &former_);
  file_ = ::signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK);
}

ShutdownSignal::~ShutdownSignal() {
  if (file_ >= 0) ::close(file_);
  ::pthread_sigmask(SIG_SETMASK, &former_, nullptr);
}

void ShutdownSignal::drain(std::chrono::nanoseconds now) {
  signalfd_siginfo signal{};
  while (::read(file_, &signal, sizeof signal) == sizeof signal) events_.add(EventKind::kShutdownRequested, now);
}

}  // namespace plumbline::inline hal::inline linux_board
