#include "slicer/reader/records/records_end.hpp"

#include <algorithm>

#include "slicer/reader/stream/number.hpp"
#include "slicer/reader/stream/words.hpp"

namespace plumbline::inline slicer {

Status check_end(ByteInput& input, const char* what, std::uint64_t count, std::uint64_t least, std::uint64_t limit) {
  std::uint64_t bytes = 0;
  bool empty = true;
  while (bytes < limit) {
    const auto ready = input.fill(1);
    PLUMBLINE_TRY(ready);
    if (*ready == 0) break;
    const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(*ready, limit - bytes));
    empty = empty && std::all_of(input.begin(), input.begin() + size, [](char byte) { return byte == 0; });
    bytes += size;
    input.consume(size);
  }
  if (empty || bytes < least) return {};
  return input.fail(ErrorCode::kMalformed,
                    "its header declares %llu %s, but %llu bytes follow them, enough for %llu more;\texport it again",
                    static_cast<unsigned long long>(count), what, static_cast<unsigned long long>(bytes),
                    static_cast<unsigned long long>(bytes / least));
}

Status check_text_end(LineInput& lines, const char* what, std::uint64_t count) {
  for (;;) {
    Line line;
    const auto found = lines.next(line);
    PLUMBLINE_TRY(found);
    if (!*found) return {};
    const auto word = LineWords(line.text).next();
    double number = 0;
    if (parse_real(word.data(), word.data() + word.size(), number) == nullptr) continue;
    return lines.input().fail(ErrorCode::kMalformed,
                              "line %llu: its header declares %llu %s, but '%s' follows them;\texport it again",
                              static_cast<unsigned long long>(lines.number()), static_cast<unsigned long long>(count),
                              what, Quote(line.text).c_str());
  }
}

}  // namespace plumbline::inline slicer
