/// Opens any bytes as an archive of a sliced print, lists its layers, decodes the first ones and draws the small picture of it.

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <vector>

#include "firmware/archive/layer_archive.hpp"
#include "firmware/io/descriptor.hpp"
#include "firmware/print/archive_glance.hpp"
#include "tests/fuzz/require.hpp"

namespace plumbline::fuzz {
namespace {

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
  for (std::size_t k = 0; k < std::min<std::size_t>(layers.size(), 4); ++k) {
    const bool first = archive->read(layers[k], mask).has_value();
    const std::vector<std::uint64_t> before = words;
    const bool again = read_archive_layer(file.get(), "part.sl1", layers[k], archive->turn(), mask).has_value();
    require(first == again && (!first || before == words), "two decodings differ");
    for (std::uint32_t r = 0; first && r < mask.rows(); ++r) {
      require((mask.row(r).back() & ~mask.last_word_mask()) == 0, "a pixel outside the mask");
    }
  }
}

}  // namespace
}  // namespace plumbline::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  plumbline::fuzz::check({bytes, size});
  return 0;
}
