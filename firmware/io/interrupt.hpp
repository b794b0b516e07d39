#pragma once
/// Ctrl-C, and the polite way of ending a process from outside.

namespace plumbline {

/// From now on SIGINT and SIGTERM only set a mark, so that a job can end in order. The second of a kind ends the process at
/// once, as if this had never been called. Writing past a file size limit or into a closed pipe becomes an error of write().
void catch_interrupts();

/// A signal has come since catch_interrupts().
bool interrupted();

}  // namespace plumbline
