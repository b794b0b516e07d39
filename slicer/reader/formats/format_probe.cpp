#include "slicer/reader/formats/format_probe.hpp"

#include <algorithm>
#include <cstring>
#include <optional>

#include "slicer/reader/formats/foreign_formats.hpp"
#include "slicer/reader/formats/scan_endings.hpp"
#include "slicer/reader/stream/number.hpp"
#include "slicer/reader/stream/words.hpp"

namespace plumbline::inline slicer {
namespace {

using std::string_view_literals::operator""sv;

struct Mark {
  std::string_view bytes;
  const char* what;
  const char* advice;
  ToldCode code = ToldCode::kNone;  ///< told with the file's name
};
constexpr auto kGzip = "\x1f\x8b"sv;
constexpr auto kOle = "\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"sv;
constexpr const char* kUnpack = "unpack it and give the scan inside";
constexpr const char* kConvert = "convert it to PLY with the program that wrote it or with CloudCompare";

/// Other files that people have on their sticks.
constexpr Mark kMarks[] = {
    {"NGSP"sv, "SPZ of version 4 or later", "export the splats as SPZ version 3, or as PLY", ToldCode::kForeignSplats},
    {kZipSignature, "a zip archive", kUnpack, ToldCode::kPacked},
    {"PK\x05\x06"sv, "an empty zip archive", "copy or export the file again"},
    {kGzip, "a gzip archive", kUnpack, ToldCode::kPacked},
    {"7z\xbc\xaf\x27\x1c"sv, "a 7z archive", kUnpack, ToldCode::kPacked},
    {"Rar!\x1a\x07"sv, "a RAR archive", kUnpack, ToldCode::kPacked},
    {"\xfd"
     "7zXZ\0"sv,
     "an xz archive", kUnpack, ToldCode::kPacked},
    {"BZh"sv, "a bzip2 archive", kUnpack, ToldCode::kPacked},
    {"\x28\xb5\x2f\xfd"sv, "a zstd archive", kUnpack, ToldCode::kPacked},
    {kOle, "a document of SolidWorks, Inventor, 3ds Max or an office program", "export the part as STL or 3MF",
     ToldCode::kForeignCad},
    {"<?xml"sv, "XML", kConvert},
    {"<!DOCTYPE html"sv, "a web page", "download the file itself", ToldCode::kWebPage},
    {"version https://git-lfs"sv, "a pointer of Git LFS, not the file", "get the file with 'git lfs pull'"},
};

constexpr std::string_view kObjKeywords[] = {"v", "vn", "vt", "vp", "f",      "l",      "p",
                                             "o", "g",  "s",  "mg", "mtllib", "usemtl", "usemap"};

class Probe {
 public:
  Probe(ByteInput& input, std::string_view window) : input_(input), window_(window) {}

  Expected<ScanFormat> format() {
    PLUMBLINE_TRY(refuse_foreign(foreign_content(window_, input_.size())));
    if (!has_size_of_stl()) PLUMBLINE_TRY(refuse_wide_text());  // its 80 bytes may hold any text
    if (window_.starts_with("\xef\xbb\xbf")) {
      input_.consume(3);
      window_.remove_prefix(3);
    }
    if (window_.starts_with("ply") &&
        (window_.size() == 3 || window_[3] == '\n' || window_[3] == '\r' || kBlanks(window_[3]))) {
      return ScanFormat::kPly;
    }
    if (window_.starts_with("LASF")) return ScanFormat::kLas;
    if (window_.starts_with(kE57Signature)) return ScanFormat::kE57;
    if (window_.starts_with("# .PCD")) return ScanFormat::kPcd;
    if (is_container()) PLUMBLINE_TRY(refuse_foreign(foreign_format(input_.name())));
    if (window_.starts_with(kGzip) && !is_archive_name())
      return ScanFormat::kSpz;  // or another gzip file, as its reader says
    if (is_3mf()) return ScanFormat::k3mf;
    PLUMBLINE_TRY(refuse_other_formats());
    if (is_stl()) return ScanFormat::kStl;
    if (is_off()) return ScanFormat::kOff;
    // Other text is what its name says.
    PLUMBLINE_TRY(refuse_foreign(foreign_format(input_.name())));

    if (is_ptx()) return ScanFormat::kPtx;
    std::string_view rest = window_;
    const auto line = next_line(rest);
    const auto word = LineWords(line, kBlanksAndCommas).next();
    if (word == "VERSION" || word == "FIELDS" || word == "COLUMNS") return ScanFormat::kPcd;
    const auto keyword = LineWords(line).next();
    if (std::find(std::begin(kObjKeywords), std::end(kObjKeywords), keyword) != std::end(kObjKeywords)) {
      return ScanFormat::kObj;
    }
    double number = 0;
    const char* stop = word.empty() ? nullptr : parse_real(word.data(), word.data() + word.size(), number);
    if (stop == word.data() + word.size() && stop != nullptr) return ScanFormat::kXyz;
    return by_name(line);
  }

