#include "firmware/io/mask_hash.hpp"

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <set>
#include <vector>

namespace plumbline::firmware {
namespace {

struct Mask {
  Mask(std::uint32_t columns, std::uint32_t rows)
      : words(BitImage::words_needed(columns, rows), 0), image(words, columns, rows) {}
  std::vector<std::uint64_t> words;
  BitImage image;
};

Mask random_mask(std::uint32_t columns, std::uint32_t rows, unsigned seed) {
  Mask mask(columns, rows);
  std::mt19937 random(seed);
  for (std::uint32_t r = 0; r < rows; ++r) {
    for (std::uint32_t c = 0; c < columns; ++c) {
      if (random() % 3 == 0) mask.image.set(c, r);
    }
  }
  return mask;
}

std::uint64_t mix(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
  return z ^ (z >> 31);
}

/// The hash by its definition, computed from the bytes of the PNG rows.
std::uint64_t hash_by_definition(ConstBitImage mask) {
  std::uint64_t sum = mix((std::uint64_t{mask.columns()} << 32) + mask.rows());
  std::uint64_t s = 0;
  for (std::uint32_t r = 0; r < mask.rows(); ++r) {
    std::vector<unsigned char> bytes((mask.columns() + 63) / 64 * 8, 0);
    for (std::uint32_t c = 0; c < mask.columns(); ++c) {
      if (mask.at(c, r)) bytes[c / 8] |= static_cast<unsigned char>(0x80U >> (c % 8));
    }
    for (std::size_t i = 0; i < bytes.size(); i += 8) {
      ++s;
      std::uint64_t word = 0;
      for (std::size_t b = 0; b < 8; ++b) word = word << 8 | bytes[i + b];
      if (word != 0) sum += mix(word + s * 0x9E3779B97F4A7C15U);
    }
  }
  return mix(sum);
}

TEST(MaskHash, FollowsItsDefinitionForAnyWidth) {
  for (const std::uint32_t columns : {1U, 7U, 63U, 64U, 65U, 403U}) {
    const Mask mask = random_mask(columns, 5, columns);
    EXPECT_EQ(mask_hash(mask.image), hash_by_definition(mask.image)) << columns;
  }
}

TEST(MaskHash, IsTheSameInEveryVersion) {
  // Manifests outlive versions. The expected values were computed from the definition in a language with big integers.
  Mask mask(10, 2);
  mask.image.set(0, 0);
  mask.image.set(9, 1);
  EXPECT_EQ(mask_hash(mask.image), 0x1c003cdfe0e8e72fU);
  EXPECT_EQ(job_hash(std::array<std::uint64_t, 2>{0x1c003cdfe0e8e72fU, 0}), 0x923831b8e7be15faU);
}

TEST(MaskHash, DependsOnEveryPixelItsPlaceAndTheSize) {
  std::set<std::uint64_t> hashes = {mask_hash(Mask(100, 30).image), mask_hash(Mask(30, 100).image)};
  for (std::uint32_t r = 0; r < 30; ++r) {
    for (std::uint32_t c = 0; c < 100; ++c) {
      Mask mask(100, 30);
      mask.image.set(c, r);
      hashes.insert(mask_hash(mask.image));
    }
  }
  EXPECT_EQ(hashes.size(), 2U + 100 * 30);
}

TEST(MaskHash, DependsOnEveryGreyPixelAndItsLevel) {
  const Mask mask = random_mask(100, 30, 1);
  std::set<std::uint64_t> hashes = {mask_hash(mask.image)};
  std::size_t different = 1;
  for (std::uint32_t pixel = 0; pixel < 3000; pixel += 7) {
    for (const GreyRun& run : {GreyRun{pixel, 1, 1}, GreyRun{pixel, 2, 1}, GreyRun{pixel, 1, 254}}) {
      hashes.insert(mask_hash(mask.image, std::span(&run, 1)));
      ++different;
    }
  }
  EXPECT_EQ(hashes.size(), different);
  // By the definition.
  Mask dot(10, 2);
  dot.image.set(0, 0);
  const GreyRun run{5, 3, 200};
  const std::uint64_t inner = mix((10ULL << 32) + 2) + mix((1ULL << 63) + 0x9E3779B97F4A7C15U);
  EXPECT_EQ(mask_hash(dot.image), mix(inner));
  EXPECT_EQ(mask_hash(dot.image, std::span(&run, 1)), mix(inner + mix(mix((5ULL << 32) + (3ULL << 16) + 200))));
}

TEST(JobHash, DependsOnTheOrderAndTheNumberOfLayers) {
  const std::array<std::uint64_t, 3> layers = {1, 2, 3};
  const std::array<std::uint64_t, 3> swapped = {2, 1, 3};
  const std::array<std::uint64_t, 4> longer = {1, 2, 3, 0};
  EXPECT_NE(job_hash(layers), job_hash(swapped));
  EXPECT_NE(job_hash(layers), job_hash(longer));
  EXPECT_EQ(job_hash({}), mix(0));
}

}  // namespace
}  // namespace plumbline::firmware
