#include "firmware/print/store/kept_prints.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>
#include <type_traits>
#include <vector>

#include "firmware/io/hash64.hpp"

namespace plumbline {
namespace {

constexpr const char* kFolder = "prints";
constexpr const char* kNew = "new";
constexpr std::size_t kDigits = 8;
constexpr mode_t kFileMode = 0644;
constexpr mode_t kFolderMode = 0755;

/// Change the version whenever KeptPrint changes.
struct Head {
  std::uint32_t magic = 0x4E525050;  // "PPRN"
  std::uint32_t version = 1;
  KeptPrint print;
};
static_assert(std::is_trivially_copyable_v<Head>);

using FileName = FixedText<24>;
FileName name_of(std::uint32_t number) {
  FileName name;
  name.add("%0*u", static_cast<int>(kDigits), number);
  return name;
}

/// @returns 0: it is not the name of a kept print
std::uint32_t number_of(std::string_view name) {
  std::uint32_t number = 0;
  const auto [end, problem] = std::from_chars(name.data(), name.data() + name.size(), number);
  return problem == std::errc() && name == name_of(number).view() ? number : 0;
}

std::uint64_t size_of(const KeptPrint& print) {
  return sizeof(Head) + print.report_bytes + print.preview_bytes + sizeof(std::uint64_t);
}

/// Writes into the file and adds to the hash.
class HashedFile final : public TextSink {
 public:
  explicit HashedFile(const Descriptor& file) : file_(file) {}
  Status write(std::string_view text) override {
    const auto part = std::as_bytes(std::span(text));
    if (bytes + part.size() > KeptPrints::kMostOfOne) {
      errno = EFBIG;
      return fail(ErrorCode::kCannotWrite, "the report has more than %llu MiB",
                  static_cast<unsigned long long>(KeptPrints::kMostOfOne >> 20U));
    }
    bytes += part.size();
    hash.add(part);
    if (file_.write_all(part)) return {};
    return fail(ErrorCode::kCannotWrite, "%s", std::strerror(errno));
  }

  std::uint64_t bytes = 0;
  Hash64 hash;