 private:
  /// Refuses UTF-16 and UTF-32: a byte order mark or, without one, ASCII in every second byte.
  Status refuse_wide_text() const {
    const auto refuse = [&](const char* what) -> Status {
      PLUMBLINE_TRY(refuse_foreign(foreign_format(input_.name())));
      return telling(
          Told(ToldCode::kWideText, {}, input_.name()),
          input_.fail(ErrorCode::kUnsupported, "byte 0: the text is in %s;\tsave it as UTF-8 or ASCII", what));
    };
    if (window_.starts_with("\xff\xfe\0\0"sv) || window_.starts_with("\0\0\xfe\xff"sv)) return refuse("UTF-32");
    if (window_.starts_with("\xff\xfe") || window_.starts_with("\xfe\xff")) return refuse("UTF-16");
    const std::size_t pairs = std::min<std::size_t>(window_.size() / 2, 16);
    if (pairs < 4) return {};
    for (const std::size_t text : {0U, 1U}) {
      bool wide = true;
      for (std::size_t i = 0; i < pairs && wide; ++i) {
        const char letter = window_[2 * i + text];
        wide =
            window_[2 * i + 1 - text] == 0 && ((letter >= ' ' && letter <= '~') || (letter >= '\t' && letter <= '\r'));
      }
      if (wide) return refuse("UTF-16");
    }
    return {};
  }

  /// What many formats are packed in.
  bool is_container() const {
    return window_.starts_with(kGzip) || window_.starts_with(kZipSignature) || window_.starts_with(kOle);
  }

  Status refuse_foreign(const ForeignFormat* foreign) const {
    if (foreign == nullptr) return {};
    return telling(Told(foreign->kind.code, {}, input_.name()),
                   input_.fail(ErrorCode::kUnknownFormat, "%s (%s);\t%s", foreign->kind.what, foreign->program,
                               foreign->kind.advice));
  }

  Status refuse_other_formats() const {
    const auto refuse = [&](const Mark& mark) {
      return telling(Told(mark.code, {}, input_.name()),
                     input_.fail(ErrorCode::kUnknownFormat, "this is %s;\t%s", mark.what, mark.advice));
    };
    const bool archive = is_archive_name() && !has_ending(input_.name(), ".zip");
    if ((archive && window_.starts_with(kZipSignature)) || is_sliced_zip()) {
      constexpr const char* kSliced = "a print that is sliced already";
      if (is_archive_name()) return refuse({{}, kSliced, "print it, or check it"});
      return refuse({{}, kSliced, "give it the ending .sl1 to print it", ToldCode::kSlicedPrint});
    }
    for (const Mark& mark : kMarks) {
      if (window_.starts_with(mark.bytes)) return refuse(mark);
    }
    return {};
  }

  /// The name of a zip archive's first part, and what follows it; empty: it is none.
  std::string_view first_part() const {
    constexpr std::size_t kName = 30;  // bytes before it
    return window_.starts_with(kZipSignature) ? window_.substr(std::min(kName, window_.size())) : std::string_view();
  }

  /// A zip archive that begins with the settings, the thumbnails or a layer of a sliced print.
  bool is_sliced_zip() const {
    if (first_part().empty()) return false;
    const auto low = static_cast<unsigned char>(window_[26]), high = static_cast<unsigned char>(window_[27]);
    const std::size_t length = low + 256U * high;
    const auto name = first_part().substr(0, length);
    const bool is_layer = has_ending(name, ".png") && name.find('/') == std::string_view::npos;
    return is_layer || name == "config.ini" || name == "prusaslicer.ini" || name.starts_with("thumbnail/");
  }

  /// A zip archive whose name says so, or whose first part is one of a 3MF.
  bool is_3mf() const {
    const auto first = first_part();
    if (first.empty() || is_sliced_zip()) return false;
    return has_ending(input_.name(), ".3mf") || first.starts_with("3D/") || first.starts_with("_rels/") ||
           first.starts_with("[Content_Types]");
  }

  bool is_stl() const {
    if (has_ending(input_.name(), ".stl") && !is_other_text()) return true;
    std::string_view rest = window_;
    if (same_word(LineWords(next_line(rest)).next(), "solid")) {
      for (const std::string_view word : {"facet", "FACET", "endsolid", "ENDSOLID"}) {
        if (window_.find(word) != std::string_view::npos) return true;
      }
    }
    return has_size_of_stl();
  }

  /// Binary STL has no signature: 80 arbitrary bytes, the number of triangles, 50 bytes for each.
  bool has_size_of_stl() const {
    constexpr std::size_t kHead = 84;
    if (window_.size() < kHead || !input_.size()) return false;
    std::uint64_t triangles = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      triangles |= std::uint64_t{static_cast<unsigned char>(window_[80 + i])} << (8 * i);
    }
    return triangles > 0 && *input_.size() == kHead + 50 * triangles;
  }

