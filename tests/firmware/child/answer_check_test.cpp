/// Damaged answers: refused, or harmless.

#include "firmware/child/answer_check.hpp"

#include <gmock/gmock.h>

#include <cstring>
#include <functional>
#include <limits>
#include <random>

#include "firmware/archive/zip_writer.hpp"
#include "firmware/child/archive_task.hpp"
#include "firmware/pictures/png.hpp"
#include "slicer/supports/drawing/grey_masks.hpp"
#include "slicer/supports/drawing/mask_stream.hpp"
#include "tests/firmware/child/child_fixture.hpp"

namespace plumbline::firmware {
namespace {

using ::testing::HasSubstr;

/// A real child's answer, and the memory it left.
class AnswerCheck : public ChildTest {
 protected:
  explicit AnswerCheck(Grey grey = Grey::kOff) : child_(make(1)) {
    const std::string path = folder_ / "ball.ply";
    write_sphere_scan(path, 4000, 6);  // hangs over, so it needs supports
    request_ = request_of(path, 1, true);
    request_.settings.grey = grey;
    EXPECT_EQ(run(child_, request_, path), 0);
    good_ = child_.answer();
    const auto used = child_.arena_block().first(static_cast<std::size_t>(good_.bottom_used));
    memory_.assign(used.begin(), used.end());
  }

  /// Checks an answer over the child's memory, damaged by `damage`, and draws all its masks if it passes.
  Status check(const ScanAnswer& answer, const std::function<void(std::span<std::byte>)>& damage = {}) const {
    std::copy(memory_.begin(), memory_.end(), child_.arena_block().begin());
    if (damage) damage(child_.arena_block().first(memory_.size()));
    Arena arena(child_.arena_block());
    const auto checked = check_answer(answer, request_, arena);
    PLUMBLINE_TRY(checked);
    const RRep& rrep = checked->sliced.rrep;
    EXPECT_EQ(rrep.other_rays().size() + 1, rays_for(request_.settings.grey));
    auto stream = MaskStream::create(rrep, checked->sliced.supports, arena);
    PLUMBLINE_TRY(stream);
    auto grey = GreyMasks::create(rrep, checked->sliced.supports, {}, 0.05, arena);
    PLUMBLINE_TRY(grey);
    for (std::uint32_t layer = 0; layer < stream->grid().layers; ++layer) {
      static_cast<void>(grey->find(layer, *stream, stream->mask(layer)));
    }
    return {};
  }
  void refuses(const char* words, const std::function<void(ScanAnswer&)>& change) const {
    ScanAnswer answer = good_;
    change(answer);
    const auto checked = check(answer);
    ASSERT_FALSE(checked) << words;
    EXPECT_EQ(checked.error().code(), ErrorCode::kMalformed);
    EXPECT_THAT(checked.error().message(), HasSubstr(words));
  }
  template <class T>
  static T* at(std::span<std::byte> memory, std::uint64_t place) {
    return reinterpret_cast<T*>(memory.data() + place);
  }

