/// The masks of an archive while the printer asks whether to print it: real children, asked as clients ask.

#include "firmware/daemon/offered_archive.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>

#include <memory>
#include <thread>

#include "firmware/archive/zip_writer.hpp"
#include "firmware/child/archive_task.hpp"
#include "firmware/pictures/png.hpp"
#include "firmware/settings/board_file.hpp"
#include "tests/firmware/child/child_fixture.hpp"

namespace plumbline::firmware {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

constexpr std::uint32_t kLayers = 5;

/// Layer k has a white stripe of 10 (k + 1) rows.
void draw_stripe(std::uint32_t layer, BitImage mask) {
  mask.clear();
  for (std::uint32_t row = 0; row < 10 * (layer + 1); ++row) mask.row(100 + row)[1] = ~std::uint64_t{0};
}

/// Beside it, of each row of 403 pixels: 20 of a grey that is too weak to cure alone.
constexpr std::uint8_t kStripesLevel = 100;

/// Says at some layers that it is another one or has any number of greys, or never ends.
void unreliable_task(SharedMemory& memory, std::uint32_t threads) {
  const ArchiveRequest& request = memory.page().request.archive;
  const bool one = request.ask == ArchiveRequest::Ask::kLayer;
  if (one && request.layer.number % 5 == 1) {
    for (;;) std::this_thread::sleep_for(1s);
  }
  if (one && request.layer.number % 5 == 2) ::abort();
  run_archive_task(memory, threads);
  if (one && request.layer.number % 5 == 3)
    memory.arena()[static_cast<std::size_t>(request.mask_at) + 100] ^= std::byte{4};
  if (one && request.layer.number % 5 == 0) memory.page().answer.greys = ~std::uint64_t{0};
}

class OfferedArchiveTest : public ChildTest {
 protected:
  explicit OfferedArchiveTest(ChildTask task = run_archive_task) : child_(make(1, task)) {
    const std::string path = folder_ / "part.sl1";
    write_archive(path);
    ScanRequest request = request_of(path, 1);
    request.archive.ask = ArchiveRequest::Ask::kCheck;
    request.archive.shows_grey = true;
    EXPECT_EQ(run(child_, request, path), 0);
    sliced_ = check_archive_answer(child_.answer(), request, arena_).value();
    file_ = Descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  }

  void write_archive(const std::string& path) const {
    auto zip = ZipWriter::create(path).value();
    const PrinterVolume printer = small_printer();
    std::vector<std::uint64_t> words(BitImage::words_needed(printer.columns, printer.rows));
    const BitImage mask(words, printer.columns, printer.rows);
    std::vector<std::uint8_t> levels(picture_bytes(printer.columns, printer.rows, 1));
    auto encoder = PictureEncoder::create(levels.size()).value();
    for (std::uint32_t k = 0; k < kLayers; ++k) {
      draw_stripe(k, mask);
      for (std::uint32_t row = 0; row < printer.rows; ++row) {
        for (std::uint32_t column = 0; column < printer.columns; ++column) {
          const bool grey = mask.row(row)[1] != 0 && column >= 128 && column < 148;
          levels[row * printer.columns + column] = mask.at(column, row) ? 255 : grey ? kStripesLevel : 0;
        }
      }
      EXPECT_TRUE(zip.add(("part" + std::to_string(100 + k) + ".png").c_str(),
                          encoder.encode(levels, printer.columns, printer.rows, 1), ZipWriter::Packing::kStore));
    }
    EXPECT_TRUE(zip.finish());
  }

  std::unique_ptr<OfferedArchiveMasks> offer() {
    auto made = OfferedArchiveMasks::create(file_.get(), "part.sl1", sliced_, decoder_, true, arena_);
    EXPECT_TRUE(made) << made.error().message();
    return std::move(*made);
  }
  /// Asks until there is an answer. @returns "" or the error
  std::string ask(OfferedMasks& masks, std::uint32_t layer) {
    for (int turn = 0; turn < 3000; ++turn) {
      const auto drawn = masks.draw(layer, {}, *picture_);
      if (!drawn) return drawn.error().message();
      if (*drawn) return "";
      std::this_thread::sleep_for(10ms);
    }
    return "no answer";
  }
  bool shows(std::uint32_t layer) const {
    const PrinterVolume printer = small_printer();
    std::vector<std::uint64_t> words(BitImage::words_needed(printer.columns, printer.rows));
    const BitImage mask(words, printer.columns, printer.rows);
    draw_stripe(layer, mask);
    std::vector<GreyRun> greys;
    for (std::uint32_t row = 0; row < printer.rows; ++row) {
      if (mask.row(row)[1] != 0) greys.push_back({row * printer.columns + 128, 20, kStripesLevel});
    }
    const auto expected = std::make_unique<MaskPicture>();
    draw_mask_window(mask, greys, {}, {}, *expected);
    return std::ranges::equal(expected->bytes(), picture_->bytes());
  }

