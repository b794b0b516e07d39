#include "slicer/reader/formats/tables/table_heading.hpp"

#include <algorithm>
#include <array>
#include <span>

#include "slicer/reader/stream/words.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr std::size_t kNone = TableHeading::kNoColumn;

/// What stands before or behind the letter of a coordinate.
constexpr std::string_view kAffixes[] = {"coordinates", "coordinate", "coords",   "coord", "koordinaten", "koordinate",
                                         "koord",       "positions",  "position", "pos",   "points",      "point",
                                         "vertex",      "location",   "loc",      "world", "global",      "local",
                                         "cartesian",   "value",      "wert"};

/// Names of x, y and z that belong together. Where z is empty, it has one of kUp.
struct Axes {
  std::string_view x, y, z = {};
};
constexpr Axes kAxes[] = {
    {"x", "y"},
    {"points0", "points1", "points2"},
    {"coords0", "coords1", "coords2"},
    {"coordinates0", "coordinates1", "coordinates2"},
    {"positions0", "positions1", "positions2"},
    {"position0", "position1", "position2"},
    {"coord0", "coord1", "coord2"},
    {"pos0", "pos1", "pos2"},
    {"xyz0", "xyz1", "xyz2"},
    {"easting", "northing"},
    {"eastings", "northings"},
    {"east", "north"},
    {"e", "n", "u"},
    {"east", "north", "up"},
    {"e", "n"},
    {"rechts", "hoch"},
    {"rw", "hw"},
    {"ost", "nord"},
    {"est", "nord"},
    {"est", "norte"},
    {"este", "norte"},
    {"leste", "norte"},
    {"oost", "noord"},
};
constexpr std::string_view kUp[] = {"z",   "elevation", "elev",   "height", "hoehe", "altitude",
                                    "alt", "h",         "altura", "cota",   "quota", "hoogte"};
constexpr std::string_view kNormals[][3] = {{"nx", "ny", "nz"},
                                            {"normalx", "normaly", "normalz"},
                                            {"normalsx", "normalsy", "normalsz"},
                                            {"normal0", "normal1", "normal2"},
                                            {"normals0", "normals1", "normals2"}};
constexpr std::string_view kAngles[] = {"lat",       "latitude", "lon",   "long", "lng",
                                        "longitude", "azimuth",  "theta", "phi"};
constexpr std::string_view kDown[] = {"depth", "down", "tiefe", "teufe", "profondeur", "profundidad"};

struct Unit {
  std::string_view name;
  double mm;
};
constexpr Unit kUnits[] = {
    {"mm", 1},           {"millimeter", 1},   {"millimeters", 1},
    {"millimetre", 1},   {"millimetres", 1},  {"cm", 10},
    {"centimeter", 10},  {"centimeters", 10}, {"centimetre", 10},
    {"centimetres", 10}, {"m", 1000},         {"meter", 1000},
    {"meters", 1000},    {"metre", 1000},     {"metres", 1000},
    {"dm", 100},         {"km", 1e6},         {"um", 1e-3},
    {"micron", 1e-3},    {"microns", 1e-3},   {"micrometer", 1e-3},
    {"nm", 1e-6},        {"in", 25.4},        {"inch", 25.4},
    {"inches", 25.4},    {"ft", 304.8},       {"feet", 304.8},
    {"foot", 304.8},
};
/// In brackets behind a name; a coordinate in one of these is no length.
constexpr std::string_view kNotLengths[] = {"px",  "pixel", "pixels", "deg",   "degree", "degrees",
                                            "rad", "gon",   "grad",   "voxel", "voxels"};

constexpr const char* kUnnamed = "does not say which columns are x, y and z";

/// A name in lower case, without what is neither a letter nor a digit.
class Key {
 public:
  explicit Key(std::string_view name) {
    for (std::size_t i = 0; i < name.size() && size_ + 2 <= text_.size(); ++i) {
      const auto byte = static_cast<unsigned char>(name[i]);
      const char c = lower_letter(name[i]);
      const bool is_utf8 = byte == 0xc3 && i + 1 < name.size();
      const unsigned latin = is_utf8 ? static_cast<unsigned char>(name[++i]) + 0x40U : byte;
      if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')) {
        text_[size_++] = c;
      } else if (latin == 0xf6 || latin == 0xd6) {  // o with two dots
        text_[size_++] = 'o';
        text_[size_++] = 'e';
      } else if (latin == 0xb5 || (byte == 0xbc && i > 0 && name[i - 1] == '\xce')) {  // micro, Greek mu
        text_[size_++] = 'u';
      } else if (byte >= 0x80) {
        text_[size_++] = '?';  // another letter
      }
    }
  }
  std::string_view view() const { return {text_.data(), size_}; }
  /// Without affixes around a single letter or a word.
  std::string_view stem() const {
    auto stem = view();
    for (bool changed = true; changed;) {
      changed = false;
      for (const std::string_view affix : kAffixes) {
        if (stem.size() <= affix.size()) continue;
        if (stem.starts_with(affix) && stem[affix.size()] > '9') {
          stem.remove_prefix(affix.size());
        } else if (stem.ends_with(affix)) {
          stem.remove_suffix(affix.size());
        } else {
          continue;
        }
        changed = true;
      }
    }
    return stem;
  }

 private:
  std::array<char, 32> text_;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  std::size_t size_ = 0;
};

