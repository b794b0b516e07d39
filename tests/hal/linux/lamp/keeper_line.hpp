#pragma once
/// A lamp line played by a file, and the keeper that holds it, for tests with real processes.

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "hal/linux/events/clock.hpp"
#include "hal/linux/lamp/lamp_keeper.hpp"

namespace plumbline {

using namespace std::chrono_literals;

struct Change {
  bool lit;
  nanoseconds at;
};

/// A lamp line: a file in a temporary folder.
class Line {
 public:
  Line() {
    std::string pattern = (std::filesystem::temp_directory_path() / "plumbline-keeper-XXXXXX").string();
    EXPECT_NE(::mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  ~Line() { std::filesystem::remove_all(folder_); }
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;

  const std::string& folder() const { return folder_; }
  LampKeeper::Settings settings() const { return {.program = PLUMBLINE_KEEPER, .line = "file:" + path()}; }
  std::vector<Change> changes() const {
    std::ifstream file(path());
    std::vector<Change> changes;
    std::string word;
    for (long long at = 0; file >> word >> at;) changes.push_back({word == "on", nanoseconds(at)});
    return changes;
  }
  /// Waits at most 1 s for `count` changes.
  std::vector<Change> wait_for(std::size_t count) const {
    const auto until = monotonic_now() + 1s;
    auto seen = changes();
    while (seen.size() < count && monotonic_now() < until) {
      ::usleep(500);
      seen = changes();
    }
    return seen;
  }

 private:
  std::string path() const { return folder_ + "/line"; }
  std::string folder_;
};

}  // namespace plumbline
