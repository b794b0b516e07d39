#include "firmware/screen/look.hpp"

#include <algorithm>
#include <cassert>

namespace plumbline::firmware::inline screen {
namespace {

int thirds_of(int columns, int rows) {
  assert(columns >= kLeastColumns && rows >= kLeastRows);
  return std::min(3 * columns / kLeastColumns, 3 * rows / kLeastRows);
}

}  // namespace

Look::Look(int columns, int rows)
    : thirds(thirds_of(columns, rows)),
      plain(FontWeight::kRegular, 3 * thirds),
      bold(FontWeight::kBold, 3 * thirds),
      title(FontWeight::kBold, 4 * thirds),
      large(FontWeight::kBold, 5 * thirds) {}

}  // namespace plumbline::firmware::inline screen