bool is_one_of(std::string_view key, std::span<const std::string_view> names) {
  return std::find(names.begin(), names.end(), key) != names.end();
}

double unit_of(std::string_view name) {
  const Key key(name);
  for (const Unit& unit : kUnits) {
    if (key.view() == unit.name) return unit.mm;
  }
  return 0;
}

bool is_direction(std::string_view key) {
  const auto says = [key](const Axes& axes) {
    return axes.z.empty() && axes.x != "x" && (key == axes.x || key == axes.y);
  };
  return std::any_of(std::begin(kAxes), std::end(kAxes), says);
}

/// The name of a column.
struct ColumnName {
  explicit ColumnName(std::string_view text) : whole(text), name(text) {
    const std::size_t bracket = text.find_first_of("([{<");
    if (bracket != std::string_view::npos && bracket > 0) {
      const auto inside = text.substr(bracket + 1, text.find_first_of(")]}>", bracket) - bracket - 1);
      mm = unit_of(inside);
      const Key key(inside);
      is_no_length = is_one_of(key.view(), kNotLengths);
      name = is_direction(key.stem()) ? key : Key(text.substr(0, bracket));  // "X (North)" is a northing
      return;
    }
    // "x_mm", "x / mm" and "x mm"; "x_in" may be anything.
    const std::size_t end = text.find_last_of(" _/.-");
    if (end == std::string_view::npos || end == 0) return;
    const auto unit = text.substr(end + 1);
    mm = same_word(unit, "in") ? 0 : unit_of(unit);
    if (mm > 0) name = Key(text.substr(0, end));
  }
  bool is(std::string_view known) const {
    return name.stem() == known || name.view() == known || whole.view() == known || whole.stem() == known;
  }

  Key whole;
  Key name;
  double mm = 0;  ///< of its unit; 0: it has none
  bool is_no_length = false;
};

class HeadingNames {
 public:
  HeadingNames(std::string_view line, char between) : line_(line), between_(between) {}

  TableHeading parse() {
    heading_.columns.fill(kNone);
    heading_.names = count_cells(line_, between_);
    heading_.problem = kUnnamed;
    for (const Axes& axes : kAxes) {
      is_doubled_ = false;
      const std::size_t x = find(axes.x);
      const std::size_t y = find(axes.y);
      if (x == kNone || y == kNone) continue;
      const std::size_t z = axes.z.empty() ? find_up() : find(axes.z);
      if (z == kNone) {
        if (any_of(kDown)) heading_.problem = "has a depth, which grows downwards, in place of a height";
        continue;
      }
      heading_.problem = is_doubled_ ? "has two columns of the same name" : nullptr;
      heading_.columns = {x, y, z, kNone, kNone, kNone};
      read_units();
      if (axes.z.empty() && axes.x != "x") return heading_;  // nx, ny, nz may not be those of north and east
      for (const auto& names : kNormals) {
        if (has_normals(names)) break;
      }
      return heading_;
    }
    if (any_of(kAngles)) heading_.problem = "has angles in place of coordinates";
    return heading_;
  }

 private:
  /// @param use  bool(column, name); returns whether to go on
  template <class Use>
  void for_each_name(Use use) const {
    RowCells cells(line_, between_);
    std::string_view cell;
    for (std::size_t column = 0; cells.next(cell); ++column) {
      if (!cell.empty() && !use(column, ColumnName(cell))) return;
    }
  }

  std::size_t find(std::string_view known) {
    std::size_t found = kNone;
    for_each_name([&](std::size_t column, const ColumnName& name) {
      if (!name.is(known)) return true;
      if (found != kNone) is_doubled_ = true;
      if (found == kNone) found = column;
      return true;
    });
    return found;
  }

  std::size_t find_up() {
    for (const std::string_view name : kUp) {
      if (const std::size_t found = find(name); found != kNone) return found;
    }
    return kNone;
  }

  bool any_of(std::span<const std::string_view> names) const {
    bool found = false;
    for_each_name([&](std::size_t, const ColumnName& name) {
      found = found || is_one_of(name.name.stem(), names);
      return !found;
    });
    return found;
  }

