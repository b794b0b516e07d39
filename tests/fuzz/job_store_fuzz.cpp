/// A damaged store gives back the print that it was given, or says in words why it can't.

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "firmware/io/hash64.hpp"
#include "firmware/print/job/job_file.hpp"
#include "tests/fuzz/edits.hpp"
#include "tests/fuzz/require.hpp"

namespace plumbline::firmware::fuzz {
namespace {

constexpr std::uint32_t kFirst[] = {0, 2, 2, 5};
constexpr std::uint32_t kPacked[] = {1, 3, 1, 3, 7};
constexpr Strut kSupports[] = {
    {.column0 = 1, .row0 = 1, .column1 = 1, .row1 = 1, .first = 0, .end = 3, .radius0 = 500, .radius1 = 200},
    {.column0 = 3, .row0 = 0, .column1 = 3, .row1 = 1, .first = 1, .end = 2, .radius0 = 200, .radius1 = 200}};

/// A file in memory.
class MemoryFile {
 public:
  MemoryFile() : file_(::memfd_create("job", MFD_CLOEXEC)) { require(file_.is_open(), "memfd_create"); }
  const Descriptor& file() const { return file_; }
  void rewind() { require(::lseek(file_.get(), 0, SEEK_SET) == 0, "lseek"); }
  void fill(std::span<const std::byte> bytes) {
    require(::ftruncate(file_.get(), 0) == 0, "ftruncate");
    rewind();
    require(file_.write_all(bytes), "write");
    rewind();
  }
  std::vector<std::byte> content() {
    rewind();
    std::vector<std::byte> bytes(static_cast<std::size_t>(::lseek(file_.get(), 0, SEEK_END)));
    rewind();
    require(file_.read_all(bytes), "read");
    return bytes;
  }

 private:
  Descriptor file_;
};

const std::vector<std::byte>& whole() {
  static const std::vector<std::byte> made = [] {
    JobFacts facts;
    facts.scan = short_name("bust.ply");
    facts.print_id = 11;
    facts.contract.plan.layers = 3;
    const RRep rrep{.grid = {.columns = 4, .rows = 2, .layers = 3}, .first = kFirst, .packed = kPacked};
    const Supports supports{.list = kSupports, .pitch = PixelPitch(rrep.grid)};
    MemoryFile file;
    std::uint64_t hash = 0;
    require(write_job(file.file(), facts, {rrep, supports, {}}, hash), "write_job");
    return file.content();
  }();
  return made;
}

template <class T>
bool same(std::span<const T> a, std::span<const T> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

void check(const std::vector<std::byte>& bytes, bool forged) {
  static MemoryFile file;
  file.fill(bytes);
  alignas(Arena::kAlignment) static std::byte block[16384];
  Arena arena(block);
  const auto job = read_job(file.file(), "state/job", arena);
  if (!job) {
    require(
        std::strncmp(job.error().message(), "state/job: ", 11) == 0 || job.error().code() == ErrorCode::kOutOfMemory,
        "an error without the file's name");
    return;
  }
  require(arena.used() <= arena.capacity(), "more than the arena");
  require(job->parts.is_archive() ? job->parts.archive.size() == job->parts.rrep.grid.layers
                                  : job->parts.rrep.first.size() == job->parts.rrep.grid.layers + std::size_t{1},
          "layers");
  require(job->facts.file_count <= job->facts.files.size(), "more files than there is room for");
  if (forged) return;
  require(view(job->facts.scan) == "bust.ply" && job->facts.print_id == 11, "other facts than were stored");
  require(same<std::uint32_t>(job->parts.rrep.first, kFirst) && same<std::uint32_t>(job->parts.rrep.packed, kPacked),
          "another R-Rep than was stored");
  require(same<Strut>(job->parts.supports.list, kSupports), "other supports than were stored");
}

/// Makes the hash at the end right, so that the reader looks at the rest.
void forge(std::vector<std::byte>& bytes) {
  if (bytes.size() < sizeof(std::uint64_t)) return;
  Hash64 hash;
  hash.add(std::span(bytes).first(bytes.size() - sizeof(std::uint64_t)));
  const std::uint64_t value = hash.value();
  std::memcpy(bytes.data() + bytes.size() - sizeof value, &value, sizeof value);
}

}  // namespace
}  // namespace plumbline::firmware::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace plumbline::firmware::fuzz;
  const std::span all(bytes, size);
  if (all.empty()) return 0;
  Input input(all.subspan(1));
  std::vector<std::byte> job = whole();
  const bool forged = all[0] % 2 == 1;
  while (!input.empty()) damage(job, input);
  if (forged) forge(job);
  check(job, forged);
  return 0;
}