  /// Text without a facet is no STL, whatever it is called.
  bool is_other_text() const {
    std::string_view rest = window_;
    if (same_word(LineWords(next_line(rest)).next(), "solid")) return false;
    for (const std::string_view part : {"\0"sv, "facet"sv, "FACET"sv}) {
      if (window_.find(part) != std::string_view::npos) return false;
    }
    return window_.size() > 84;
  }

  /// 4OFF and nOFF have other dimensions than three. The word may be missing, or stick to the number after it.
  bool is_off() const {
    std::string_view rest = window_;
    const auto first = LineWords(next_line(rest)).next();
    for (const std::string_view off : {"OFF", "COFF", "NOFF", "CNOFF", "STOFF", "STCOFF", "STNOFF", "STCNOFF"}) {
      if (first.starts_with(off) && (first.size() == off.size() || parse_count(first.substr(off.size())))) return true;
    }
    return has_ending(input_.name(), ".off") && (same_word(first, "OFF") || parse_count(first));
  }

  /// Takes the next line that is neither empty nor a comment; empty if there is none.
  static std::string_view next_line(std::string_view& rest) {
    while (!rest.empty()) {
      const std::size_t end = std::min(rest.find_first_of("\r\n"), rest.size());
      const auto line = rest.substr(0, end);
      const auto word = LineWords(line).next();
      rest.remove_prefix(std::min(end + 1, rest.size()));
      if (!word.empty() && !word.starts_with('#') && !word.starts_with("//") && !word.starts_with(';')) return line;
    }
    return {};
  }

  /// A PTX begins with two whole numbers, the columns and rows of its first scan, a PTS with one, or with several if its first blocks
  /// are empty. Then the lines of three and of four numbers that follow in a PTX tell them apart.
  bool is_ptx() const {
    std::string_view rest = window_;
    bool is_empty = false;
    for (int line = 0; line < 2; ++line) {
      LineWords words(next_line(rest));
      const auto count = parse_count(words.next());
      if (!count || !words.next().empty()) return false;
      is_empty = is_empty || (line == 0 && *count == 0);
    }
    for (int line = 0; is_empty && line < 8; ++line) {
      LineWords words(next_line(rest));
      for (int word = 0; word < (line < 4 ? 3 : 4); ++word) {
        if (words.next().empty()) return false;
      }
      if (!words.next().empty()) return false;
    }
    return true;
  }

  bool is_archive_name() const {
    return std::any_of(kArchiveEndings.begin(), kArchiveEndings.end(),
                       [this](std::string_view ending) { return has_ending(input_.name(), ending); });
  }

  Expected<ScanFormat> by_name(std::string_view line) const {
    const bool is_text = window_.find('\0') == std::string_view::npos;
    if (is_text && has_ending(input_.name(), ".obj")) return ScanFormat::kObj;
    if (is_text && has_ending(input_.name(), ".pcd")) return ScanFormat::kPcd;
    for (const std::string_view ending : kXyzEndings) {
      if (is_text && has_ending(input_.name(), ending)) return ScanFormat::kXyz;
    }
    if (is_archive_name()) {
      return input_.fail(ErrorCode::kMalformed, "is not a zip archive, or is damaged;\tcopy or export it again");
    }
    return input_.fail(ErrorCode::kUnknownFormat,
                       "byte 0: expected a scan in PLY, XYZ, PTS, PTX, LAS, E57, SPZ, PCD or OBJ, or a mesh in STL, "
                       "OBJ, PLY, OFF or 3MF, found "
                       "'%s';\t%s",
                       Quote(line.empty() ? window_ : line).c_str(), kConvert);
  }

  ByteInput& input_;
  std::string_view window_;
};

}  // namespace

Expected<ScanFormat> probe_format(ByteInput& input) {
  const auto size = input.fill(input.capacity());
  PLUMBLINE_TRY(size);
  if (*size == 0) {
    return telling(Told(ToldCode::kFileEmpty),
                   input.fail(ErrorCode::kNoPoints, "the file is empty (0 bytes);\tcopy or export the scan again"));
  }
  return Probe(input, {input.begin(), *size}).format();
}

const char* to_string(ScanFormat format) {
  switch (format) {
    case ScanFormat::kPly: return "PLY";
    case ScanFormat::kXyz: return "XYZ";
    case ScanFormat::kPcd: return "PCD";
    case ScanFormat::kObj: return "OBJ";
    case ScanFormat::kStl: return "STL";
    case ScanFormat::kOff: return "OFF";
    case ScanFormat::k3mf: return "3MF";
    case ScanFormat::kLas: return "LAS";
    case ScanFormat::kPtx: return "PTX";
    case ScanFormat::kE57: return "E57";
    case ScanFormat::kSpz: return "SPZ";
  }
  return "unknown";
}

}  // namespace plumbline::inline slicer
