#include "slicer/placement/base_choice.hpp"

namespace plumbline {

const char* to_string(BaseChoice choice) {
  switch (choice) {
    case BaseChoice::kAuto: return "auto";
    case BaseChoice::kNone: return "none";
    case BaseChoice::kFlat: return "flat";
  }
  return "unknown";
}

}  // namespace plumbline
