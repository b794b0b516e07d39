#include "firmware/print/job/job_file.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <limits>
#include <type_traits>

#include "firmware/io/hash64.hpp"
#include "slicer/core/words/printable_text.hpp"

namespace plumbline::firmware {
namespace {

/// Change the version whenever the stored data change, JobFacts, Contract and PrintPlan included.
constexpr std::uint32_t kJobMagic = 0x424F4A50;  // "PJOB"
constexpr std::uint32_t kJobFileVersion = 13;

struct JobHeader {
  std::uint32_t magic = kJobMagic;
  std::uint32_t version = kJobFileVersion;
  std::uint64_t facts_bytes = sizeof(JobFacts);
  std::uint64_t crossings = 0;
  std::uint64_t supports = 0;
  std::uint64_t is_exact = 0;                                   ///< RRep::is_exact
  std::uint64_t archive = 0;                                    ///< layers of it; 0: there is none
  std::uint64_t rays = 1;                                       ///< of each pixel
  std::array<std::uint64_t, kRaysAround> other_crossings = {};  ///< of RRep::others
  PrintGrid grid;
};
static_assert(std::is_trivially_copyable_v<JobFacts> && std::is_trivially_copyable_v<JobHeader>);
static_assert(std::is_trivially_copyable_v<Strut> && std::is_trivially_copyable_v<ArchiveLayer>);

template <std::size_t Size>
std::array<char, Size> filled(std::string_view text) {
  std::array<char, Size> name = {};
  std::copy_n(text.begin(), std::min(text.size(), name.size()), name.begin());
  return name;
}

template <class T>
std::span<const std::byte> bytes_of(const T& value) {
  return std::as_bytes(std::span(&value, 1));
}

template <class T>
std::span<std::byte> writable_bytes_of(T& value) {
  return std::as_writable_bytes(std::span(&value, 1));
}

tl::unexpected<Error> damaged_job(const char* path, const char* how) {
  return fail(ErrorCode::kMalformed, "%s: the stored job is %s and can't be resumed", path, how);
}

/// The error after read_all() has failed.
tl::unexpected<Error> cannot_read_job(const char* path) {
  if (errno == 0) return damaged_job(path, "cut off");
  return fail(ErrorCode::kCannotRead, "%s: %s", path, std::strerror(errno));
}

Status check(const JobHeader& header, const char* path) {
  if (header.magic != kJobMagic) return damaged_job(path, "damaged");
  if (header.version != kJobFileVersion || header.facts_bytes != sizeof(JobFacts)) {
    return fail(ErrorCode::kUnsupported,
                "%s: the job was stored by another version of plumbline; only that one can resume it", path);
  }
  // The arena refuses sizes that exceed it; this refuses those that overflow a 32-bit size_t.
  constexpr std::uint64_t kMost = std::numeric_limits<std::size_t>::max() / sizeof(Strut);
  const bool sizes = header.crossings <= kMost && header.supports <= kMost &&
                     std::ranges::max(header.other_crossings) <= kMost &&
                     (header.archive == 0 || header.archive == header.grid.layers) &&
                     (header.rays == 1 || (header.rays == (1 + kRaysAround) && header.archive == 0));
  const bool layers = header.grid.layers > 0 && header.grid.layers <= PrintGrid::kMaxLayers;
  // A board file has .005 to 1 mm.
  const auto is_fine = [](float mm) { return mm >= 0.001F && mm <= 10; };
  const bool lengths =
      is_fine(header.grid.pitch_x_mm) && is_fine(header.grid.pitch_y_mm) && is_fine(header.grid.layer_height_mm);
  return sizes && layers && lengths ? Status() : Status(damaged_job(path, "damaged"));
}

/// All parts of the file but its header and facts.
std::array<std::span<const std::byte>, 4 + 2 * kRaysAround> bytes_of_parts(const MaskParts& parts) {
  std::array<std::span<const std::byte>, 4 + 2 * kRaysAround> bytes = {
      std::as_bytes(parts.rrep.first), std::as_bytes(parts.rrep.packed), std::as_bytes(parts.supports.list),
      std::as_bytes(parts.archive)};
  std::size_t at = 4;
  for (const RRep& other : parts.rrep.other_rays()) {
    bytes[at++] = std::as_bytes(other.first);
    bytes[at++] = std::as_bytes(other.packed);
  }
  return bytes;
}

Expected<std::span<RRep>> read_other_rays(const Descriptor& file, const char* path, const JobHeader& header,
                                          Arena& arena) {
  const auto others = arena.take_bottom<RRep>(header.other_crossings.size(), "r-rep");
  PLUMBLINE_TRY(others);
  for (std::uint32_t i = 0; i < others->size(); ++i) {
    const auto first = arena.take_bottom<std::uint32_t>(std::size_t{header.grid.layers} + 1, "r-rep");
    PLUMBLINE_TRY(first);
    const auto packed = arena.take_bottom<std::uint32_t>(static_cast<std::size_t>(header.other_crossings[i]), "r-rep");
    PLUMBLINE_TRY(packed);
    for (const auto part : {std::as_writable_bytes(*first), std::as_writable_bytes(*packed)}) {
      if (!file.read_all(part)) return cannot_read_job(path);
    }
    (*others)[i] = {
        .grid = with_ray(header.grid, i + 1), .first = *first, .packed = *packed, .is_exact = header.is_exact != 0};
  }
  return *others;
}

}  // namespace

ShortName short_name(std::string_view text) { return filled<std::tuple_size_v<ShortName>>(text); }
FileName file_name(std::string_view text) { return filled<std::tuple_size_v<FileName>>(text); }
std::string_view view(std::span<const char> name) {
  return {name.data(), static_cast<std::size_t>(std::find(name.begin(), name.end(), '\0') - name.begin())};
}

void JobFacts::add_file(std::string_view name) { files[file_count++] = file_name(PrintableText(name, 79).view()); }

std::uint64_t hash_of(const BoardFile& board) {
  Hash64 hash;
  const auto number = [&hash](double value) { hash.add_value(std::bit_cast<std::uint64_t>(value)); };
  hash.add_text(board.name);
  number(board.columns);
  number(board.rows);
  number(board.pixel_pitch_x_mm);
  number(board.pixel_pitch_y_mm);
  number(board.travel_mm);
  if (board.machine) {
    const MachineFile& m = *board.machine;
    for (const double value : {static_cast<double>(m.panel.rgb), static_cast<double>(m.panel.mirror),
                               static_cast<double>(m.panel.rotation_deg), m.rotation_distance_mm,
                               static_cast<double>(m.full_steps_per_rotation), static_cast<double>(m.microsteps),
                               m.end_stop_height_mm, m.power_mw_cm2}) {
      number(value);
    }
    if (m.panel.grey.has_levels()) {
      number(m.panel.grey.levels);
      number(m.panel.grey.gamma);
    }
    if (m.panel.grey.exposures > 0) number(m.panel.grey.exposures);
    if (m.panel.lamp.known()) number(m.panel.lamp.columns);
    for (const double light : m.panel.lamp.all()) number(light);
  }
  return hash.value();
}

bool write_job(const Descriptor& file, const JobFacts& facts, const MaskParts& parts, std::uint64_t& hash) {
  JobHeader header;
  header.crossings = parts.rrep.crossings();
  header.supports = parts.supports.list.size();
  header.is_exact = parts.rrep.is_exact ? 1 : 0;
  header.archive = parts.archive.size();
  header.rays = 1 + parts.rrep.other_rays().size();
  std::ranges::transform(parts.rrep.other_rays(), header.other_crossings.begin(), &RRep::crossings);
  header.grid = parts.rrep.grid;
  Hash64 all;
  const auto write = [&](std::span<const std::byte> part) {
    all.add(part);
    return file.write_all(part);
  };
  if (!write(bytes_of(header)) || !write(bytes_of(facts))) return false;
  for (const auto part : bytes_of_parts(parts)) {
    if (!write(part)) return false;
  }
  hash = all.value();
  return file.write_all(bytes_of(hash));
}

Expected<StoredJob> read_job(const Descriptor& file, const char* path, Arena& arena) {
  JobHeader header;
  if (!file.read_all(writable_bytes_of(header))) return cannot_read_job(path);
  PLUMBLINE_TRY(check(header, path));
  StoredJob job;
  if (!file.read_all(writable_bytes_of(job.facts))) return cannot_read_job(path);
  if (job.facts.file_count > job.facts.files.size()) return damaged_job(path, "damaged");
  const std::size_t ends = header.archive > 0 ? 0 : std::size_t{header.grid.layers} + 1;
  const auto first = arena.take_bottom<std::uint32_t>(ends, "r-rep");
  PLUMBLINE_TRY(first);
  const auto packed = arena.take_bottom<std::uint32_t>(static_cast<std::size_t>(header.crossings), "r-rep");
  PLUMBLINE_TRY(packed);
  const auto supports = arena.take_bottom<Strut>(static_cast<std::size_t>(header.supports), "supports");
  PLUMBLINE_TRY(supports);
  const auto archive = arena.take_bottom<ArchiveLayer>(static_cast<std::size_t>(header.archive), "layers");
  PLUMBLINE_TRY(archive);
  for (const auto part : {std::as_writable_bytes(*first), std::as_writable_bytes(*packed),
                          std::as_writable_bytes(*supports), std::as_writable_bytes(*archive)}) {
    if (!file.read_all(part)) return cannot_read_job(path);
  }
  job.parts.rrep = {.grid = header.grid, .first = *first, .packed = *packed, .is_exact = header.is_exact != 0};
  if (header.rays > 1) {
    const auto others = read_other_rays(file, path, header, arena);
    PLUMBLINE_TRY(others);
    job.parts.rrep.others = others->data();
  }
  if (!file.read_all(writable_bytes_of(job.hash))) return cannot_read_job(path);
  job.parts.supports = {.list = *supports, .pitch = PixelPitch(header.grid)};
  job.parts.archive = *archive;
  Hash64 hash;
  hash.add(bytes_of(header));
  hash.add(bytes_of(job.facts));
  for (const auto part : bytes_of_parts(job.parts)) hash.add(part);
  if (hash.value() != job.hash) return damaged_job(path, "damaged");
  return job;
}

}  // namespace plumbline::firmware
