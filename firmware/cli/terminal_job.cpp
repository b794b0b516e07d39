#include "firmware/cli/terminal_job.hpp"

#include "firmware/io/interrupt.hpp"

namespace plumbline::firmware {

TerminalJob::TerminalJob(const JobOptions& options, const JobSetup& setup, std::span<std::byte> arena_block,
                         const WholeProgress& whole)
    : arena_(arena_block.first(setup.arena_bytes)),
      silent_(options.quiet || options.json),
      lines_(options.verbose, whole),
      progress_(silent_ ? nullptr : &lines_) {
  catch_interrupts();
}

void TerminalJob::warn(std::string_view sentence) {
  if (!silent_) lines_.warn(sentence);
}

}  // namespace plumbline::firmware
