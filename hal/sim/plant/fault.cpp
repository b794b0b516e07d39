#include "hal/sim/plant/fault.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "slicer/core/numbers/to_number.hpp"
#include "slicer/core/words/edit_distance.hpp"

namespace plumbline::inline hal::inline sim {
namespace {

/// "12.5s"
std::optional<nanoseconds> time_of(std::string_view text) {
  if (!text.ends_with('s')) return std::nullopt;
  const auto seconds = to_number<double>(text.substr(0, text.size() - 1));
  if (!seconds || !(*seconds >= 0 && *seconds <= 1e8)) return std::nullopt;
  return nanoseconds(std::llround(*seconds * 1e9));
}

struct Text {
  std::string_view all;
  [[nodiscard]] tl::unexpected<Error> wrong(const char* allowed) const {
    return fail(ErrorCode::kBadSetting, "fault \"%.*s\": %s", static_cast<int>(std::min<std::size_t>(all.size(), 120)),
                all.data(), allowed);
  }
};

Status read_moment(std::string_view moment, const Text& text, Fault& fault) {
  if (moment.starts_with("t=")) {
    const auto time = time_of(moment.substr(2));
    if (!time) return text.wrong("t= takes seconds from 0 to 1e8, such as t=123.4s");
    fault.delay = *time;
    return {};
  }
  if (!moment.starts_with("layer=")) return text.wrong("add a time: @layer=40, @layer=40+1.5s or @t=123.4s");
  moment.remove_prefix(6);
  const auto plus = moment.find('+');
  fault.layer = to_number<std::uint32_t>(moment.substr(0, plus));
  if (!fault.layer) return text.wrong("layer= takes a whole number; 0 is the first layer");
  if (plus == std::string_view::npos) return {};
  const auto delay = time_of(moment.substr(plus + 1));
  if (!delay) return text.wrong("+ takes seconds from 0 to 1e8, such as layer=40+1.5s");
  fault.delay = *delay;
  return {};
}

Status read_option(std::string_view option, const Text& text, const FaultRow& row, Fault& fault) {
  if (option.starts_with("for=")) {
    fault.lasts = time_of(option.substr(4));
    if (!fault.lasts) return text.wrong("for= takes seconds from 0 to 1e8, such as for=5s");
    return {};
  }
  if (!option.starts_with("by=")) return text.wrong("after a comma, write for=5s or by=0.2");
  if (row.by.empty()) return text.wrong("this fault has no amount: remove by=");
  const auto amount = to_number<double>(option.substr(3));
  if (!amount || !(*amount >= row.least && *amount <= row.most)) {
    return fail(ErrorCode::kBadSetting, "fault \"%.*s\": by= takes %g to %g (%.*s)", static_cast<int>(text.all.size()),
                text.all.data(), row.least, row.most, static_cast<int>(row.by.size()), row.by.data());
  }
  fault.amount = *amount;
  return {};
}

}  // namespace

Expected<Fault> parse_fault(std::string_view all) {
  const Text text{all};
  const auto table = fault_table();
  const auto name = all.substr(0, all.find('@'));
  const auto row = std::find_if(table.begin(), table.end(), [&](const FaultRow& r) { return r.name == name; });
  if (row == table.end()) {
    const auto nearest = std::min_element(table.begin(), table.end(), [&](const FaultRow& a, const FaultRow& b) {
      return edit_distance(a.name, name.substr(0, 64)) < edit_distance(b.name, name.substr(0, 64));
    });
    return fail(ErrorCode::kBadSetting, "fault \"%.*s\": unknown; did you mean %.*s?",
                static_cast<int>(std::min<std::size_t>(all.size(), 120)), all.data(),
                static_cast<int>(nearest->name.size()), nearest->name.data());
  }
  if (name.size() == all.size()) return text.wrong("add a time: @layer=40, @layer=40+1.5s or @t=123.4s");
  Fault fault{.kind = row->kind, .layer = std::nullopt, .delay = {}, .lasts = std::nullopt, .amount = row->amount};
  auto rest = all.substr(name.size() + 1);
  const auto moment = rest.substr(0, rest.find(','));
  PLUMBLINE_TRY(read_moment(moment, text, fault));
  rest.remove_prefix(moment.size());
  while (!rest.empty()) {
    rest.remove_prefix(1);
    const auto option = rest.substr(0, rest.find(','));
    PLUMBLINE_TRY(read_option(option, text, *row, fault));
    rest.remove_prefix(option.size());
  }
  return fault;
}

}  // namespace plumbline::inline hal::inline sim
