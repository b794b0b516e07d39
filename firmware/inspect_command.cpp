#include "firmware/commands.hpp"

namespace plumbline {

ExitCode run_inspect(const JobOptions& /*options*/, std::span<std::byte> /*arena_block*/) { return ExitCode::kDone; }

}  // namespace plumbline
