#include "firmware/daemon/service/service_status.hpp"

namespace plumbline::firmware {

FixedText<200> service_status(const PrintReport& report) {
  FixedText<200> text;
  if (report.fault == FaultCode::kNone) {
    const auto state = to_string(report.state);
    text.add("%.*s", static_cast<int>(state.size()), state.data());
    return text;
  }
  // Without the message: a status line holds 200 characters.
  const FaultText fault = explain(report.fault, {});
  text.add("%s. %s", fault.what.c_str(), fault.advice.c_str());
  return text;
}

}  // namespace plumbline::firmware