  SlicingChild child_;
  Arena arena_{child_.arena_block()};
  ChildLayerDecoder decoder_{child_, small_printer()};
  SlicedArchive sliced_;
  Descriptor file_;
  std::unique_ptr<MaskPicture> picture_ = std::make_unique<MaskPicture>();
};

TEST_F(OfferedArchiveTest, ShowsAnyLayerInAnyOrder) {
  const std::size_t used = arena_.used();
  {
    const auto masks = offer();
    EXPECT_FALSE(masks->draw(0, {}, *picture_).value()) << "nobody waits for the child";
    for (const std::uint32_t layer : {3U, 0U, 4U, 4U, 1U}) {
      ASSERT_EQ(ask(*masks, layer), "");
      EXPECT_TRUE(shows(layer)) << layer;
    }
    EXPECT_THAT(ask(*masks, kLayers), HasSubstr("there is no layer 5: the last one is 4"));
  }
  EXPECT_EQ(arena_.used(), used);
}

TEST_F(OfferedArchiveTest, GivesEachOfTwoClientsItsLayer) {
  const auto masks = offer();
  bool first = false, second = false;
  for (int turn = 0; turn < 3000 && !(first && second); ++turn) {
    if (!first && masks->draw(1, {}, *picture_).value()) first = shows(1);
    if (!second && masks->draw(2, {}, *picture_).value()) second = shows(2);
    std::this_thread::sleep_for(1ms);
  }
  EXPECT_TRUE(first && second);
}

TEST_F(OfferedArchiveTest, CanBeEndedWhileAChildWorks) {
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(offer()->draw(0, {}, *picture_).value());
  const auto masks = offer();
  EXPECT_EQ(ask(*masks, 2), "") << "no child is left";
}

TEST_F(OfferedArchiveTest, DecodesGreyAsItsChildHasCheckedIt) {
  EXPECT_EQ(sliced_.grey, (GreyShare{84 * 150, 20 * 150, 20 * 150}));
  auto masks =
      ArchiveMasks::create(file_.get(), "part.sl1", sliced_.grid, sliced_.layers, sliced_.turn, decoder_, true, arena_);
  ASSERT_TRUE(masks) << masks.error().message();
  for (const std::uint32_t layer : {0U, 3U}) {
    const auto mask = masks->mask(layer);
    ASSERT_TRUE(mask) << mask.error().message();
    EXPECT_EQ(mask->count(), 64U * 10 * (layer + 1));
    ASSERT_EQ(masks->greys().size(), 10 * (layer + 1));
    for (std::uint32_t row = 0; row < masks->greys().size(); ++row) {
      EXPECT_EQ(masks->greys()[row], (GreyRun{(100 + row) * sliced_.grid.columns + 128, 20, kStripesLevel}));
    }
  }
  auto black_or_white = ArchiveMasks::create(file_.get(), "part.sl1", sliced_.grid, sliced_.layers, sliced_.turn,
                                             decoder_, false, arena_);
  ASSERT_TRUE(black_or_white);
  EXPECT_FALSE(black_or_white->mask(0)) << "it was checked for a panel with grey";
}

class BadChildren : public OfferedArchiveTest {
 protected:
  BadChildren() : OfferedArchiveTest(unreliable_task) {}
};

TEST_F(BadChildren, AreErrorsOfTheirLayersOnly) {
  const auto masks = offer();
  EXPECT_EQ(ask(*masks, 4), "");
  EXPECT_THAT(ask(*masks, 2), HasSubstr("decoding it failed"));
  EXPECT_THAT(ask(*masks, 3), HasSubstr("layer 4 is not as it was when the print was checked"));
  EXPECT_THAT(ask(*masks, 0), HasSubstr("does not add up (number of grey pixels)"));
  EXPECT_EQ(ask(*masks, 4), "");
  EXPECT_TRUE(shows(4));
  EXPECT_FALSE(masks->draw(1, {}, *picture_).value());
  EXPECT_FALSE(masks->draw(4, {}, *picture_).value()) << "it waits for the child that hangs";
}

}  // namespace
}  // namespace plumbline::firmware
