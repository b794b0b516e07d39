#include "firmware/messages/exit_code.hpp"

#include "firmware/io/progress_lines.hpp"
#include "firmware/messages/told_text.hpp"

namespace plumbline::firmware {

ExitCode report_error(const Error& error) {
  FixedText<1032> line;
  line.add("plumbline: %s", at_terminal(error).c_str());
  write_line(line.view());
  return error.code() == ErrorCode::kCancelled ? ExitCode::kInterrupted : ExitCode::kWorldError;
}

}  // namespace plumbline::firmware
