/// Opens any bytes as an archive of a sliced print, lists its layers, decodes the first ones and draws the small picture of it.
///
/// Bytes that don't begin like an archive ("P") say what stands in one, since hardly any change of a byte would leave the checksums of
/// the archive and of its PNGs right: see archive_of().

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/archive/layer_archive.hpp"
#include "firmware/child/answer_check.hpp"
#include "firmware/io/descriptor.hpp"
#include "firmware/print/job/archive_glance.hpp"
#include "tests/fuzz/edits.hpp"
#include "tests/fuzz/require.hpp"
#include "tests/slicer/support/deflated.hpp"
#include "tests/slicer/support/threemf_file.hpp"

namespace plumbline::firmware::fuzz {
namespace {

using testing::deflated;

/// `count` bytes of the input, or what is left of them.
std::string text_of(Input& input, std::size_t count) {
  std::string text;
  for (; count > 0 && !input.empty(); --count) text.push_back(static_cast<char>(input.take<std::uint8_t>()));
  return text;
}

std::string big_endian(std::uint32_t number) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<char>(number >> shift));
  return bytes;
}

/// @param content  a name of four letters and the data
std::string chunk_of(const std::string& content) {
  const auto sum = crc32(0, reinterpret_cast<const Bytef*>(content.data()), static_cast<uInt>(content.size()));
  return big_endian(static_cast<std::uint32_t>(content.size() - 4)) + content +
         big_endian(static_cast<std::uint32_t>(sum));
}

/// A PNG with right checksums: its sides, what IHDR says, a chunk of its own, and rows that are packed, or bytes for packed ones.
std::string png_of(Input& input) {
  const std::uint32_t columns = input.take<std::uint8_t>();
  const std::uint32_t rows = input.take<std::uint8_t>();
  std::string png = "\x89PNG\r\n\x1a\n" + chunk_of("IHDR" + big_endian(columns) + big_endian(rows) + text_of(input, 5));
  const auto how = input.take<std::uint8_t>();
  if ((how & 1U) != 0) png += chunk_of((text_of(input, 4) + "tEXt").substr(0, 4) + text_of(input, how / 4U));
  std::string lines = text_of(input, input.take<std::uint16_t>());
  if ((how & 2U) == 0) lines = deflated(lines, 15);
  return png + chunk_of("IDAT" + lines.substr(0, lines.size() / 2)) +
         chunk_of("IDAT" + lines.substr(lines.size() / 2)) + chunk_of("IEND");
}

/// An archive with right checksums: up to 8 entries, each a text of settings, a layer or a thumbnail.
std::string archive_of(Input input) {
  std::vector<testing::ZipPart> parts;
  while (!input.empty() && parts.size() < 8) {
    const auto kind = input.take<std::uint8_t>();
    testing::ZipPart part;
    part.deflated = (kind & 64U) != 0;
    part.sizes_follow = (kind & 128U) != 0;
    switch (kind % 8) {
      case 0: part.name = "config.ini"; break;
      case 1: part.name = "prusaslicer.ini"; break;
      case 2: part.name = "thumbnail/thumbnail400x400.png"; break;
      default: part.name = "layer" + std::to_string(kind % 8) + ".png";
    }
    part.content = kind % 8 < 2 ? text_of(input, input.take<std::uint8_t>()) : png_of(input);
    parts.push_back(part);
  }
  return testing::zip_of(parts);
}

constexpr std::uint32_t kMostSide = 256;  ///< larger panels cost time and find nothing else

/// The same picture must come from the file and from memory.
void look(int file, std::span<const std::byte> bytes) {
  static std::vector<std::byte> block(std::size_t{4} << 20U);
  static ScanPicture pictures[2];
  PrinterVolume printer;
  printer.pitch_x_mm = printer.pitch_y_mm = 0.05F;
  bool drawn[2] = {};
  for (const int i : {0, 1}) {
    auto archive = i == 0 ? LayerArchive::open(file, "part.sl1") : LayerArchive::open(bytes, "part.sl1");
    if (archive && archive->columns() <= kMostSide && archive->rows() <= kMostSide) {
      Arena arena(block);
      drawn[i] = draw_archive_picture(*archive, printer, arena, pictures[i]).has_value();
    }
  }
  require(drawn[0] == drawn[1], "a picture from the file or from memory only");
  require(!drawn[0] || pictures[0].memory == pictures[1].memory, "two pictures");
}

void check(std::span<const std::uint8_t> bytes) {
  static const Descriptor file(::memfd_create("archive", MFD_CLOEXEC));
  require(::ftruncate(file.get(), 0) == 0 && ::lseek(file.get(), 0, SEEK_SET) == 0, "no file");
  require(file.write_all(std::as_bytes(bytes)), "no room");
  auto archive = LayerArchive::open(file.get(), "part.sl1");
  look(file.get(), std::as_bytes(bytes));
  if (!archive) return;
  require(archive->layers() > 0 && archive->columns() > 0 && archive->rows() > 0, "an archive without layers");
  std::vector<ArchiveLayer> layers(archive->layers());
  if (!archive->list(layers)) return;
  if (archive->columns() > kMostSide || archive->rows() > kMostSide) return;
  std::vector<std::uint64_t> words(BitImage::words_needed(archive->columns(), archive->rows()));
  const BitImage mask(words, archive->columns(), archive->rows());
  std::vector<GreyRun> room(GreyRuns::runs_needed(mask.columns(), mask.rows()));
  GreyRuns greys(room, mask.columns());
  for (std::size_t k = 0; k < std::min<std::size_t>(layers.size(), 4); ++k) {
    const bool first = archive->read(layers[k], mask).has_value();
    const std::vector<std::uint64_t> before = words;
    const bool again = read_archive_layer(file.get(), "part.sl1", layers[k], archive->turn(), mask, &greys).has_value();
    require(first == again && (!first || before == words), "two decodings differ");
    for (std::uint32_t r = 0; first && r < mask.rows(); ++r) {
      require((mask.row(r).back() & ~mask.last_word_mask()) == 0, "a pixel outside the mask");
    }
    std::vector<GreyRun> checked(room.size());
    GreyRuns taken(checked, mask.columns());
    require(!again || take_checked_greys(greys.runs(), greys.runs().size(), mask.columns(), mask.rows(), taken),
            "grey pixels that can't be");
  }
}

}  // namespace
}  // namespace plumbline::firmware::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace plumbline::firmware::fuzz;
  if (size == 0 || bytes[0] == 'P') {
    check({bytes, size});
    return 0;
  }
  const std::string made = archive_of(Input({bytes, size}));
  check({reinterpret_cast<const std::uint8_t*>(made.data()), made.size()});
  return 0;
}
