#include "firmware/print/job/kept_prints.hpp"

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

namespace plumbline::firmware {
namespace {

constexpr const char* kFolder = "prints";
constexpr const char* kNew = "new";
constexpr std::size_t kDigits = 8;

/// Change the version whenever KeptPrint changes.
struct Head {
  std::uint32_t magic = 0x4E525050;  // "PPRN"
  std::uint32_t version = 1;
  KeptPrint print;
};
static_assert(std::is_trivially_copyable_v<Head>);

using PrintName = FixedText<24>;
PrintName name_of(std::uint32_t number) {
  PrintName name;
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
    if (problem == 0 && bytes + part.size() > KeptPrints::kMostOfOne) problem = EFBIG;
    if (problem == 0 && !file_.write_all(part)) problem = errno;
    if (problem != 0) return fail(ErrorCode::kCannotWrite, "%s", std::strerror(problem));
    bytes += part.size();
    hash.add(part);
    return {};
  }

  std::uint64_t bytes = 0;  ///< that have been written
  int problem = 0;          ///< errno of the write that failed
  Hash64 hash;

 private:
  const Descriptor& file_;
};

class ByteCount final : public TextSink {
 public:
  Status write(std::string_view text) override {
    bytes += text.size();
    return {};
  }
  std::uint64_t bytes = 0;
};

enum class Found : std::uint8_t {
  kWhole,
  kTorn,        ///< or no print
  kUnreadable,  ///< errno has the reason, which may pass
};

/// What a read that has failed says of its file: errno is 0 at the file's end.
Found failed_read() { return errno == 0 ? Found::kTorn : Found::kUnreadable; }

Found read_print(int folder, std::uint32_t number, KeptPrint& print) {
  const Descriptor file(::openat(folder, name_of(number).c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  struct stat facts {};
  if (!file.is_open()) return errno == ELOOP || errno == ENXIO ? Found::kTorn : Found::kUnreadable;
  if (::fstat(file.get(), &facts) != 0) return Found::kUnreadable;
  if (!S_ISREG(facts.st_mode)) return Found::kTorn;
  Head head;
  if (!file.read_all(std::as_writable_bytes(std::span(&head, 1)))) return failed_read();
  const Head known;
  print = head.print;
  const auto most = KeptPrints::kMostOfOne;
  if (head.magic != known.magic || head.version != known.version || print.number != number ||
      print.report_bytes > most || print.preview_bytes > most ||
      size_of(print) != static_cast<std::uint64_t>(facts.st_size)) {
    return Found::kTorn;
  }
  Hash64 hash;
  std::array<std::byte, 16384> block;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  for (std::uint64_t left = print.report_bytes + print.preview_bytes; left > 0;) {
    const auto part = std::span(block).first(static_cast<std::size_t>(std::min<std::uint64_t>(left, block.size())));
    if (!file.read_all(part)) return failed_read();
    hash.add(part);
    left -= part.size();
  }
  hash.add(std::as_bytes(std::span(&head, 1)));
  std::uint64_t stored = 0;
  if (!file.read_all(std::as_writable_bytes(std::span(&stored, 1)))) return failed_read();
  return stored == hash.value() ? Found::kWhole : Found::kTorn;
}

tl::unexpected<Error> cannot_read_print(std::uint32_t number) {
  return fail(ErrorCode::kCannotRead, "print %u can't be read: %s", number, std::strerror(errno));
}

/// A new folder is durable when the folder that names it is.
bool make_durable_folder(const char* path, const char* parent) {
  if (::mkdir(path, kFolderMode) != 0) return errno == EEXIST;
  const Descriptor folder(::open(parent, O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return folder.is_open() && ::fsync(folder.get()) == 0;
}

}  // namespace

tl::unexpected<Error> KeptPrints::cannot_write(int reason) const {
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
  if (!make_durable_folder(path, state.c_str())) return cannot_open();
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
    const Found found = read_print(prints.folder_.get(), number, print);
    const int reason = errno;
    text.clear();
    switch (found) {
      case Found::kWhole: prints.insert(print); continue;
      case Found::kTorn:
        text.add("the report of print %u is damaged and was removed", number);
        static_cast<void>(::unlinkat(prints.folder_.get(), name_of(number).c_str(), 0));
        break;
      case Found::kUnreadable:
        text.add("the report of print %u can't be read and is not listed: %s", number, std::strerror(reason));
        prints.newest_ = number;
        break;
    }
    tell(text.view());
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
  newest_ = print.number;
}

/// Drops the oldest prints until that many bytes are free.
/// @returns false: all of them have less, and none was dropped
bool KeptPrints::make_room(std::uint64_t missing) {
  if (count_ == 0 || bytes() < missing) return false;
  std::uint64_t freed = 0;
  do {
    freed += size_of(list_[count_ - 1]);
    drop_oldest();
  } while (freed < missing);
  return true;
}

Status KeptPrints::keep(KeptPrint facts, FunctionRef<Status(TextSink&)> write_report,
                        std::span<const std::byte> preview) {
  facts.number = newest_ + 1;
  Attempt tried = write(facts, write_report, preview);
  if (tried.problem == ENOSPC || tried.problem == EDQUOT) {
    ByteCount report;
    static_cast<void>(write_report(report));
    facts.report_bytes = report.bytes;
    facts.preview_bytes = preview.size();
    const std::uint64_t needed = size_of(facts);
    // Room that others take meanwhile is theirs: the older prints are not given up one after the other.
    if (make_room(needed - std::min(needed, tried.bytes))) tried = write(facts, write_report, preview);
  }
  if (tried.problem != 0) return cannot_write(tried.problem);
  insert(facts);
  return {};
}

/// Writes a print, or leaves nothing of it.
KeptPrints::Attempt KeptPrints::write(KeptPrint& facts, FunctionRef<Status(TextSink&)> write_report,
                                      std::span<const std::byte> preview) {
  const PrintName name = name_of(facts.number);
  Attempt tried = write_new(facts, write_report, preview);
  if (tried.problem != 0) {
    static_cast<void>(::unlinkat(folder_.get(), kNew, 0));
    return tried;
  }
  if (::renameat(folder_.get(), kNew, folder_.get(), name.c_str()) == 0 && ::fsync(folder_.get()) == 0) return tried;
  tried.problem = errno;
  for (const char* const left : {kNew, name.c_str()}) static_cast<void>(::unlinkat(folder_.get(), left, 0));
  return tried;
}

/// Writes kNew and makes its bytes durable.
KeptPrints::Attempt KeptPrints::write_new(KeptPrint& facts, FunctionRef<Status(TextSink&)> write_report,
                                          std::span<const std::byte> preview) {
  const int flags = O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC;
  const Descriptor file(::openat(folder_.get(), kNew, flags, kFileMode));
  Head head;
  const auto head_bytes = std::as_bytes(std::span(&head, 1));
  // The sizes are known afterwards.
  if (!file.is_open() || !file.write_all(head_bytes)) return {errno, 0};
  HashedFile out(file);
  const auto reported = write_report(out);
  const std::uint64_t bytes = sizeof head + out.bytes;
  if (!reported) return {out.problem != 0 ? out.problem : EIO, bytes};
  facts.report_bytes = out.bytes;
  facts.preview_bytes = preview.size();
  head.print = facts;
  out.hash.add(preview);
  out.hash.add(head_bytes);
  const std::uint64_t hash = out.hash.value();
  if (!file.write_all(preview) || !file.write_all(std::as_bytes(std::span(&hash, 1)))) return {errno, bytes};
  if (::lseek(file.get(), 0, SEEK_SET) != 0 || !file.write_all(head_bytes) || ::fdatasync(file.get()) != 0) {
    return {errno, bytes + preview.size()};
  }
  return {0, size_of(facts)};
}

Expected<KeptPrints::Place> KeptPrints::find(std::uint32_t number, Part part) const {
  const auto prints = list();
  const auto print = std::ranges::find(prints, number, &KeptPrint::number);
  if (print == prints.end()) return fail(ErrorCode::kBadSetting, "print %u is not kept", number);
  const bool is_report = part == Part::kReport;
  const std::uint64_t size = is_report ? print->report_bytes : print->preview_bytes;
  if (size == 0) return fail(ErrorCode::kBadSetting, "print %u has no preview", number);
  Descriptor file(::openat(folder_.get(), name_of(number).c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
  if (!file.is_open()) return cannot_read_print(number);
  return Place{std::move(file), sizeof(Head) + (is_report ? 0 : print->report_bytes), size};
}

Expected<KeptPrints::Got> KeptPrints::read(std::uint32_t number, Part part, std::uint64_t from,
                                           std::span<std::byte> out) const {
  const auto place = find(number, part);
  PLUMBLINE_TRY(place);
  if (from >= place->bytes) return Got{0, place->bytes};
  const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(out.size(), place->bytes - from));
  const ssize_t got = ::pread(place->file.get(), out.data(), wanted, static_cast<off_t>(place->from + from));
  if (got < 0) return cannot_read_print(number);
  return Got{static_cast<std::size_t>(got), place->bytes};
}

}  // namespace plumbline::firmware
