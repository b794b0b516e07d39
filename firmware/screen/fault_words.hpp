#pragma once

#include <string_view>

#include "firmware/print/status/fault.hpp"
#include "firmware/screen/words.hpp"

namespace plumbline {

/// A fault's title, what it means and what to do next.
struct FaultWords {
  std::string_view title;
  std::string_view meaning;
  std::string_view next;
};

/// @param code  not kNone
FaultWords fault_words(FaultCode code, Language language);

}  // namespace plumbline