  bool has_normals(const std::string_view (&names)[3]) {
    std::array<std::size_t, 3> found;
    for (std::size_t axis = 0; axis < 3; ++axis) found[axis] = find(names[axis]);
    if (std::find(found.begin(), found.end(), kNone) != found.end()) return false;
    std::copy(found.begin(), found.end(), heading_.columns.begin() + kNx);
    return true;
  }

  void read_units() {
    std::size_t units = 0;
    for_each_name([&](std::size_t column, const ColumnName& name) {
      for (std::size_t slot = kX; slot <= kZ; ++slot) {
        if (heading_.columns[slot] != column) continue;
        heading_.mm[slot] = name.mm;
        if (name.mm > 0) ++units;
        if (name.is_no_length) heading_.problem = "gives coordinates in what is no length";
      }
      return true;
    });
    if (units != 0 && units != 3) heading_.problem = "has a unit for some coordinates only";
  }

  std::string_view line_;
  char between_;
  TableHeading heading_;
  bool is_doubled_ = false;
};

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && kBlanks(text.front())) text.remove_prefix(1);
  while (!text.empty() && kBlanks(text.back())) text.remove_suffix(1);
  return text;
}

}  // namespace

bool RowCells::next(std::string_view& cell) {
  if (ended_) return false;
  while (!rest_.empty() && kBlanks(rest_.front()) && rest_.front() != between_) rest_.remove_prefix(1);
  if (between_ == ' ') rest_ = trimmed(rest_);
  if (between_ == ' ' && rest_.empty()) return false;
  const auto is_end = [this](char c) { return between_ == ' ' ? kBlanks(c) : c == between_; };
  std::size_t end = 0;
  const bool is_quoted = !rest_.empty() && rest_.front() == '"';
  if (is_quoted) {
    end = rest_.find('"', 1);
    // "" is a quote within. A quote that is not closed goes on to the end.
    while (end < rest_.size() - 1 && rest_[end + 1] == '"') end = rest_.find('"', end + 2);
    end = std::min(end, rest_.size());
  }
  while (end < rest_.size() && !is_end(rest_[end])) ++end;
  // The unit in brackets belongs to the name: "X [mm] Y [mm]".
  constexpr std::string_view kOpen = "([";
  if (const std::size_t next = rest_.find_first_not_of(" \t", end);
      between_ == ' ' && next < rest_.size() && kOpen.find(rest_[next]) != std::string_view::npos &&
      kOpen.find(rest_.front()) == std::string_view::npos) {
    end = std::min(rest_.find_first_of(")]", next), rest_.size() - 1) + 1;
  }
  cell = trimmed(rest_.substr(0, end));
  if (is_quoted && cell.size() > 1 && cell.back() == '"') cell = trimmed(cell.substr(1, cell.size() - 2));
  ended_ = end == rest_.size();
  rest_.remove_prefix(std::min(end + 1, rest_.size()));
  return true;
}

std::size_t count_cells(std::string_view line, char between) {
  RowCells cells(line, between);
  std::string_view cell;
  std::size_t filled = 0;
  for (std::size_t count = 1; cells.next(cell); ++count) {
    if (!cell.empty()) filled = count;
  }
  return filled;
}

bool TableHeading::is_adjacent() const {
  const auto [low, high] = std::minmax({columns[kX], columns[kY], columns[kZ]});
  return high - low == 2;
}

TableHeading parse_heading(std::string_view line) {
  // A semicolon before others is an empty cell.
  const auto is_comment = [](std::string_view text) {
    constexpr std::string_view kMarks = "#/;%!*";
    return !text.empty() && kMarks.find(text.front()) != std::string_view::npos &&
           (text.front() != ';' || text.find(';', 1) == std::string_view::npos);
  };
  if (is_comment(trimmed(line))) line = trimmed(line);
  while (is_comment(line)) line.remove_prefix(1);
  TableHeading best;
  for (const char between : kCellSeparators) {
    if (between != ' ' && line.find(between) == std::string_view::npos) continue;
    const TableHeading heading = HeadingNames(line, between).parse();
    if (heading.is_understood()) return heading;
    if (best.names == 0 || best.problem == kUnnamed) best = heading;
  }
  return best;
}

void take_unit_line(std::string_view line, TableHeading& heading) {
  if (heading.has_units()) return;
  for (const char between : kCellSeparators) {
    if (count_cells(line, between) != heading.names) continue;
    std::array<double, 3> mm{};
    RowCells cells(line, between);
    std::string_view cell;
    for (std::size_t column = 0; cells.next(cell); ++column) {
      for (std::size_t slot = kX; slot <= kZ; ++slot) {
        if (heading.columns[slot] == column) mm[slot] = unit_of(cell);
      }
    }
    if (*std::min_element(mm.begin(), mm.end()) > 0) heading.mm = mm;
  }
}

}  // namespace plumbline::inline slicer
