#include "firmware/print/job/job_store.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <limits>
#include <vector>

#include "firmware/io/random_id.hpp"
#include "firmware/print/job/job_file.hpp"
#include "tests/firmware/support/job_fixture.hpp"

namespace plumbline::firmware {
namespace {

using ::testing::ElementsAreArray;
using ::testing::HasSubstr;

constexpr std::array<std::uint32_t, 4> kFirst = {0, 2, 2, 5};
constexpr std::array<std::uint32_t, 5> kPacked = {1, 3, 1, 3, 7};

RRep small_rrep() { return {.grid = {.columns = 4, .rows = 2, .layers = 3}, .first = kFirst, .packed = kPacked}; }

constexpr std::array<Strut, 2> kSupports = {
    {{.column0 = 1, .row0 = 1, .column1 = 1, .row1 = 1, .first = 0, .end = 3, .radius0 = 500, .radius1 = 200},
     {.column0 = 3, .row0 = 0, .column1 = 3, .row1 = 1, .first = 1, .end = 2, .radius0 = 200, .radius1 = 200}}};

Supports small_supports() { return {.list = kSupports, .pitch = PixelPitch(small_rrep().grid)}; }

JobFacts facts() {
  JobFacts facts;
  facts.scan = short_name("bust.ply and 31 more");
  for (FileName& file : facts.files) file = file_name(std::string(70, 'a') + std::to_string(facts.file_count++));
  facts.print_id = RandomIds().next();
  facts.printer_hash = 7;
  facts.contract.plan.layers = 3;
  facts.contract.plan.exposure = std::chrono::milliseconds(2500);
  return facts;
}

class JobStoreTest : public ::testing::Test {
 protected:
  std::string state() const { return folder_ / "state"; }
  /// Stores a job whose first layer is cured.
  void store() {
    auto store = JobStore::open(state());
    ASSERT_TRUE(store) << store.error().message();
    auto file = store->begin(facts(), {small_rrep(), small_supports(), {}});
    ASSERT_TRUE(file) << file.error().message();
    auto journal = Journal::open(*file);
    ASSERT_TRUE(journal);
    JournalEntry entry;
    entry.next_layer = 1;
    ASSERT_TRUE(journal->append(entry));
  }
  Expected<JobStore::Interrupted> load() {
    arena_.release_bottom(0);
    auto store = JobStore::open(state());
    EXPECT_TRUE(store);
    return store->load(arena_);
  }

