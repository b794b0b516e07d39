#pragma once
/// Scans in real slicing children.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <string>
#include <vector>

#include "firmware/child/answer_check.hpp"
#include "firmware/child/rights.hpp"
#include "firmware/child/slicing_child.hpp"
#include "tests/firmware/support/job_fixture.hpp"

namespace plumbline::firmware {

/// Whether this is a build with a sanitizer, in which system calls are not filtered.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kHasSanitizer = true;
#elif defined(__has_feature)
inline constexpr bool kHasSanitizer = __has_feature(address_sanitizer) || __has_feature(thread_sanitizer);
#else
inline constexpr bool kHasSanitizer = false;
#endif

class ChildTest : public testing::Test {
 protected:
  static constexpr std::size_t kArenaBytes = std::size_t{48} << 20U;

  static SlicingChild make(std::uint32_t threads, ChildTask task = run_scan_task) {
    auto made = SlicingChild::make(kArenaBytes, threads, task);
    if (!made) throw std::runtime_error(made.error().message());
    return std::move(*made);
  }

  static ScanRequest request_of(const std::string& path, std::uint32_t threads, bool supports = false) {
    ScanRequest request;
    request.name.add("%s", path.substr(path.rfind('/') + 1).c_str());
    request.add_file(request.name.view(), std::filesystem::file_size(path));
    request.settings.placement.printer = small_printer();
    request.settings.placement.layer_height_mm = 0.1F;
    request.settings.threads = threads;
    if (supports) request.settings.supports = SupportSettings();
    return request;
  }

  /// Runs one child. @returns its status as wait(2) gives it
  static int run(SlicingChild& child, const ScanRequest& request, const std::string& path) {
    const Descriptor scan(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    const auto started = child.start(request, scan.get());
    EXPECT_TRUE(started) << started.error().message();
    for (int waits = 0;; ++waits) {
      if (waits == 60) {
        ADD_FAILURE() << "the child hangs";
        child.kill();
      }
      const auto ended = child.wait(std::chrono::seconds(1));
      if (!ended) {
        ADD_FAILURE() << ended.error().message();
        return -1;
      }
      if (*ended) return **ended;
    }
  }

  TemporaryFolder folder_;
};

}  // namespace plumbline::firmware
