#include "slicer/core/words/told.hpp"

#include <cassert>

#include "slicer/core/words/printable_text.hpp"

namespace plumbline::inline slicer {

void Told::set_name(std::string_view name) {
  PrintableText(name, text.size() - 1).view().copy(text.data(), text.size() - 1);
}

void Told::add(Fact fact, double value) {
  assert(count < kMostFacts);
  if (count == kMostFacts) return;
  facts[count] = fact;
  values[count++] = value;
}

}  // namespace plumbline::inline slicer
