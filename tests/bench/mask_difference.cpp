// mask_difference FOLDER_A FOLDER_B [N]: counts the pixels in which two stacks of PNG masks differ; in every Nth layer only.
//
// A pixel of 128 or more cures. B may be mirrored: of the four ways, the one that fits up to 15 layers between bottom and top best is
// taken, and told.
// The layers of a stack are its PNG files in the order of their names; one that is missing counts as black.
// Prints "pixels P  cured C  differ D  of which more than a pixel from an edge of A: F  mirrored x y".

#include <lodepng.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

struct Mask {
  unsigned columns = 0, rows = 0;
  std::vector<unsigned char> grey;

  bool cures(unsigned x, unsigned y) const { return grey[std::size_t{y} * columns + x] >= 128; }
  bool near_edge(unsigned x, unsigned y) const {
    const bool here = cures(x, y);
    for (unsigned v = std::max(y, 1U) - 1; v <= std::min(y + 1, rows - 1); ++v) {
      for (unsigned u = std::max(x, 1U) - 1; u <= std::min(x + 1, columns - 1); ++u) {
        if (cures(u, v) != here) return true;
      }
    }
    return false;
  }
};

std::vector<std::string> layers_of(const char* folder) {
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".png") files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

Mask load(const std::string& file) {
  Mask mask;
  if (lodepng::decode(mask.grey, mask.columns, mask.rows, file, LCT_GREY, 8) != 0) {
    std::fprintf(stderr, "%s: is no PNG file\n", file.c_str());
    std::exit(2);
  }
  return mask;
}

struct Difference {
  unsigned long long pixels = 0, cured = 0, differ = 0, far = 0;
};

void add(const Mask& a, const Mask& b, bool flip_x, bool flip_y, Difference& sum) {
  if (a.columns != b.columns || a.rows != b.rows) {
    std::fprintf(stderr, "%u x %u pixels and %u x %u pixels\n", a.columns, a.rows, b.columns, b.rows);
    std::exit(2);
  }
  for (unsigned y = 0; y < a.rows; ++y) {
    for (unsigned x = 0; x < a.columns; ++x) {
      const bool ours = a.cures(x, y);
      sum.cured += ours ? 1 : 0;
      if (ours == b.cures(flip_x ? b.columns - 1 - x : x, flip_y ? b.rows - 1 - y : y)) continue;
      ++sum.differ;
      sum.far += a.near_edge(x, y) ? 0 : 1;
    }
  }
  sum.pixels += std::size_t{a.columns} * a.rows;
}

}  // namespace

int main(int argc, char** argv) {
  const int every = argc == 4 ? std::atoi(argv[3]) : 1;
  if ((argc != 3 && argc != 4) || every < 1) {
    std::fprintf(stderr, "usage: mask_difference FOLDER_A FOLDER_B [N]\n");
    return 2;
  }
  const auto a = layers_of(argv[1]);
  const auto b = layers_of(argv[2]);
  const std::size_t both = std::min(a.size(), b.size());
  if (both == 0) {
    std::fprintf(stderr, "no PNG files\n");
    return 2;
  }
  std::array<Difference, 4> tried;
  // Many objects are symmetric in a few of their layers.
  for (std::size_t sixteenth = 1; sixteenth < 16; ++sixteenth) {
    const std::size_t k = both * sixteenth / 16;
    const Mask ours = load(a[k]);
    const Mask theirs = load(b[k]);
    for (unsigned way = 0; way < 4; ++way) add(ours, theirs, (way & 1U) != 0, (way & 2U) != 0, tried[way]);
  }
  const auto best = static_cast<unsigned>(
      std::min_element(tried.begin(), tried.end(), [](const auto& p, const auto& q) { return p.differ < q.differ; }) -
      tried.begin());
  Difference sum;
  for (std::size_t k = 0; k < std::max(a.size(), b.size()); k += static_cast<std::size_t>(every)) {
    Mask ours = load(k < a.size() ? a[k] : b[k]);
    Mask theirs = load(k < b.size() ? b[k] : a[k]);
    if (k >= a.size()) std::fill(ours.grey.begin(), ours.grey.end(), static_cast<unsigned char>(0));
    if (k >= b.size()) std::fill(theirs.grey.begin(), theirs.grey.end(), static_cast<unsigned char>(0));
    add(ours, theirs, (best & 1U) != 0, (best & 2U) != 0, sum);
  }
  std::printf("layers %zu %zu  pixels %llu  cured %llu  differ %llu  far %llu  mirrored %u %u\n", a.size(), b.size(),
              sum.pixels, sum.cured, sum.differ, sum.far, best & 1U, best >> 1U);
}
