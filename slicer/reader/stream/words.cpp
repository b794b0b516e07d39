#include "slicer/reader/stream/words.hpp"

#include <algorithm>

namespace plumbline::inline slicer {
bool has_ending(std::string_view name, std::string_view ending) {
  return name.size() >= ending.size() && same_word(name.substr(name.size() - ending.size()), ending);
}

Quote::Quote(std::string_view bytes) {
  const std::size_t length = std::min(bytes.size(), kLongest);
  std::size_t out = 0;
  for (; out < length; ++out) text_[out] = bytes[out] >= ' ' && bytes[out] <= '~' ? bytes[out] : '?';
  if (bytes.size() > kLongest) {
    for (int dot = 0; dot < 3; ++dot) text_[out++] = '.';
  }
}

}  // namespace plumbline::inline slicer
