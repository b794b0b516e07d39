#include "firmware/archive/zip_writer.hpp"

#include <fcntl.h>
#include <minizip/zip.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "firmware/archive/zip_calls.hpp"

namespace plumbline::firmware::inline archive {

Expected<ZipWriter> ZipWriter::create(const std::string& path) {
  ZipWriter writer;
  writer.path_.add("%s", path.c_str());
  struct stat status = {};
  if (::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode)) {
    return fail(ErrorCode::kCannotOpen, "%s: exists and is not a file.\tChoose another name", path.c_str());
  }
  writer.handle_ = std::make_unique<ZipHandle>();
  constexpr mode_t kMode = 0666;  // less the user's umask
  writer.file_ =
      Descriptor(::open(writer.new_path().c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, kMode));
  if (!writer.file_.is_open()) {
    const int reason = errno;
    writer.named_ = true;  // there is nothing to remove
    return fail(ErrorCode::kCannotOpen, "%s: cannot be created: %s.\tCheck the folder, or choose another one",
                path.c_str(), std::strerror(reason));
  }
  writer.handle_->file = writer.file_.get();
  zlib_filefunc64_def calls = zip_calls(*writer.handle_);
  writer.zip_ = ::zipOpen2_64(path.c_str(), APPEND_STATUS_CREATE, nullptr, &calls);
  if (writer.zip_ == nullptr) return writer.cannot_write();
  return writer;
}

ZipWriter::ZipWriter(ZipWriter&& other) noexcept
    : path_(other.path_),
      file_(std::move(other.file_)),
      handle_(std::move(other.handle_)),
      zip_(std::exchange(other.zip_, nullptr)),
      named_(std::exchange(other.named_, true)) {}

ZipWriter::~ZipWriter() {
  if (zip_ != nullptr) ::zipClose(zip_, nullptr);
  if (!named_) ::unlink(new_path().c_str());
}

FixedPath ZipWriter::new_path() const {
  FixedPath path = path_;
  path.add(".part");
  return path;
}

tl::unexpected<Error> ZipWriter::cannot_write() const {
  const int reason = handle_->reason != 0 ? handle_->reason : ENOMEM;  // minizip's own errors are all of memory
  return fail(ErrorCode::kCannotWrite, "%s: cannot be written: %s.\tMake room there, or choose another folder", path(),
              std::strerror(reason));
}

Status ZipWriter::add(const char* name, std::span<const std::byte> bytes, Packing packing) {
  constexpr uLong kFirstOfJanuary1980 = 1U << 21U | 1U << 16U;
  constexpr uLong kFileMode = 0100644U << 16U;
  constexpr uLong kMadeOnUnix = 3U << 8U | 20U;
  zip_fileinfo facts = {};
  facts.dosDate = kFirstOfJanuary1980;
  facts.external_fa = kFileMode;
  const int method = packing == Packing::kStore ? 0 : Z_DEFLATED;
  const int opened =
      ::zipOpenNewFileInZip4_64(zip_, name, &facts, nullptr, 0, nullptr, 0, nullptr, method, Z_DEFAULT_COMPRESSION, 0,
                                -MAX_WBITS, DEF_MEM_LEVEL, Z_DEFAULT_STRATEGY, nullptr, 0, kMadeOnUnix, 0, 0);
  if (opened != ZIP_OK) return cannot_write();
  const int written = ::zipWriteInFileInZip(zip_, bytes.data(), static_cast<unsigned>(bytes.size()));
  const int closed = ::zipCloseFileInZip(zip_);
  return written == ZIP_OK && closed == ZIP_OK ? Status() : Status(cannot_write());
}

Status ZipWriter::finish() {
  const int closed = ::zipClose(std::exchange(zip_, nullptr), nullptr);
  if (closed != ZIP_OK) return cannot_write();
  if (::rename(new_path().c_str(), path()) != 0) {
    handle_->reason = errno;
    return cannot_write();
  }
  named_ = true;
  return {};
}

}  // namespace plumbline::firmware::inline archive
