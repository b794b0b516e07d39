#pragma once

#include <cstdio>
#include <cstdlib>

namespace plumbline::firmware::fuzz {

/// Ends the program if `truth` does not hold, so that the fuzzer keeps the input.
inline void require(bool truth, const char* what) {
  if (truth) return;
  std::fprintf(stderr, "broken: %s\n", what);
  std::abort();
}

}  // namespace plumbline::firmware::fuzz