  TemporaryFolder folder_;
  alignas(Arena::kAlignment) std::array<std::byte, 4096> block_{};
  Arena arena_{block_};
};

TEST_F(JobStoreTest, LoadsAnInterruptedPrint) {
  store();
  auto job = load();
  ASSERT_TRUE(job) << job.error().message();
  EXPECT_EQ(view(job->job.facts.scan), "bust.ply and 31 more");
  EXPECT_EQ(job->job.facts.file_count, kMostScans);
  EXPECT_EQ(job->job.facts.files, facts().files);
  EXPECT_EQ(job->job.facts.printer_hash, 7U);
  EXPECT_EQ(job->job.facts.contract.plan.exposure, std::chrono::milliseconds(2500));
  EXPECT_EQ(job->job.parts.rrep.grid.layers, 3U);
  EXPECT_THAT(job->job.parts.rrep.first, ElementsAreArray(kFirst));
  EXPECT_THAT(job->job.parts.rrep.packed, ElementsAreArray(kPacked));
  EXPECT_THAT(job->job.parts.supports.list, ElementsAreArray(kSupports));
  EXPECT_EQ(job->job.parts.supports.pitch.x, small_supports().pitch.x);
  EXPECT_EQ(job->job.parts.supports.pitch.y, small_supports().pitch.y);
  const auto journal = Journal::open(job->journal);
  ASSERT_TRUE(journal) << journal.error().message();
  EXPECT_EQ(journal->job_hash(), job->job.hash);
  EXPECT_EQ(journal->last().next_layer, 1U);
  EXPECT_EQ(JobStore::open(state())->progress()->last.next_layer, 1U);
}

TEST_F(JobStoreTest, LoadsAllRaysOfItsPixels) {
  constexpr std::array<std::uint32_t, 4> kOtherFirst = {0, 1, 1, 2};
  constexpr std::array<std::uint32_t, 2> kOtherPacked = {9, 11};
  std::array<RRep, kRaysAround> others;
  others.fill(small_rrep());
  others[2].first = kOtherFirst;
  others[2].packed = kOtherPacked;
  RRep rrep = small_rrep();
  rrep.others = others.data();
  {
    auto store = JobStore::open(state());
    ASSERT_TRUE(store) << store.error().message();
    ASSERT_TRUE(store->begin(facts(), {rrep, small_supports(), {}}));
  }
  const auto job = load();
  ASSERT_TRUE(job) << job.error().message();
  const RRep& found = job->job.parts.rrep;
  EXPECT_THAT(found.packed, ElementsAreArray(kPacked));
  EXPECT_THAT(job->job.parts.supports.list, ElementsAreArray(kSupports));
  ASSERT_EQ(found.other_rays().size(), 4U);
  EXPECT_THAT(found.others[1].packed, ElementsAreArray(kPacked));
  EXPECT_THAT(found.others[2].first, ElementsAreArray(kOtherFirst));
  EXPECT_THAT(found.others[2].packed, ElementsAreArray(kOtherPacked));
  EXPECT_EQ(found.others[2].grid.ray_y, with_ray(rrep.grid, 3).ray_y);
}

TEST_F(JobStoreTest, IsEmptyWhenNewAndAfterThePrint) {
  {
    auto store = JobStore::open(state());
    ASSERT_TRUE(store);
    EXPECT_FALSE(store->has_job());
    EXPECT_EQ(store->load(arena_).error().code(), ErrorCode::kTruncated);
  }
  store();
  {
    auto store = JobStore::open(state());
    ASSERT_TRUE(store);
    EXPECT_TRUE(store->has_job());
    ASSERT_TRUE(store->end());
    EXPECT_FALSE(store->has_job());
  }
  EXPECT_EQ(load().error().code(), ErrorCode::kTruncated);
}

TEST_F(JobStoreTest, NoticesEveryDamagedByteOfAJob) {
  store();
  const std::string path = state() + "/job";
  const std::string whole = read_text(path);
  for (std::size_t byte = 0; byte < whole.size(); ++byte) {
    std::string damaged = whole;
    damaged[byte] = static_cast<char>(damaged[byte] ^ 0x10);
    write_text(path, damaged);
    EXPECT_FALSE(load()) << "byte " << byte << " went unnoticed";
  }
  for (std::size_t size = 0; size < whole.size(); size += 7) {
    write_text(path, std::string_view(whole).substr(0, size));
    EXPECT_FALSE(load()) << "cut at " << size;
  }
  std::filesystem::remove(path);
  EXPECT_EQ(load().error().code(), ErrorCode::kMalformed) << "a journal without its job";
}

TEST_F(JobStoreTest, RefusesLengthsThatNoPrinterHas) {
  for (const float pitch : {0.0F, -0.05F, 1e16F, std::numeric_limits<float>::quiet_NaN()}) {
    RRep rrep = small_rrep();
    rrep.grid.pitch_x_mm = pitch;
    const std::string path = folder_ / "job";
    const Descriptor file(::open(path.c_str(), O_RDWR | O_CREAT | O_TRUNC, 0600));
    std::uint64_t hash = 0;
    ASSERT_TRUE(write_job(file, facts(), {rrep, Supports{}, {}}, hash));
    ASSERT_EQ(::lseek(file.get(), 0, SEEK_SET), 0);
    arena_.release_bottom(0);
    const auto job = read_job(file, path.c_str(), arena_);
    ASSERT_FALSE(job) << pitch;
    EXPECT_EQ(job.error().code(), ErrorCode::kMalformed);
  }
}

TEST_F(JobStoreTest, ReplacesAnOlderPrint) {
  store();
  const auto first = load()->job.hash;
  store();
  const auto job = load();
  ASSERT_TRUE(job);
  EXPECT_NE(job->job.hash, first) << "no record of the older print belongs to this one";
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(state()), {}), 2) << "no files left over";
}

TEST_F(JobStoreTest, BelongsToOneProcessAtATime) {
  const auto first = JobStore::open(state());
  ASSERT_TRUE(first);
  const auto second = JobStore::open(state());
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().message(), HasSubstr("another plumbline"));
}

TEST_F(JobStoreTest, RefusesAJobLargerThanTheArena) {
  store();
  std::array<std::byte, 64> little{};
  Arena arena(little);
  auto store = JobStore::open(state());
  ASSERT_TRUE(store);
  EXPECT_EQ(store->load(arena).error().code(), ErrorCode::kOutOfMemory);
}

TEST(BoardHash, ChangesWithMasksAndHeightsAndNotWithComments) {
  const std::string path = PLUMBLINE_SOURCE_DIR "/board/sim2k.toml";
  auto text = read_settings_text(path, "").value();
  const auto hash = [](const std::string& toml) { return hash_of(parse_board_file(toml, "b").value()); };
  const auto one = hash(text);
  EXPECT_EQ(hash("# a comment\n" + text), one);
  for (const auto& [from, to] : {std::pair<std::string, std::string>{"columns = 1440", "columns = 1441"},
                                 {"mirror = \"x\"", "mirror = \"y\""},
                                 {"rotation_distance_mm = 4.0", "rotation_distance_mm = 8.0"},
                                 {"grey_levels = 256", "grey_levels = 2"},
                                 {"grey_gamma = 1.0", "grey_gamma = 2.2"},
                                 {"grey_gamma = 1.0", "lamp_map = [[1, 1.1]]"},
                                 {"end_stop_height_mm = 175.0", "end_stop_height_mm = 176.0"}}) {
    auto changed = text;
    changed.replace(changed.find(from), from.size(), to);
    EXPECT_NE(hash(changed), one) << to;
  }
}

}  // namespace
}  // namespace plumbline::firmware
