#include "firmware/page/clients/pairing_codes.hpp"

#include <algorithm>
#include <cstring>
#include <tuple>

#include "firmware/messages/printer_code.hpp"
#include "firmware/page/clients/paired_browsers.hpp"

namespace plumbline::firmware::inline page {
namespace {

PageCode new_page_code() {
  constexpr std::uint32_t kCodes = 1'000'000;
  constexpr std::uint32_t kFair = UINT32_MAX - UINT32_MAX % kCodes;  // numbers below are spread evenly
  std::uint32_t number = kFair;
  while (number >= kFair) {
    std::array<std::uint8_t, sizeof number> bytes;
    fill_random(bytes);
    std::memcpy(&number, bytes.data(), sizeof number);
  }
  PageCode code;
  code.add("%06u", number % kCodes);
  return code;
}

unsigned seconds_of(PairingCodes::HostClock::duration time) {
  return static_cast<unsigned>(std::max<std::int64_t>(1, std::chrono::ceil<std::chrono::seconds>(time).count()));
}

tl::unexpected<Error> too_many_codes(PairingCodes::HostClock::duration left) {
  return telling(Told(PrinterCode::kCodesTooMany, {{PrinterFact::kWaitS, seconds_of(left)}}),
                 fail(ErrorCode::kBusy, "there were too many wrong codes.\tTry again in %u s", seconds_of(left)));
}

}  // namespace

bool PairingCodes::Who::is(const Asker& asker) const {
  if (name.view().empty() || asker.name.empty())
    return name.view().empty() && asker.name.empty() && address == asker.address;
  return is_same_secret(name.view(), asker.name);
}

PairingCodes::Who PairingCodes::who(const Asker& asker) {
  Who who;
  who.name.add("%.*s", static_cast<int>(asker.name.size()), asker.name.data());
  who.address = asker.address;
  return who;
}

std::string_view PairingCodes::shown(HostClock::time_point now) const {
  return now <= valid_until_ ? code_.view() : std::string_view();
}

Status PairingCodes::check_offender(const Asker& asker, HostClock::time_point now) const {
  const auto* const offender = std::ranges::find_if(
      offenders_, [&](const Offender& one) { return one.times > 0 && one.address == asker.address; });
  if (offender == offenders_.end() || now >= offender->until) return {};
  return too_many_codes(offender->until - now);
}

/// Keeps a browser's place among those that wait. @returns how long that takes
tl::unexpected<Error> PairingCodes::wait(const Asker& asker, HostClock::time_point now) {
  auto* place = std::ranges::find_if(
      waiters_, [&](const Waiter& one) { return one.is_there && one.who.address == asker.address; });
  if (place == waiters_.end()) {
    place = std::ranges::find(waiters_, false, &Waiter::is_there);
    if (place != waiters_.end()) *place = {who(asker), now, now, true};
  } else if (place->who.is(asker)) {
    place->seen = now;
  }
  const HostClock::time_point since = place != waiters_.end() ? place->since : now;
  const auto before =
      std::ranges::count_if(waiters_, [&](const Waiter& one) { return one.is_there && one.since < since; });
  const auto code = std::max(valid_until_ - now, HostClock::duration(kWaiterTime));
  const unsigned seconds = seconds_of(code + before * HostClock::duration(kCodeTime));
  return telling(Told(PrinterCode::kCodeOfOther, {{PrinterFact::kWaitS, seconds}}),
                 fail(ErrorCode::kBusy, "another browser is being paired.\tThis one's turn comes in %u s", seconds));
}

Expected<PageCode> PairingCodes::ask(const Asker& asker, HostClock::time_point now) {
  PLUMBLINE_TRY(check_offender(asker, now));
  for (Waiter& one : waiters_) one.is_there = one.is_there && now - one.seen < kWaiterTime;
  const bool is_shown = !shown(now).empty();
  const bool others_wait =
      std::ranges::any_of(waiters_, [&](const Waiter& one) { return one.is_there && !one.who.is(asker); });
  if (is_shown && !owner_.is(asker)) return wait(asker, now);
  // Somebody may be typing it.
  if (is_shown && (others_wait || now + kCodeTime / 4 < valid_until_)) return code_;
  auto* const first = std::ranges::min_element(waiters_, std::less<>(),
                                               [](const Waiter& one) { return std::tuple(!one.is_there, one.since); });
  if (first->is_there && !first->who.is(asker)) return wait(asker, now);
  if (now < none_before_) return too_many_codes(none_before_ - now);
  first->is_there = false;
  code_ = new_page_code();
  owner_ = who(asker);
  valid_until_ = now + kCodeTime;
  tries_ = 0;
  return code_;
}

Status PairingCodes::use(std::string_view code, const Asker& asker, HostClock::time_point now) {
  PLUMBLINE_TRY(check_offender(asker, now));
  if (shown(now).empty() || !owner_.is(asker)) {
    return telling(Told(PrinterCode::kCodeOld),
                   fail(ErrorCode::kBadSetting, "this browser has no code, or it is too old.\tAsk for a new one"));
  }
  if (is_same_secret(code, code_.view())) {
    code_.clear();
    for (Offender& one : offenders_) {
      if (one.address == asker.address) one = {};
    }
    return {};
  }
  if (++tries_ == kMostTries) void_code(asker, now);
  return telling(Told(PrinterCode::kCodeWrong),
                 fail(ErrorCode::kBadSetting, "that is not the code.\tRead it on the printer's screen"));
}

void PairingCodes::void_code(const Asker& asker, HostClock::time_point now) {
  code_.clear();
  ++void_codes_;
  // Those who have to wait longest are remembered longest.
  auto* offender = std::ranges::find_if(
      offenders_, [&](const Offender& one) { return one.times > 0 && one.address == asker.address; });
  if (offender == offenders_.end()) {
    offender = std::ranges::min_element(offenders_, std::less<>(), &Offender::until);
    *offender = {asker.address, 0, now};
  }
  const auto wait = std::min<HostClock::duration>(kFirstWait * (1U << std::min(offender->times, 10U)), kLongestWait);
  offender->until = now + wait;
  ++offender->times;
  if (!void_budget_.take(now)) none_before_ = now + void_budget_.wait(now);
}

void PairingCodes::give_up(const Asker& asker) {
  if (owner_.is(asker)) code_.clear();
  for (Waiter& one : waiters_) {
    if (one.who.is(asker)) one.is_there = false;
  }
}

}  // namespace plumbline::firmware::inline page
