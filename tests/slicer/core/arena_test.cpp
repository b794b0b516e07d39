#include "slicer/core/arena.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

namespace plumbline {
namespace {

using ::testing::HasSubstr;

class ArenaTest : public ::testing::Test {
 protected:
  std::vector<std::byte> block_ = std::vector<std::byte>(64 * 1024 + Arena::kAlignment);
  Arena arena_{block_};
  template <class T>
  static std::size_t address(std::span<T> block) {
    return reinterpret_cast<std::size_t>(block.data());
  }
};

TEST_F(ArenaTest, StartsEmptyWithWholeCacheLines) {
  EXPECT_EQ(arena_.capacity() % Arena::kAlignment, 0U);
  EXPECT_GE(arena_.capacity(), 64U * 1024);
  EXPECT_EQ(arena_.used(), 0U);
  EXPECT_EQ(arena_.peak(), 0U);
  EXPECT_EQ(arena_.available(), arena_.capacity());
}

TEST_F(ArenaTest, TakesDisjointAlignedBlocksFromBothEnds) {
  struct Range {
    std::size_t low, high;
  };
  std::vector<Range> taken;
  const auto keep = [&](auto block) {
    ASSERT_TRUE(block.has_value());
    const std::size_t low = address(*block);
    const std::size_t high = low + block->size_bytes();
    EXPECT_EQ(low % Arena::kAlignment, 0U);
    EXPECT_GE(low, address(std::span(block_)));
    EXPECT_LE(high, address(std::span(block_)) + block_.size());
    for (const Range& other : taken) EXPECT_TRUE(high <= other.low || low >= other.high);
    taken.push_back({low, high});
  };
  for (std::size_t i = 0; i < 40; ++i) {
    keep(arena_.take_bottom<char>(1 + 37 * i, "a"));
    keep(arena_.take_top<double>(1 + 3 * i, "b"));
    keep(arena_.take_bottom<std::uint16_t>(i, "c"));
  }
}

TEST_F(ArenaTest, AcceptsABlockOfAnyAlignmentAndSize) {
  for (std::size_t skip = 0; skip < 70; ++skip) {
    for (const std::size_t size : {0U, 1U, 63U, 64U, 65U, 127U, 128U, 1000U}) {
      Arena arena{std::span<std::byte>(block_).subspan(skip, size)};
      EXPECT_LE(arena.capacity(), size);
      EXPECT_GE(arena.capacity() + 2 * Arena::kAlignment - 2, size);
      const auto all = arena.take_top<std::byte>(arena.capacity(), "all");
      ASSERT_TRUE(all.has_value());
      EXPECT_EQ(arena.available(), 0U);
      EXPECT_FALSE(arena.take_bottom<std::byte>(1, "more").has_value());
      if (arena.capacity() == 0) continue;
      EXPECT_EQ(address(*all) % Arena::kAlignment, 0U);
      EXPECT_GE(all->data(), block_.data() + skip);
      EXPECT_LE(all->data() + all->size(), block_.data() + skip + size);
    }
  }
}

TEST_F(ArenaTest, ReusesReleasedBlocks) {
  const std::size_t bottom = arena_.bottom_mark();
  const auto first = arena_.take_bottom<int>(100, "a");
  arena_.release_bottom(bottom);
  const auto second = arena_.take_bottom<int>(100, "b");
  EXPECT_EQ(first->data(), second->data());

  const std::size_t top = arena_.top_mark();
  const auto third = arena_.take_top<int>(100, "c");
  arena_.release_top(top);
  const auto fourth = arena_.take_top<int>(100, "d");
  EXPECT_EQ(third->data(), fourth->data());
}

TEST_F(ArenaTest, ScopesReleaseTheTopInOrderAndLeaveTheBottom) {
  ASSERT_TRUE(arena_.take_top<std::byte>(64, "outer").has_value());
  {
    const ArenaScope outer(arena_);
    ASSERT_TRUE(arena_.take_top<std::byte>(640, "middle").has_value());
    {
      const ArenaScope inner(arena_);
      ASSERT_TRUE(arena_.take_top<std::byte>(6400, "inner").has_value());
      ASSERT_TRUE(arena_.take_bottom<std::byte>(128, "stays").has_value());
      EXPECT_EQ(arena_.top_used(), 64U + 640 + 6400);
    }
    EXPECT_EQ(arena_.top_used(), 64U + 640);
  }
  EXPECT_EQ(arena_.top_used(), 64U);
  EXPECT_EQ(arena_.bottom_used(), 128U);
}

TEST_F(ArenaTest, RecordsThePeakSinceTheLastReset) {
  {
    const ArenaScope scope(arena_);
    ASSERT_TRUE(arena_.take_top<std::byte>(6400, "a").has_value());
    ASSERT_TRUE(arena_.take_bottom<std::byte>(640, "b").has_value());
  }
  EXPECT_EQ(arena_.used(), 640U);
  EXPECT_EQ(arena_.peak(), 7040U);
  arena_.reset_peak();
  EXPECT_EQ(arena_.peak(), 640U);
  EXPECT_FALSE(arena_.take_top<std::byte>(1 << 20, "too much").has_value());
  EXPECT_EQ(arena_.peak(), 640U) << "a refused block does not count";
}

TEST_F(ArenaTest, NamesStageNeedAndRestWhenItIsFull) {
  std::vector<std::byte> block(4 << 20);
  Arena arena(block);
  ASSERT_TRUE(arena.take_bottom<std::byte>(1 << 20, "first").has_value());
  const std::size_t before = arena.used();
  const auto refused = arena.take_top<double>(1 << 20, "ray search");
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code(), ErrorCode::kOutOfMemory);
  EXPECT_THAT(refused.error().message(), HasSubstr("ray search"));
  EXPECT_THAT(refused.error().message(), HasSubstr("needs 8.0 MiB"));
  EXPECT_THAT(refused.error().message(), HasSubstr("3.0 MiB"));
  EXPECT_EQ(arena.used(), before);
}

TEST_F(ArenaTest, RefusesACountWhoseBytesOverflow) {
  constexpr std::size_t kMost = std::numeric_limits<std::size_t>::max();
  for (const std::size_t count : {kMost, kMost - 1, kMost - 64, kMost / 8 + 1, kMost / 8, kMost / 4, kMost / 2 + 1}) {
    EXPECT_FALSE(arena_.take_top<std::uint64_t>(count, "overflow").has_value()) << count;
    EXPECT_FALSE(arena_.take_bottom<std::byte>(count, "overflow").has_value()) << count;
  }
  EXPECT_EQ(arena_.used(), 0U);
}

TEST_F(ArenaTest, TrimmingShrinksTheNewestBlock) {
  ASSERT_TRUE(arena_.take_bottom<std::byte>(128, "below").has_value());
  const auto block = arena_.take_bottom<std::byte>(arena_.available(), "all that is left");
  ASSERT_TRUE(block.has_value());
  arena_.trim_bottom(block->data(), 65);
  EXPECT_EQ(arena_.bottom_used(), 128U + 128);
  const auto next = arena_.take_bottom<std::byte>(1, "next");
  EXPECT_EQ(next->data(), block->data() + 128);
}

TEST_F(ArenaTest, TakingNoObjectsTakesNoBytes) {
  ASSERT_TRUE(arena_.take_top<int>(0, "none").has_value());
  ASSERT_TRUE(arena_.take_bottom<int>(0, "none").has_value());
  EXPECT_EQ(arena_.used(), 0U);
}

}  // namespace
}  // namespace plumbline
