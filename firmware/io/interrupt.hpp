#pragma once
/// Ctrl-C (SIGINT) and SIGTERM.

namespace plumbline::firmware {

/// From now on SIGINT and SIGTERM only set a flag, so that a job can end in order. A second signal of the same kind ends the
/// process at once. Writing past a file size limit or into a closed pipe becomes an error of write().
void catch_interrupts();

/// Whether a signal has arrived since catch_interrupts().
bool interrupted();

}  // namespace plumbline::firmware
