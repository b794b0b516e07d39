#include "slicer/core/error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

namespace plumbline {
namespace {

using ::testing::StartsWith;

TEST(Error, FormatsItsMessage) {
  const Error error = Error::format(ErrorCode::kMalformed, "%s:%d: expected %s", "bust.ply", 12, "a number");
  EXPECT_EQ(error.code(), ErrorCode::kMalformed);
  EXPECT_STREQ(error.message(), "bust.ply:12: expected a number");
}

TEST(Error, CutsAMessageLongerThanItsCapacity) {
  const std::string all(1000, 'x');
  for (const std::size_t length :
       {Error::kCapacity - 2, Error::kCapacity - 1, Error::kCapacity, Error::kCapacity + 1}) {
    const Error error = Error::format(ErrorCode::kMalformed, "%s", all.substr(0, length).c_str());
    EXPECT_EQ(std::strlen(error.message()), std::min(length, Error::kCapacity - 1));
  }
}

TEST(Error, PutsAPrefixBeforeTheMessageAndCutsItsEnd) {
  const Error error = Error::format(ErrorCode::kTruncated, "%s", std::string(1000, 'x').c_str());
  const Error prefixed = error.with_prefix(std::string_view("bust.ply and more").substr(0, 8));
  EXPECT_EQ(prefixed.code(), ErrorCode::kTruncated);
  EXPECT_THAT(prefixed.message(), StartsWith("bust.ply: xxx"));
  EXPECT_EQ(std::strlen(prefixed.message()), Error::kCapacity - 1);
}

TEST(Error, KeepsItsAdviceApart) {
  const Error error = Error::format(ErrorCode::kDoesNotFit, "%s: %d mm too high.\tUse --scale %g", "a\tb.ply", 3, 0.5);
  EXPECT_STREQ(error.message(), "a\\x09b.ply: 3 mm too high. Use --scale 0.5");
  EXPECT_EQ(error.finding(), "a\\x09b.ply: 3 mm too high");
  EXPECT_EQ(error.advice(), "Use --scale 0.5");

  const Error prefixed = error.with_prefix("stick");
  EXPECT_EQ(prefixed.finding(), "stick: a\\x09b.ply: 3 mm too high");
  EXPECT_EQ(prefixed.advice(), "Use --scale 0.5");
}

TEST(Error, HasNoAdviceWithoutATabOrRoomForIt) {
  EXPECT_EQ(Error::format(ErrorCode::kTruncated, "cut: copy it again").advice(), "");
  const std::string found(1000, 'x');
  const Error cut = Error::format(ErrorCode::kTruncated, "%s:\tcopy it again", found.c_str());
  EXPECT_EQ(cut.advice(), "");
  EXPECT_EQ(cut.finding(), cut.message());
  const Error full = Error::format(ErrorCode::kTruncated, "%s:\tcopy", found.substr(0, 430).c_str());
  EXPECT_EQ(full.with_prefix("twenty characters or so").advice(), "");
}

TEST(Error, IsSmallAndItsCopiesSayTheSame) {
  EXPECT_LE(sizeof(Status), 32u);
  std::optional<Error> first =
      Error::format(ErrorCode::kNoPoints, "%s: has no points", "a.ply").tell(ToldCode::kFileEmpty);
  const Error copy = *first;
  Error assigned = Error::format(ErrorCode::kBusy, "busy");
  assigned = copy;
  first.reset();
  const Error moved = std::move(assigned);
  for (const Error* const error : {&copy, &moved}) {
    EXPECT_EQ(error->code(), ErrorCode::kNoPoints);
    EXPECT_STREQ(error->message(), "a.ply: has no points");
    EXPECT_EQ(error->told().code, ToldCode::kFileEmpty);
  }
}

TEST(Error, BeyondTheTableItsCodeIsLeft) {
  std::vector<Error> errors;
  for (std::size_t i = 0; i < Error::kRows; ++i)
    errors.push_back(Error::format(ErrorCode::kMalformed, "number %zu", i));
  EXPECT_STREQ(errors.back().message(), "number 63");
  const Error beyond = Error::format(ErrorCode::kTruncated, "a.ply: %s\tadvice", "is cut").tell(ToldCode::kFileEmpty);
  EXPECT_EQ(beyond.code(), ErrorCode::kTruncated);
  EXPECT_STREQ(beyond.message(), "Truncated");
  EXPECT_EQ(beyond.finding(), "Truncated");
  EXPECT_EQ(beyond.advice(), "");
  EXPECT_TRUE(beyond.told().empty());
  errors.clear();
  EXPECT_STREQ(Error::format(ErrorCode::kTruncated, "is cut").message(), "is cut");
}

TEST(Error, MayBeMadeByManyThreads) {
  std::vector<std::thread> threads;
  std::atomic<int> wrong = 0;
  for (int t = 0; t < 8; ++t) {
    threads.emplace_back([&wrong, t] {
      for (int i = 0; i < 2000; ++i) {
        const Error error = Error::format(ErrorCode::kMalformed, "%d of %d", i, t);
        const Error copy = error.with_prefix("a");
        if (std::string(copy.message()) != "a: " + std::to_string(i) + " of " + std::to_string(t)) ++wrong;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

TEST(Error, EveryCodeHasItsOwnName) {
  std::set<std::string_view> names;
  for (const ErrorCode code : {ErrorCode::kCannotOpen,    ErrorCode::kCannotRead,       ErrorCode::kCannotWrite,
                               ErrorCode::kUnknownFormat, ErrorCode::kMalformed,        ErrorCode::kTruncated,
                               ErrorCode::kNoPoints,      ErrorCode::kUnsupported,      ErrorCode::kOutOfMemory,
                               ErrorCode::kDoesNotFit,    ErrorCode::kBadSetting,       ErrorCode::kNoSurface,
                               ErrorCode::kCancelled,     ErrorCode::kPowerLost,        ErrorCode::kBusy,
                               ErrorCode::kDeviceTimeout, ErrorCode::kNoStick,          ErrorCode::kStickGone,
                               ErrorCode::kMountFailed,   ErrorCode::kMaskNotPresented, ErrorCode::kFlipTimeout,
                               ErrorCode::kPanelFailed,   ErrorCode::kExposureTooLong,  ErrorCode::kLampLit,
                               ErrorCode::kLampStuckOn,   ErrorCode::kLampDead,         ErrorCode::kLampFailed,
                               ErrorCode::kDoseOff,       ErrorCode::kOutsideTravel,    ErrorCode::kNotHomed,
                               ErrorCode::kStageMoving,   ErrorCode::kEndStopNotFound,  ErrorCode::kEndStopStuck,
                               ErrorCode::kStageStalled,  ErrorCode::kCoverOpen,        ErrorCode::kSensorDead}) {
    EXPECT_TRUE(names.insert(to_string(code)).second) << to_string(code);
    EXPECT_NE(to_string(code), "Unknown");
  }
  EXPECT_EQ(to_string(ErrorCode::kTruncated), "Truncated");
}

Status refuse_odd(int number) {
  if (number % 2 != 0) return fail(ErrorCode::kBadSetting, "%d is odd", number);
  return {};
}
Expected<int> half(int number) {
  PLUMBLINE_TRY(refuse_odd(number));
  return number / 2;
}

TEST(Error, TryReturnsOnlyErrors) {
  EXPECT_EQ(half(8).value(), 4);
  const auto refused = half(7);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code(), ErrorCode::kBadSetting);
  EXPECT_STREQ(refused.error().message(), "7 is odd");
}

}  // namespace
}  // namespace plumbline
