#include "firmware/io/interrupt.hpp"

#include <csignal>

namespace plumbline::firmware {
namespace {

volatile std::sig_atomic_t mark =
    0;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables): all a signal handler may write

extern "C" void set_mark(int /*signal*/) { mark = 1; }

}  // namespace

void catch_interrupts() {
  mark = 0;
  struct sigaction action = {};
  action.sa_handler = set_mark;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
}

bool interrupted() { return mark != 0; }

}  // namespace plumbline::firmware
