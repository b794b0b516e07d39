#include "firmware/archive/zip_reader.hpp"

#include <fcntl.h>
#include <minizip/unzip.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <limits>
#include <utility>

#include "firmware/archive/zip_calls.hpp"

namespace plumbline::firmware::inline archive {

Expected<ZipReader> ZipReader::open(int file, std::string_view name) {
  return open(ZipHandle{.file = file, .memory = {}}, name);
}

Expected<ZipReader> ZipReader::open(std::span<const std::byte> file, std::string_view name) {
  return open(ZipHandle{.file = -1, .memory = file}, name);
}

Expected<ZipReader> ZipReader::open(const ZipHandle& handle, std::string_view name) {
  ZipReader reader;
  reader.name_ = name;
  reader.handle_ = std::make_unique<ZipHandle>(handle);
  zlib_filefunc64_def calls = zip_calls(*reader.handle_);
  reader.zip_ = ::unzOpen2_64("", &calls);
  if (reader.zip_ == nullptr) return reader.broken(UNZ_BADZIPFILE);
  unz_global_info64 facts = {};
  if (const int code = ::unzGetGlobalInfo64(reader.zip_, &facts); code != UNZ_OK) return reader.broken(code);
  if (facts.number_entry > kMostEntries) return reader.too_many();
  return reader;
}

ZipReader::ZipReader(ZipReader&& other) noexcept
    : name_(std::move(other.name_)), handle_(std::move(other.handle_)), zip_(std::exchange(other.zip_, nullptr)) {}

ZipReader::~ZipReader() {
  if (zip_ == nullptr) return;
  ::unzCloseCurrentFile(zip_);
  ::unzClose(zip_);
}

tl::unexpected<Error> ZipReader::broken(int code) const {
  if (handle_->reason != 0) {
    return fail(ErrorCode::kCannotRead, "%s: %s", name_.c_str(), std::strerror(handle_->reason));
  }
  if (code == UNZ_INTERNALERROR) return fail(ErrorCode::kOutOfMemory, "%s: no memory to unpack it", name_.c_str());
  return fail(ErrorCode::kMalformed, "%s: is not a zip archive, or is damaged.\tCopy or export it again",
              name_.c_str());
}

tl::unexpected<Error> ZipReader::too_many() const {
  return fail(ErrorCode::kUnsupported, "%s: holds more than the %llu files that are allowed.\tPack only the print",
              name_.c_str(), static_cast<unsigned long long>(kMostEntries));
}

Status ZipReader::for_each(FunctionRef<Status(std::string_view, const ZipPlace&)> visit) {
  int code = ::unzGoToFirstFile(zip_);
  unz64_file_pos next = {};
  while (code == UNZ_OK) {
    std::array<char, 256> name = {};
    unz_file_info64 facts = {};
    unz64_file_pos place = {};
    code = ::unzGetCurrentFileInfo64(zip_, &facts, name.data(), name.size() - 1, nullptr, 0, nullptr, 0);
    if (code == UNZ_OK) code = ::unzGetFilePos64(zip_, &place);
    if (code != UNZ_OK) return broken(code);
    constexpr std::uint64_t kRecord = 46;  // the directory's entry, without its texts
    next.pos_in_zip_directory =
        place.pos_in_zip_directory + kRecord + facts.size_filename + facts.size_file_extra + facts.size_file_comment;
    next.num_of_file = place.num_of_file + 1;
    // Where its end claims 65,535 entries, minizip takes whatever follows for another.
    if (place.num_of_file >= kMostEntries) return too_many();
    PLUMBLINE_TRY(visit(name.data(), ZipPlace{place.pos_in_zip_directory, place.num_of_file}));
    code = ::unzGoToNextFile(zip_);
  }
  if (code != UNZ_END_OF_LIST_OF_FILE) return broken(code);
  // minizip counts to what the end claims. A print would end at the layer that follows.
  if (next.num_of_file == 0 || ::unzGoToFilePos64(zip_, &next) != UNZ_OK) return {};
  return fail(ErrorCode::kMalformed,
              "%s: holds more files than the %llu that its end declares.\tCopy or export it again", name_.c_str(),
              static_cast<unsigned long long>(next.num_of_file));
}

Status ZipReader::open_entry(const ZipPlace& place) {
  ::unzCloseCurrentFile(zip_);
  const unz64_file_pos at = {place.at, place.entry};
  unz_file_info64 facts = {};
  int code = ::unzGoToFilePos64(zip_, &at);
  if (code == UNZ_OK) code = ::unzGetCurrentFileInfo64(zip_, &facts, nullptr, 0, nullptr, 0, nullptr, 0);
  if (code != UNZ_OK) return broken(code);
  constexpr uLong kEncrypted = 1;
  if ((facts.flag & kEncrypted) != 0 || (facts.compression_method != 0 && facts.compression_method != Z_DEFLATED)) {
    return fail(ErrorCode::kUnsupported, "%s: is %s.\tPack it as a plain zip archive", name_.c_str(),
                (facts.flag & kEncrypted) != 0 ? "encrypted" : "packed in a way that plumbline does not read");
  }
  code = ::unzOpenCurrentFile(zip_);
  return code == UNZ_OK ? Status() : Status(broken(code));
}

Expected<std::size_t> ZipReader::read(std::span<std::byte> buffer) {
  const auto most = static_cast<unsigned>(std::min<std::size_t>(buffer.size(), std::numeric_limits<int>::max()));
  const int got = ::unzReadCurrentFile(zip_, buffer.data(), most);
  if (got < 0 || handle_->reason != 0) return broken(got);
  if (got > 0) return static_cast<std::size_t>(got);
  const int code = ::unzCloseCurrentFile(zip_);
  if (code != UNZ_OK) return broken(code);  // its checksum
  return std::size_t{0};
}

}  // namespace plumbline::firmware::inline archive