 private:
  const Descriptor& file_;
};

/// Reads a print that is whole. @returns false: it is torn, or no print
bool read_whole(int folder, std::uint32_t number, KeptPrint& print) {
  const Descriptor file(::openat(folder, name_of(number).c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  struct stat facts {};
  if (!file.is_open() || ::fstat(file.get(), &facts) != 0 || !S_ISREG(facts.st_mode)) return false;
  Head head;
  if (!file.read_all(std::as_writable_bytes(std::span(&head, 1)))) return false;
  const Head known;
  print = head.print;
  const auto most = KeptPrints::kMostOfOne;
  if (head.magic != known.magic || head.version != known.version || print.number != number ||
      print.report_bytes > most || print.preview_bytes > most ||
      size_of(print) != static_cast<std::uint64_t>(facts.st_size)) {
    return false;
  }
  Hash64 hash;
  std::array<std::byte, 16384> block;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  for (std::uint64_t left = print.report_bytes + print.preview_bytes; left > 0;) {
    const auto part = std::span(block).first(static_cast<std::size_t>(std::min<std::uint64_t>(left, block.size())));
    if (!file.read_all(part)) return false;
    hash.add(part);
    left -= part.size();
  }
  hash.add(std::as_bytes(std::span(&head, 1)));
  std::uint64_t stored = 0;
  return file.read_all(std::as_writable_bytes(std::span(&stored, 1))) && stored == hash.value();
}

tl::unexpected<Error> cannot_read(std::uint32_t number) {
  return fail(ErrorCode::kCannotRead, "print %u can't be read: %s", number, std::strerror(errno));
}

}  // namespace

tl::unexpected<Error> KeptPrints::cannot_write() const {
  const int reason = errno;
  return fail(ErrorCode::kCannotWrite, "%s: the print's report can't be kept: %s", path_.c_str(),
              std::strerror(reason));
}

Expected<KeptPrints> KeptPrints::open(const std::string& state, FunctionRef<void(std::string_view)> tell) {
  KeptPrints prints;
  prints.path_.add("%s/%s", state.c_str(), kFolder);
  const char* const path = prints.path_.c_str();
  const auto cannot_open = [&] {
    const int reason = errno;
    return fail(ErrorCode::kCannotOpen, "%s: %s", path, std::strerror(reason));
  };
  if (::mkdir(path, kFolderMode) != 0 && errno != EEXIST) return cannot_open();
  prints.folder_ = Descriptor(::open(path, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  const std::unique_ptr<DIR, int (*)(DIR*)> folder(::opendir(path), ::closedir);
  if (!prints.folder_.is_open() || !folder) return cannot_open();
  std::vector<std::uint32_t> numbers;
  while (const dirent* const entry = ::readdir(folder.get())) {
    if (const std::uint32_t number = number_of(entry->d_name); number > 0) numbers.push_back(number);
  }
  FixedText<200> text;
  if (::unlinkat(prints.folder_.get(), kNew, 0) == 0) tell("the last print's report was not kept: the power went");
  std::ranges::sort(numbers);
  for (const std::uint32_t number : numbers) {
    KeptPrint print;
    if (read_whole(prints.folder_.get(), number, print)) {
      prints.insert(print);
      continue;
    }
    text.clear();
    text.add("the report of print %u is damaged and was removed", number);
    tell(text.view());
    static_cast<void>(::unlinkat(prints.folder_.get(), name_of(number).c_str(), 0));
  }
  return prints;
}

std::uint64_t KeptPrints::bytes() const {
  std::uint64_t sum = 0;
  for (const KeptPrint& print : list()) sum += size_of(print);
  return sum;
}

void KeptPrints::drop_oldest() {
  static_cast<void>(::unlinkat(folder_.get(), name_of(list_[--count_].number).c_str(), 0));
}

/// As the newest.
void KeptPrints::insert(const KeptPrint& print) {
  while (count_ == kMost || (count_ > 0 && bytes() + size_of(print) > kMostBytes)) drop_oldest();
  std::move_backward(list_.begin(), list_.begin() + count_, list_.begin() + count_ + 1);
  list_[0] = print;
  ++count_;
}

Status KeptPrints::keep(KeptPrint facts, FunctionRef<Status(TextSink&)> write_report,
                        std::span<const std::byte> preview) {
  facts.number = count_ > 0 ? list_[0].number + 1 : 1;
  for (;;) {
    const auto written = write(facts, write_report, preview);
    if (written) break;
    const bool is_full = errno == ENOSPC || errno == EDQUOT;
    static_cast<void>(::unlinkat(folder_.get(), kNew, 0));
    if (!is_full || count_ == 0) return written;
    drop_oldest();
  }
  insert(facts);
  return {};
}

/// @returns an error: errno has the reason
Status KeptPrints::write(KeptPrint& facts, FunctionRef<Status(TextSink&)> write_report,
                         std::span<const std::byte> preview) {
  const int flags = O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC;
  const Descriptor file(::openat(folder_.get(), kNew, flags, kFileMode));
  Head head;
  const auto head_bytes = std::as_bytes(std::span(&head, 1));
  // The sizes are known afterwards.
  if (!file.is_open() || !file.write_all(head_bytes)) return cannot_write();
  HashedFile out(file);
  if (!write_report(out)) return cannot_write();
  facts.report_bytes = out.bytes;
  facts.preview_bytes = preview.size();
  head.print = facts;
  out.hash.add(preview);
  out.hash.add(head_bytes);
  const std::uint64_t hash = out.hash.value();
  if (!file.write_all(preview) || !file.write_all(std::as_bytes(std::span(&hash, 1)))) return cannot_write();
  if (::pwrite(file.get(), head_bytes.data(), head_bytes.size(), 0) != static_cast<ssize_t>(head_bytes.size()) ||
      ::fdatasync(file.get()) != 0 ||
      ::renameat(folder_.get(), kNew, folder_.get(), name_of(facts.number).c_str()) != 0 ||
      ::fsync(folder_.get()) != 0) {
    return cannot_write();
  }
  return {};
}

Expected<KeptPrints::Place> KeptPrints::find(std::uint32_t number, Part part) const {
  const auto prints = list();
  const auto print = std::ranges::find(prints, number, &KeptPrint::number);
  if (print == prints.end()) return fail(ErrorCode::kBadSetting, "print %u is not kept", number);
  const bool is_report = part == Part::kReport;
  const std::uint64_t size = is_report ? print->report_bytes : print->preview_bytes;
  if (size == 0) return fail(ErrorCode::kBadSetting, "print %u has no preview", number);
  Descriptor file(::openat(folder_.get(), name_of(number).c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
  if (!file.is_open()) return cannot_read(number);
  return Place{std::move(file), sizeof(Head) + (is_report ? 0 : print->report_bytes), size};
}

Expected<KeptPrints::Got> KeptPrints::read(std::uint32_t number, Part part, std::uint64_t from,
                                           std::span<std::byte> out) const {
  const auto place = find(number, part);
  PLUMBLINE_TRY(place);
  if (from >= place->bytes) return Got{0, place->bytes};
  const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(out.size(), place->bytes - from));
  const ssize_t got = ::pread(place->file.get(), out.data(), wanted, static_cast<off_t>(place->from + from));
  if (got < 0) return cannot_read(number);
  return Got{static_cast<std::size_t>(got), place->bytes};
}

}  // namespace plumbline
