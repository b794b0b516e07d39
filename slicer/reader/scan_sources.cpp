#include "slicer/reader/scan_sources.hpp"

#include <cstdio>

#include "slicer/core/words/printable_text.hpp"

namespace plumbline::inline slicer {

ScanTitle title_of(ScanSources sources) { return title_of(sources.front()->name(), sources.size()); }

ScanTitle title_of(std::string_view first, std::size_t count) {
  ScanTitle title;
  // Leaves room for " and 31 more".
  const PrintableText shown(first, title.text.size() - 24);
  const auto length = static_cast<int>(shown.view().size());
  if (count == 1) {
    std::snprintf(title.text.data(), title.text.size(), "%.*s", length, shown.c_str());
  } else {
    std::snprintf(title.text.data(), title.text.size(), "%.*s and %zu more", length, shown.c_str(), count - 1);
  }
  return title;
}

ScanSummary sum_of(const ScanSummaries& summaries) {
  ScanSummary sum;
  if (summaries.count == 0) return sum;
  sum.header = summaries.each[0].header;
  for (const ScanSummary& scan : summaries.all()) {
    sum.header.has_normals |= scan.header.has_normals;
    sum.header.has_unsigned_normals |= scan.header.has_unsigned_normals;
    sum.header.is_in_mm |= scan.header.is_in_mm;
  }
  for (const ScanSummary& scan : summaries.all()) {
    sum.points += scan.points;
    sum.not_finite += scan.not_finite;
    sum.left_out += scan.left_out;
    sum.bytes += scan.bytes;
    if (sum.header.has_normals) sum.without_normal += scan.header.has_normals ? scan.without_normal : scan.points;
  }
  return sum;
}

}  // namespace plumbline::inline slicer
