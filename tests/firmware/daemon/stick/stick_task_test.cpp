/// Job files in real children, and damaged answers about them.

#include "firmware/daemon/stick/stick_task.hpp"

#include <gmock/gmock.h>

#include <functional>
#include <limits>
#include <random>

#include "tests/firmware/child/child_fixture.hpp"

namespace plumbline::firmware {
namespace {

using ::testing::HasSubstr;

class StickTask : public ChildTest {
 protected:
  ScanAnswer answer_to(const std::string& text) {
    const std::string path = folder_ / "job.toml";
    write_text(path, text);
    ScanRequest request;
    request.is_job_file = true;
    request.name.add("job.toml");
    request.add_file("job.toml", std::nullopt);
    EXPECT_EQ(run(child_, request, path), 0);
    return child_.answer();
  }

  SlicingChild child_ = make(1, run_stick_task);
};

TEST_F(StickTask, ReadsAJobFileAsThisProcessDoes) {
  const std::string texts[] = {
      "[job]\nscan = 'a.ply'\n",
      "[job]\nscan = 'b/c.ply'\nprofile = 'my resin'\nsupports = 'auto'\nbase = 'none'\nkeep_all = true\n[placement]\n"
      "units = 'in'\nscale = 1.5\nfit = true\nrotate_x_deg = -90\nrotate_y_deg = 1e-3\nrotate_z_deg = 360\n"
      "layer_height = 0.05\n",
      "[job]\nscan = 'a.ply'\nsupports = 'none'\nbase = 'flat'\n",
      "[job]\nscan = 'a.ply'\n[supports]\nsupport_preset = 'heavy'\nsupport_stand = 'raised'\n"
      "support_buildplate_only = false\nsupport_object_elevation = 3\n",
      "[job]\nscan = 'a.ply'\n[supports]\nsupport_at = [[1, 2, 3.5], [-4, 5, 6]]\nno_support_at = [[7, 8, 9]]\n",
      "[job]\nscan = 'a.ply'\n[placement]\nheight = '8 cm'\norient = 'auto'\nkeep_clean = '+z'\n",
      "[job]\nscan = 'a.ply'\nfloor = 'keep'\n",
      "[job]\nscan = 'a.ply'\nfloor = '-3.5'\n",
      "[job]\nscan = 'a.ply'\n[placement]\nlength = '3.15in'\n",
      "[job]\nscan = ['front.ply', 'back.ply', 'top.xyz']\n"};
  for (const auto& text : texts) {
    const auto expected = parse_stick_job(text, "job.toml").value();
    const auto job = check_job_answer(answer_to(text));
    ASSERT_TRUE(job) << job.error().message();
    EXPECT_TRUE(*job == expected) << text;
  }
}

TEST_F(StickTask, ReportsMistakesInTheWordsOfTheParser) {
  for (const std::string text : {"[job]\nscan = 'a.ply'\nscael = 2\n", "[job\n", "[job]\nscan = ''\n"}) {
    const auto job = check_job_answer(answer_to(text));
    ASSERT_FALSE(job);
    const auto expected = parse_stick_job(text, "job.toml");
    EXPECT_EQ(job.error().code(), expected.error().code());
    EXPECT_STREQ(job.error().message(), expected.error().message());
  }
  const auto large = check_job_answer(answer_to(std::string(100'000, '#')));
  ASSERT_FALSE(large);
  EXPECT_THAT(large.error().message(), HasSubstr("job.toml"));
}

TEST_F(StickTask, BelievesNoFieldOutOfRange) {
  const ScanAnswer good = answer_to("[job]\nscan = 'a.ply'\n");
  ASSERT_TRUE(check_job_answer(good));
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const std::function<void(JobAnswer&)> changes[] = {
      [](JobAnswer& job) { job.scan[0][0] = '\0'; },
      [](JobAnswer& job) { job.scans = 0; },
      [](JobAnswer& job) { job.scans = 2; },
      [](JobAnswer& job) { job.scans = 33; },
      [](JobAnswer& job) { job.keep_clean = 7; },
      [](JobAnswer& job) { job.profile[0] = '/'; },
      [](JobAnswer& job) { job.units = 5; },
      [](JobAnswer& job) { job.base = 3; },
      [](JobAnswer& job) { job.supports.words[0] = 3; },
      [](JobAnswer& job) { job.supports.words[1] = 4; },
      [](JobAnswer& job) { job.supports.words[2] = 4; },
      [](JobAnswer& job) { job.supports.has[0] = 1, job.supports.value[0] = kNaN; },
      [](JobAnswer& job) { job.fit = 2; },
      [](JobAnswer& job) { job.keep_all = 256; },
      [](JobAnswer& job) { job.scale = 0; },
      [](JobAnswer& job) { job.scale = kNaN; },
      [](JobAnswer& job) { job.rotate_deg[1] = 361; },
      [](JobAnswer& job) { job.rotate_deg[2] = kNaN; },
      [](JobAnswer& job) { job.layer_height = 2; },
  };
  for (const auto& change : changes) {
    ScanAnswer answer = good;
    change(answer.job);
    EXPECT_FALSE(check_job_answer(answer));
  }
  ScanAnswer other = good;
  other.kind = ScanAnswer::kSliced;
  EXPECT_FALSE(check_job_answer(other));
  std::mt19937 random(7);
  for (int i = 0; i < 10'000; ++i) {
    ScanAnswer answer = good;
    const auto bytes = std::as_writable_bytes(std::span(&answer.job, 1));
    for (int times = 0; times < 3; ++times) bytes[random() % bytes.size()] = static_cast<std::byte>(random());
    const auto job = check_job_answer(answer);
    EXPECT_TRUE(!job || (job->scans.size() <= kMostScans && job->scans[0].size() < 256U));
  }
}

}  // namespace
}  // namespace plumbline::firmware
