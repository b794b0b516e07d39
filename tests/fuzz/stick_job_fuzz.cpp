/// Any text as a stick's job.toml: accepted with every number in its range, or refused with the file's name and a reason.

#include <cmath>
#include <cstdint>
#include <string_view>

#include "firmware/daemon/stick/stick_job.hpp"
#include "firmware/settings/job_options.hpp"
#include "slicer/reader/scan_sources.hpp"
#include "tests/fuzz/require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace plumbline;
  using namespace plumbline::firmware;
  using namespace plumbline::firmware::fuzz;
  const auto job = parse_stick_job({reinterpret_cast<const char*>(bytes), size}, kJobFile);
  if (!job) {
    require(job.error().code() == ErrorCode::kMalformed || job.error().code() == ErrorCode::kBadSetting,
            "another kind of error");
    const std::string_view message = job.error().message();
    require(message.starts_with(kJobFile), "an error without the file's name");
    require(message.size() > std::string_view(kJobFile).size() + 2, "an error without a reason");
    return 0;
  }
  require(!job->scans.empty() && job->scans.size() <= kMostScans, "the number of files");
  for (const std::string& scan : job->scans) require(!scan.empty() && scan.size() <= 255, "a file's name");
  require(job->scale >= kSmallestScale && job->scale <= kLargestScale, "scale");
  for (const double degrees : {job->rotate_x_deg, job->rotate_y_deg, job->rotate_z_deg}) {
    require(std::abs(degrees) <= 360, "rotation");
  }
  require(job->layer_height == 0 || (job->layer_height >= kFinestMm && job->layer_height <= kCoarsestMm),
          "layer height");
  return 0;
}