  SlicingChild child_;
  ScanRequest request_;
  ScanAnswer good_;
  std::vector<std::byte> memory_;
};

TEST_F(AnswerCheck, TakesWhatARealChildHandsBack) {
  ASSERT_EQ(good_.kind, ScanAnswer::kSliced);
  ASSERT_GT(good_.supports, 0U);
  EXPECT_TRUE(check(good_));
}

TEST_F(AnswerCheck, RefusesEveryNumberThatDoesNotAddUp) {
  refuses("no answer", [](ScanAnswer& a) { a.kind = 0; });
  refuses("layers", [](ScanAnswer& a) { a.layers = 0; });
  refuses("layers", [](ScanAnswer& a) { a.layers = 501; });
  refuses("memory", [](ScanAnswer& a) { a.bottom_used = kArenaBytes + 1; });
  refuses("memory", [](ScanAnswer& a) { a.bottom_used = ~std::uint64_t{0}; });
  refuses("places", [](ScanAnswer& a) { a.bottom_used = 0; });
  refuses("places", [](ScanAnswer& a) { a.first_at += 2; });
  refuses("places", [](ScanAnswer& a) { a.first_at = ~std::uint64_t{3}; });
  refuses("places", [](ScanAnswer& a) { a.packed_at = a.bottom_used; });
  refuses("places", [](ScanAnswer& a) { a.crossings = (std::uint64_t{1} << 62U) + a.crossings; });
  refuses("crossings", [](ScanAnswer& a) { --a.crossings; });
  refuses("crossings", [](ScanAnswer& a) { --a.layers; });
  refuses("number of supports", [](ScanAnswer& a) { a.supports = 70'000; });
  refuses("place of the supports", [](ScanAnswer& a) { a.supports_at = a.bottom_used - 2; });
  refuses("findings", [](ScanAnswer& a) { a.findings.voxels = ~std::uint64_t{0}; });
  refuses("findings", [](ScanAnswer& a) { a.findings.first_layer_pixels = 403 * 300 + 1; });
  refuses("findings", [](ScanAnswer& a) { a.findings.peel_layer = a.layers; });
  refuses("findings", [](ScanAnswer& a) { a.findings.groups[0].kept_count = IssueGroup::kKept + 1; });
  refuses("findings", [](ScanAnswer& a) {
    a.findings.groups[0].count = a.findings.groups[0].kept_count + 1;
    ++a.findings.groups[0].kept_count;
    a.findings.groups[0].kept[0].layer = a.layers;
  });
  refuses("remarks", [](ScanAnswer& a) { a.remarks = ScanAnswer::kMostRemarks + 1; });
  request_.settings.supports.reset();
  refuses("number of supports", [](ScanAnswer&) {});
}

class FullGreyAnswerCheck : public AnswerCheck {
 protected:
  FullGreyAnswerCheck() : AnswerCheck(Grey::kFull) {}
};

TEST_F(FullGreyAnswerCheck, RefusesRaysThatDoNotAddUp) {
  ASSERT_EQ(good_.kind, ScanAnswer::kSliced);
  EXPECT_TRUE(check(good_));
  for (std::size_t i = 0; i < good_.other_rays.size(); ++i) {
    refuses("places", [i](ScanAnswer& a) { a.other_rays[i].first_at += 2; });
    refuses("places", [i](ScanAnswer& a) { a.other_rays[i].packed_at = ~std::uint64_t{3}; });
    refuses("crossings", [i](ScanAnswer& a) { --a.other_rays[i].crossings; });
    refuses("crossings", [i](ScanAnswer& a) { a.other_rays[i].first_at = a.other_rays[i].packed_at; });
  }
  const CrossingPacking packing({.columns = 403, .rows = 300});
  EXPECT_FALSE(check(good_, [&](auto memory) {
    at<std::uint32_t>(memory, good_.other_rays[2].packed_at)[0] = packing.packed(403 * 300);
  }));
}

TEST_F(AnswerCheck, RefusesCrossingsAndSupportsOutsideTheGrid) {
  const std::uint64_t last = good_.crossings - 1;
  const CrossingPacking packing({.columns = 403, .rows = 300});
  const std::vector<std::function<void(std::span<std::byte>)>> damages = {
      [&](auto memory) { at<std::uint32_t>(memory, good_.packed_at)[last] = packing.packed(403 * 300); },
      [&](auto memory) { at<std::uint32_t>(memory, good_.packed_at)[0] = packing.packed(403 * 300 - 1); },
      [&](auto memory) { at<std::uint32_t>(memory, good_.first_at)[0] = 1; },
      [&](auto memory) { at<std::uint32_t>(memory, good_.first_at)[good_.layers / 2] = ~0U; },
      [&](auto memory) { at<std::uint32_t>(memory, good_.first_at)[good_.layers] = ~0U; },
      [&](auto memory) { at<Strut>(memory, good_.supports_at)->column0 = 403; },
      [&](auto memory) { at<Strut>(memory, good_.supports_at)->column1 = 403; },
      [&](auto memory) { at<Strut>(memory, good_.supports_at)->row0 = 300; },
      [&](auto memory) { at<Strut>(memory, good_.supports_at)->row1 = 300; },
      [&](auto memory) { at<Strut>(memory, good_.supports_at)->end = 65535; },
      [&](auto memory) { at<Strut>(memory, good_.supports_at)->first = 65535; },
      [&](auto memory) { at<Strut>(memory, good_.supports_at)->kind = static_cast<StrutKind>(kStrutKinds); },
      [&](auto memory) { at<Strut>(memory, good_.supports_at)->lies = 2; },
      [&](auto memory) {  // the drawing takes them in the order of their first layers
        auto* const struts = at<Strut>(memory, good_.supports_at);
        ASSERT_LT(struts[0].first, struts[good_.supports - 1].first);
        std::swap(struts[0], struts[good_.supports - 1]);
      },
  };
  for (std::size_t i = 0; i < damages.size(); ++i) EXPECT_FALSE(check(good_, damages[i])) << i;
}

TEST_F(AnswerCheck, RefusesAPixelThatIsCrossedTwiceInALayer) {
  const auto with_second = [&](std::int64_t behind_first) {
    return check(good_, [&](auto memory) {
      const auto* const first = at<std::uint32_t>(memory, good_.first_at);
      auto* const packed = at<std::uint32_t>(memory, good_.packed_at);
      const auto layer =
          std::find_if(first, first + good_.layers, [](const std::uint32_t& one) { return (&one)[1] >= one + 2; });
      ASSERT_NE(layer, first + good_.layers);
      const CrossingPacking packing({.columns = 403, .rows = 300});
      packed[*layer] = packing.packed(1, 10);
      packed[*layer + 1] = packing.packed(static_cast<std::uint32_t>(1 + behind_first), 20);
    });
  };
  EXPECT_TRUE(with_second(1));
  EXPECT_FALSE(with_second(0)) << "an even number of crossings would turn the ray inside out";
  EXPECT_FALSE(with_second(-1));
}

TEST_F(AnswerCheck, RefusesAnIssueOneBesideTheGridOnAnySide) {
  const auto with = [&](const std::function<void(Issue&)>& change) {
    ScanAnswer answer = good_;
    for (IssueGroup& group : answer.findings.groups) group = {};
    IssueGroup& group = answer.findings.groups[0];
    group.count = group.kept_count = 1;
    group.pixels = group.voxels = 4;
    Issue& issue = group.kept[0];
    issue = {.kind = static_cast<IssueKind>(0), .pixels = 4, .voxels = 4};
    issue.column = 402;
    issue.row = 299;
    issue.layer = issue.first_layer = issue.last_layer = answer.layers - 1;
    change(issue);
    return check(answer).has_value();
  };
  EXPECT_TRUE(with([](Issue&) {})) << "in the last corner";
  EXPECT_FALSE(with([](Issue& issue) { issue.column = 403; }));
  EXPECT_FALSE(with([](Issue& issue) { issue.row = 300; }));
  EXPECT_FALSE(with([&](Issue& issue) { issue.last_layer = good_.layers; }));
  EXPECT_FALSE(with([&](Issue& issue) { issue.first_layer = good_.layers; }));
  EXPECT_FALSE(with([](Issue& issue) { issue.pixels = 5; }));
  EXPECT_FALSE(with([](Issue& issue) { issue.kind = static_cast<IssueKind>(1); }));
  EXPECT_FALSE(with([](Issue& issue) { issue.held_n = -1; }));
}

TEST_F(AnswerCheck, SurvivesScribblesOverAnswerAndMemory) {
  std::mt19937 random(25);
  const auto scribble = [&random](std::span<std::byte> bytes) {
    const auto times = 1 + random() % 8;
    for (std::size_t i = 0; i < times; ++i) bytes[random() % bytes.size()] = static_cast<std::byte>(random());
  };
  int refused = 0;
  constexpr int kTimes = 3000;
  for (int i = 0; i < kTimes; ++i) {
    ScanAnswer answer = good_;
    // The texts fill most of the answer, so aim at the numbers half of the time.
    if (i % 2 == 0) {
      std::array<std::byte, offsetof(ScanAnswer, remarks) - offsetof(ScanAnswer, bottom_used)> numbers{};
      auto* const place = reinterpret_cast<std::byte*>(&answer.bottom_used);
      std::memcpy(numbers.data(), place, numbers.size());
      scribble(numbers);
      std::memcpy(place, numbers.data(), numbers.size());
    } else {
      scribble(std::as_writable_bytes(std::span(&answer, 1)));
    }
    if (!check(answer, i % 3 == 0 ? scribble : std::function<void(std::span<std::byte>)>())) ++refused;
  }
  EXPECT_GT(refused, kTimes / 4);
}

TEST_F(AnswerCheck, RefusesProposalsThatAreNoNumbers) {
  ScanAnswer answer;
  answer.kind = ScanAnswer::kProposals;
  EXPECT_TRUE(check_proposals(answer));
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::function<void(Proposal&)>> damages = {
      [](Proposal& way) { way.degrees[0] = kNan; },   [](Proposal& way) { way.degrees[1] = 361; },
      [](Proposal& way) { way.support_mm3 = -1; },    [](Proposal& way) { way.height_mm = kNan; },
      [](Proposal& way) { way.peel_mm2 = HUGE_VAL; },
  };
  for (const auto& damage : damages) {
    ScanAnswer damaged = answer;
    damage(damaged.proposals.back());
    EXPECT_EQ(check_proposals(damaged).error().code(), ErrorCode::kMalformed);
  }
  answer.kind = ScanAnswer::kSliced;
  EXPECT_EQ(check_proposals(answer).error().code(), ErrorCode::kMalformed);
}

TEST_F(AnswerCheck, BelievesNoErrorThatAScanCanNotCause) {
  ScanAnswer answer;
  answer.kind = ScanAnswer::kRefused;
  const auto error_of = [&](ErrorCode code, std::string_view text, std::uint32_t advice_at = 0) {
    answer.code = static_cast<std::uint32_t>(code);
    answer.message = {};
    text.copy(answer.message.data(), answer.message.size());
    answer.advice_at = advice_at;
    return check(answer).error();
  };
  EXPECT_EQ(error_of(ErrorCode::kTruncated, "cut off").code(), ErrorCode::kTruncated);
  for (const auto code : {ErrorCode::kLampStuckOn, ErrorCode::kPowerLost, ErrorCode::kStickGone, ErrorCode::kCancelled,
                          ErrorCode{0}, ErrorCode{9999}}) {
    EXPECT_EQ(error_of(code, "believe me").code(), ErrorCode::kMalformed);
  }
  const auto forged = error_of(ErrorCode::kMalformed, "a\nplumblined: PL-301, lamp stuck on\x1b[2J");
  EXPECT_STREQ(forged.message(), "a\\x0aplumblined: PL-301, lamp stuck on\\x1b[2J");
  EXPECT_EQ(error_of(ErrorCode::kMalformed, "bad %s%n%s: do this", 12).advice(), "do this");
  EXPECT_EQ(error_of(ErrorCode::kMalformed, "short", 4'000'000'000U).advice(), "");
  EXPECT_EQ(std::strlen(error_of(ErrorCode::kMalformed, std::string(Error::kCapacity, 'x')).message()),
            Error::kCapacity - 1);
  EXPECT_EQ(error_of(ErrorCode::kMalformed, "").code(), ErrorCode::kMalformed);
}

TEST(GreyAnswerCheck, TakesRunsThatLieInTheImageInOrder) {
  constexpr std::uint32_t kColumns = 50, kRows = 10;
  std::vector<GreyRun> room(8);
  GreyRuns greys(room, kColumns);
  const std::vector<GreyRun> good = {{0, 50, 1}, {50, 3, 254}, {53, 1, 7}, {499, 1, 100}};
  ASSERT_TRUE(take_checked_greys(good, good.size(), kColumns, kRows, greys));
  EXPECT_TRUE(std::ranges::equal(greys.runs(), good));
  ASSERT_TRUE(take_checked_greys(good, 2, kColumns, kRows, greys));
  EXPECT_EQ(greys.runs().size(), 2U);
  ASSERT_TRUE(take_checked_greys({}, 0, kColumns, kRows, greys));
  EXPECT_TRUE(greys.empty());

  const auto refuses = [&](const char* words, std::vector<GreyRun> runs, std::uint64_t count) {
    const auto taken = take_checked_greys(runs, count, kColumns, kRows, greys);
    ASSERT_FALSE(taken) << words;
    EXPECT_EQ(taken.error().code(), ErrorCode::kMalformed);
    EXPECT_THAT(taken.error().message(), HasSubstr(std::string("(") + words + ")"));
  };
  refuses("number of grey pixels", good, 5);
  refuses("number of grey pixels", good, ~std::uint64_t{0});
  for (const GreyRun& bad : {GreyRun{0, 0, 9}, GreyRun{0, 51, 9}, GreyRun{40, 11, 9}, GreyRun{500, 1, 9},
                             GreyRun{0xFFFFFFFF, 1, 9}, GreyRun{7, 1, 0}, GreyRun{7, 1, 255}}) {
    refuses("grey pixels", {bad}, 1);
  }
  refuses("grey pixels", {{10, 5, 9}, {14, 1, 9}}, 2);
  refuses("grey pixels", {{10, 5, 9}, {2, 1, 9}}, 2);
}

/// A real child's answer about an archive, and the memory it left.
class ArchiveAnswerCheck : public ChildTest {
 protected:
  static constexpr std::uint32_t kLayers = 12;

  ArchiveAnswerCheck() : child_(make(1, run_archive_task)) {
    const std::string path = folder_ / "part.sl1";
    write_archive(path);
    request_ = request_of(path, 1);
    request_.archive.ask = ArchiveRequest::Ask::kCheck;
    EXPECT_EQ(run(child_, request_, path), 0);
    good_ = child_.answer();
  }

  static void write_archive(const std::string& path) {
    auto zip = ZipWriter::create(path).value();
    const auto add = [&](const std::string& name, std::span<const std::byte> bytes) {
      EXPECT_TRUE(zip.add(name.c_str(), bytes, ZipWriter::Packing::kStore));
    };
    constexpr std::string_view kConfig = "layerHeight = 0.1\nexpTime = 2\nexpTimeFirst = 20\nnumFade = 3\n";
    add("config.ini", std::as_bytes(std::span(kConfig)));
    const PrinterVolume printer = small_printer();
    std::vector<std::uint64_t> words(BitImage::words_needed(printer.columns, printer.rows));
    BitImage mask(words, printer.columns, printer.rows);
    mask.clear();
    for (std::uint32_t row = 100; row < 150; ++row) mask.row(row)[1] = ~std::uint64_t{0};
    auto encoder = PngEncoder::for_masks(printer.columns, printer.rows).value();
    const auto png = encoder.encode(mask);
    for (std::uint32_t k = 0; k < kLayers; ++k) add("part" + std::to_string(100 + k) + ".png", png);
    EXPECT_TRUE(zip.finish());
  }

  Expected<SlicedArchive> check(const ScanAnswer& answer) const {
    Arena arena(child_.arena_block());
    return check_archive_answer(answer, request_, arena);
  }
  void refuses(const char* words, const std::function<void(ScanAnswer&)>& change) const {
    ScanAnswer answer = good_;
    change(answer);
    const auto checked = check(answer);
    ASSERT_FALSE(checked) << words;
    EXPECT_EQ(checked.error().code(), ErrorCode::kMalformed);
    EXPECT_THAT(checked.error().message(), HasSubstr(std::string("(") + words + ")"));
  }

  SlicingChild child_;
  ScanRequest request_;
  ScanAnswer good_;
};

TEST_F(ArchiveAnswerCheck, TakesWhatARealChildHandsBack) {
  ASSERT_EQ(good_.kind, ScanAnswer::kArchive) << good_.message.data();
  const auto checked = check(good_);
  ASSERT_TRUE(checked) << checked.error().message();
  EXPECT_EQ(checked->grid.layers, kLayers);
  EXPECT_EQ(checked->layers.size(), kLayers);
  EXPECT_FLOAT_EQ(checked->grid.layer_height_mm, 0.1F);
  EXPECT_EQ(checked->settings.value(PrintKey::kExposureTime), 2);
  EXPECT_EQ(checked->settings.value(PrintKey::kInitialExposureTime), 20);
  EXPECT_EQ(checked->settings.value(PrintKey::kFadedLayers), 3);
  EXPECT_EQ(checked->extent.left, 64U);
  EXPECT_EQ(checked->extent.right, 128U);
  EXPECT_EQ(checked->extent.bottom - checked->extent.top, 50U);
  EXPECT_EQ(checked->findings.voxels, 64U * 50 * kLayers);
  EXPECT_EQ(checked->grey, (GreyShare{64U * 50 * kLayers, 0, 0}));
  EXPECT_FALSE(checked->turned);
}

TEST_F(ArchiveAnswerCheck, RefusesEveryNumberThatDoesNotAddUp) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  refuses("no answer", [](ScanAnswer& a) { a.kind = 0; });
  refuses("no answer", [](ScanAnswer& a) { a.kind = ScanAnswer::kSliced; });
  refuses("its error", [](ScanAnswer& a) { a.kind = ScanAnswer::kRefused; });
  for (const double height : {0.0, 0.004, 1.1, -0.1, kNan}) {
    refuses("layer height", [&](ScanAnswer& a) { a.layer_height_mm = height; });
  }
  refuses("layers", [](ScanAnswer& a) { a.layers = 0; });
  refuses("layers", [](ScanAnswer& a) { a.layers = 501; });
  refuses("memory", [](ScanAnswer& a) { a.bottom_used = kArenaBytes + 1; });
  refuses("memory", [](ScanAnswer& a) { a.bottom_used = ~std::uint64_t{0}; });
  refuses("places", [](ScanAnswer& a) { a.bottom_used = 0; });
  refuses("places", [](ScanAnswer& a) { a.archive_at += 4; });
  refuses("places", [](ScanAnswer& a) { a.archive_at = ~std::uint64_t{7}; });
  refuses("places", [](ScanAnswer& a) { a.layers = 500; });
  refuses("findings", [](ScanAnswer& a) { --a.layers; });
  refuses("findings", [](ScanAnswer& a) { a.findings.voxels = ~std::uint64_t{0}; });
  refuses("findings", [](ScanAnswer& a) { a.findings.peel_layer = a.layers; });
  refuses("grey", [](ScanAnswer& a) { a.grey[0] = ~std::uint64_t{0}; });
  refuses("grey", [](ScanAnswer& a) { a.grey[1] = a.grey[0] + 1; });
  refuses("grey", [](ScanAnswer& a) { a.grey[2] = 1; });
  refuses("extent", [](ScanAnswer& a) { a.extent[1] = 404; });
  refuses("extent", [](ScanAnswer& a) { a.extent[3] = 301; });
  refuses("extent", [](ScanAnswer& a) { a.extent[2] = a.extent[3]; });
  for (const PrintField& field : kPrintFields) {
    for (const double value : {field.low - 0.001, field.high * 1.01, -1.0, kNan}) {
      refuses(field.name.data(), [&](ScanAnswer& a) {
        a.values.has[index_of(field.key)] = 1;
        a.values.value[index_of(field.key)] = value;
      });
    }
  }
}

TEST_F(ArchiveAnswerCheck, HandsOnTheErrorsOfArchivesOnly) {
  ScanAnswer answer;
  answer.kind = ScanAnswer::kRefused;
  answer.message = {"part.sl1: broken"};
  answer.code = static_cast<std::uint32_t>(ErrorCode::kTruncated);
  const auto broken = check(answer);
  ASSERT_FALSE(broken);
  EXPECT_EQ(broken.error().code(), ErrorCode::kTruncated);
  EXPECT_STREQ(broken.error().message(), "part.sl1: broken");
  answer.code = static_cast<std::uint32_t>(ErrorCode::kExposureTooLong);
  const auto lamp = check(answer);
  ASSERT_FALSE(lamp);
  EXPECT_THAT(lamp.error().message(), HasSubstr("(its error)"));
}

TEST_F(ArchiveAnswerCheck, NumbersThatAreNotGivenAreLeftToTheProfile) {
  ScanAnswer answer = good_;
  answer.values.has = {};
  const auto checked = check(answer);
  ASSERT_TRUE(checked) << checked.error().message();
  EXPECT_EQ(checked->settings.values, PrintValues());
}

}  // namespace
}  // namespace plumbline::firmware
