#include "firmware/page/clients/paired_browsers.hpp"

#include <fcntl.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "firmware/io/hash64.hpp"

namespace plumbline::firmware::inline page {
namespace {

template <class Bytes>
PageToken token_of(const Bytes& bytes) {
  PageToken token;
  for (const std::uint8_t byte : bytes) token.add("%02x", byte);
  return token;
}

}  // namespace

void fill_random(std::span<std::uint8_t> bytes) {
  while (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    if (errno != EINTR) std::abort();
  }
}

bool is_same_secret(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) difference |= static_cast<unsigned char>(a[i] ^ b[i]);
  return difference == 0;
}

std::uint64_t PairedBrowsers::hash_of(const File& file) {
  Hash64 hash;
  hash.add(std::as_bytes(std::span(&file, 1)).subspan(sizeof file.hash));
  return hash.value();
}

Expected<PairedBrowsers> PairedBrowsers::open(const std::string& folder) {
  PairedBrowsers paired;
  if (folder.empty()) return paired;
  const std::string path = folder + "/browsers";
  paired.kept_ = Descriptor(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (!paired.kept_.is_open()) {
    return fail(ErrorCode::kCannotOpen, "%s: %s.\tName another folder: --state", path.c_str(), std::strerror(errno));
  }
  File file;
  const ssize_t got = ::pread(paired.kept_.get(), &file, sizeof file, 0);
  if (got < 0) return fail(ErrorCode::kCannotRead, "%s: %s", path.c_str(), std::strerror(errno));
  if (got == static_cast<ssize_t>(sizeof file) && file.hash == hash_of(file)) {
    for (Browser& browser : file.browsers) browser.name[sizeof browser.name - 1] = '\0';
    paired.file_ = file;
  } else if (got == static_cast<ssize_t>(sizeof file.tokens)) {
    // Of a plumbline that kept the tokens alone.
    std::memcpy(paired.file_.tokens.data(), &file, sizeof file.tokens);
    for (std::size_t i = 0; i < kMost; ++i) {
      if (paired.file_.tokens[i] == Token{}) continue;
      paired.file_.browsers[i].number = ++paired.file_.last_number;
    }
  }
  // Any other file is new, or was not written whole: nobody is paired then.
  return paired;
}

void PairedBrowsers::write() {
  if (!kept_.is_open()) return;
  file_.hash = hash_of(file_);
  // If this fails, the browser is asked for a code again after a restart.
  static_cast<void>(!::pwrite(kept_.get(), &file_, sizeof file_, 0));
}

PageToken PairedBrowsers::add(std::string_view name, std::time_t now) {
  auto* const place = std::ranges::min_element(
      file_.browsers, std::less<>(), [](const Browser& one) { return std::pair(one.number != 0, one.order); });
  *place = Browser();
  place->number = ++file_.last_number;
  place->order = ++file_.last_order;
  place->paired_at = place->seen_at = now;
  name.copy(place->name, sizeof place->name - 1);
  std::replace_if(
      std::begin(place->name), std::end(place->name), [](char c) { return c != '\0' && (c < ' ' || c > '~'); }, '_');
  Token& token = file_.tokens[static_cast<std::size_t>(place - file_.browsers.begin())];
  fill_random(token);
  write();
  return token_of(token);
}

std::optional<std::uint32_t> PairedBrowsers::find(std::string_view token) const {
  std::optional<std::uint32_t> found;
  for (std::size_t i = 0; i < kMost; ++i) {
    const bool is_there = file_.browsers[i].number != 0;
    if (is_there && is_same_secret(token, token_of(file_.tokens[i]).view())) found = file_.browsers[i].number;
  }
  return found;
}

void PairedBrowsers::seen(std::uint32_t number, std::time_t now) {
  auto* const browser = std::ranges::find(file_.browsers, number, &Browser::number);
  if (browser == file_.browsers.end()) return;
  const bool is_new_day = std::abs(now - browser->seen_at) >= kBetweenWrites;
  browser->seen_at = now;
  if (browser->order != file_.last_order) browser->order = ++file_.last_order;
  if (is_new_day) write();
}

bool PairedBrowsers::forget(std::uint32_t number) {
  auto* const browser = std::ranges::find(file_.browsers, number, &Browser::number);
  if (number == 0 || browser == file_.browsers.end()) return false;
  file_.tokens[static_cast<std::size_t>(browser - file_.browsers.begin())] = {};
  *browser = Browser();
  write();
  return true;
}

}  // namespace plumbline::firmware::inline page
