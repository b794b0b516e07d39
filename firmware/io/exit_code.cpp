#include "firmware/io/exit_code.hpp"

#include "firmware/io/progress_lines.hpp"
#include "firmware/io/text/fixed_text.hpp"

namespace plumbline {

ExitCode report_error(const Error& error) {
  FixedText<Error::kCapacity + 32> line;
  line.add("plumbline: %s", error.message());
  write_line(line.view());
  return error.code() == ErrorCode::kCancelled ? ExitCode::kInterrupted : ExitCode::kWorldError;
}

}  // namespace plumbline
