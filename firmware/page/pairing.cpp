#include "firmware/page/pairing.hpp"

#include <fcntl.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <span>

#include "firmware/told/printer_code.hpp"

namespace plumbline {
namespace {

/// Fills bytes from the kernel's generator. Ends the process if that fails, since there would be no secrets.
void fill_random(std::span<std::uint8_t> bytes) {
  while (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    if (errno != EINTR) std::abort();
  }
}

/// Takes as long for any two texts of a length, so that time tells nothing of where they differ.
bool same(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) difference |= static_cast<unsigned char>(a[i] ^ b[i]);
  return difference == 0;
}

template <class Bytes>
bool is_there(const Bytes& bytes) {
  return std::any_of(bytes.begin(), bytes.end(), [](std::uint8_t byte) { return byte != 0; });
}

template <class Bytes>
PageToken token_of(const Bytes& bytes) {
  PageToken token;
  for (const std::uint8_t byte : bytes) token.add("%02x", byte);
  return token;
}

}  // namespace

Expected<Pairing> Pairing::open(const std::string& folder) {
  Pairing pairing;
  if (folder.empty()) return pairing;
  const std::string path = folder + "/browsers";
  pairing.file_ = Descriptor(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (!pairing.file_.is_open()) {
    return fail(ErrorCode::kCannotOpen, "%s: %s.\tName another folder: --state", path.c_str(), std::strerror(errno));
  }
  const ssize_t got = ::pread(pairing.file_.get(), pairing.tokens_.data(), sizeof pairing.tokens_, 0);
  if (got < 0) return fail(ErrorCode::kCannotRead, "%s: %s", path.c_str(), std::strerror(errno));
  // A file of another size is new, or was not written whole: nobody is paired then.
  if (got != static_cast<ssize_t>(sizeof pairing.tokens_)) pairing.tokens_ = {};
  return pairing;
}

Expected<PageCode> Pairing::new_code(HostClock::time_point now) {
  if (none_before_ && now < *none_before_) {
    return telling(Told(PrinterCode::kCodesTooMany),
                   fail(ErrorCode::kBusy, "there were too many wrong codes.\tTry again in a minute"));
  }
  // Somebody may be typing it.
  if (!code_.view().empty() && now + kCodeTime / 4 < valid_until_) return code_;
  constexpr std::uint32_t kCodes = 1'000'000;
  constexpr std::uint32_t kFair = UINT32_MAX - UINT32_MAX % kCodes;  // numbers below are spread evenly
  std::uint32_t number = kFair;
  while (number >= kFair) {
    std::array<std::uint8_t, sizeof number> bytes;
    fill_random(bytes);
    std::memcpy(&number, bytes.data(), sizeof number);
  }
  code_.clear();
  code_.add("%06u", number % kCodes);
  valid_until_ = now + kCodeTime;
  tries_ = 0;
  return code_;
}

Expected<PageToken> Pairing::pair(std::string_view code, HostClock::time_point now) {
  if (code_.view().empty() || now > valid_until_) {
    code_.clear();
    return telling(Told(PrinterCode::kCodeOld),
                   fail(ErrorCode::kBadSetting, "the code is too old.\tAsk for a new one"));
  }
  if (same(code, code_.view())) {
    code_.clear();
    return add();
  }
  if (++tries_ == kMostTries) {
    code_.clear();
    none_before_ = now + kBetweenCodes;
  }
  return telling(Told(PrinterCode::kCodeWrong),
                 fail(ErrorCode::kBadSetting, "that is not the code.\tRead it on the printer's screen"));
}

PageToken Pairing::add() {
  auto place =
      static_cast<std::size_t>(std::find_if_not(tokens_.begin(), tokens_.end(), is_there<Bytes>) - tokens_.begin());
  if (place == tokens_.size()) place = next_++ % kMostBrowsers;
  fill_random(tokens_[place]);
  if (file_.is_open()) {
    // If this fails, the browser is asked for a code again after a restart.
    static_cast<void>(!::pwrite(file_.get(), tokens_.data(), sizeof tokens_, 0));
  }
  return token_of(tokens_[place]);
}

bool Pairing::knows(std::string_view token) const {
  bool known = false;
  for (const Bytes& bytes : tokens_) {
    if (is_there(bytes)) known |= same(token, token_of(bytes).view());
  }
  return known;
}

}  // namespace plumbline
