#include "firmware/daemon/stick/stick_reports.hpp"

#include <algorithm>
#include <array>
#include <ctime>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/io/wall_clock.hpp"
#include "hal/process/report_folder.hpp"

namespace plumbline::firmware {
namespace {

constexpr std::size_t kPrinterBytes = 32;  ///< of its name, at most
constexpr std::array kParts = {KeptPrints::Part::kReport, KeptPrints::Part::kPreview};

using ReportName = FixedText<kReportNameBytes>;

ReportName name_of(const KeptPrint& print, KeptPrints::Part part, std::string_view printer) {
  ReportName name;
  for (const char c : printer.substr(0, kPrinterBytes)) {
    const bool plain = c != '.' && is_report_name({&c, 1});
    name.add("%c", plain ? c : '-');
  }
  if (known_time(print.ended_at) != 0) {
    const auto ended = static_cast<std::time_t>(print.ended_at);
    std::tm day{};
    ::gmtime_r(&ended, &day);
    name.add("-%04d%02d%02d", std::clamp(day.tm_year + 1900, 0, 9999), day.tm_mon + 1, day.tm_mday);
  }
  name.add("-%04u.%s", print.number, part == KeptPrints::Part::kReport ? "json" : "png");
  return name;
}

bool has(const KeptPrint& print, KeptPrints::Part part) {
  return (part == KeptPrints::Part::kReport ? print.report_bytes : print.preview_bytes) > 0;
}

/// Notes which of the reports a stick has.
class ReportVisitor final : public StickMount::FileVisitor {
 public:
  ReportVisitor(const KeptPrints& prints, std::string_view printer) : prints_(prints), printer_(printer) {}

  void on_file(std::string_view name, const StickFileFacts& /*facts*/) override { note(name); }
  void on_other(std::string_view name, const char* /*what*/) override { note(name); }
  bool wants_facts(std::string_view /*name*/) override { return false; }
  bool seen(std::size_t print, std::size_t part) const { return seen_[print][part]; }

 private:
  void note(std::string_view name) {
    const auto prints = prints_.list();
    for (std::size_t i = 0; i < prints.size(); ++i) {
      for (std::size_t p = 0; p < kParts.size(); ++p) {
        seen_[i][p] = seen_[i][p] || name_of(prints[i], kParts[p], printer_).view() == name;
      }
    }
  }

  const KeptPrints& prints_;
  std::string_view printer_;
  std::array<std::array<bool, kParts.size()>, KeptPrints::kMost> seen_ = {};
};

}  // namespace

Expected<StoredReports> store_reports(StickPort& stick, const KeptPrints& prints, std::string_view printer) {
  StoredReports stored;
  ReportVisitor visitor(prints, printer);
  {
    const auto mount = stick.mount();
    PLUMBLINE_TRY(mount);
    stored.asked = mount->is_folder(kReportFolder);
    if (!stored.asked) return stored;
    PLUMBLINE_TRY(mount->for_each_file(visitor, kReportFolder));
  }
  const auto list = prints.list();
  for (std::size_t i = list.size(); i-- > 0;) {  // the oldest first
    for (std::size_t p = 0; p < kParts.size(); ++p) {
      if (visitor.seen(i, p) || !has(list[i], kParts[p])) continue;
      const auto place = prints.find(list[i].number, kParts[p]);
      PLUMBLINE_TRY(place);
      const ReportName name = name_of(list[i], kParts[p], printer);
      const auto written = stick.store({name.view(), place->file.get(), place->from, place->bytes});
      PLUMBLINE_TRY(written);
      stored.files += *written ? 1 : 0;
    }
  }
  return stored;
}

}  // namespace plumbline::firmware
