/// The program `plumbline-keeper`: holds the lamp's line for the firmware, which starts it.
///
///   plumbline-keeper --line file:PATH --firmware PID       socket to the firmware: descriptor 3

#include <sched.h>
#include <sys/mman.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "hal/linux/file_lamp_line.hpp"
#include "hal/linux/keeper.hpp"

int main(int argc, char** argv) {
  constexpr int kSocket = 3;
  std::string_view line;
  int firmware = 0;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--line") == 0) line = argv[i + 1];
    if (std::strcmp(argv[i], "--firmware") == 0) firmware = static_cast<int>(std::strtol(argv[i + 1], nullptr, 10));
  }
  constexpr std::string_view kFile = "file:";
  if (!line.starts_with(kFile) || firmware <= 0) {
    std::fputs("plumbline-keeper: started by the firmware: --line file:PATH --firmware PID\n", stderr);
    return 2;
  }
  // Both are for the deadline, and neither is allowed everywhere.
  static_cast<void>(::mlockall(MCL_CURRENT | MCL_FUTURE));
  sched_param priority{};
  priority.sched_priority = 50;
  static_cast<void>(::sched_setscheduler(0, SCHED_FIFO, &priority));

  plumbline::FileLampLine file(std::string(line.substr(kFile.size())));
  if (!file.ok()) {
    std::perror("plumbline-keeper: line");
    return 1;
  }
  return plumbline::keep_lamp(file, kSocket, firmware);
}
