/// Reads tables in the spellings of many programs. Each is read exactly or refused, never mirrored, swapped or scaled.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <random>

#include "tests/slicer/reader/scan_fixture.hpp"

namespace plumbline::testing {
namespace table_sweep_test {

using ::testing::HasSubstr;

struct Names {
  const char* x;
  const char* y;
  const char* z;
};
constexpr Names kSpellings[] = {{"x", "y", "z"},
                                {"X", "Y", "Z"},
                                {"Easting", "Northing", "Elevation"},
                                {"EASTING", "NORTHING", "ELEV"},
                                {"E", "N", "Z"},
                                {"E", "N", "H"},
                                {"East", "North", "Up"},
                                {"East", "North", "Height"},
                                {"Rechtswert", "Hochwert", "Hoehe"},
                                {"Rechtswert", "Hochwert", "H\xc3\xb6he"},
                                {"RECHTSWERT", "HOCHWERT", "H\xc3\x96HE"},
                                {"Rechtswert", "Hochwert", "H\xf6he"},
                                {"Ostwert", "Nordwert", "H"},
                                {"Ost", "Nord", "H\xc3\xb6he"},
                                {"RW", "HW", "Z"},
                                {"Est", "Nord", "Altitude"},
                                {"Este", "Norte", "Cota"},
                                {"Points:0", "Points:1", "Points:2"},
                                {"Points_0", "Points_1", "Points_2"},
                                {"coordinates:0", "coordinates:1", "coordinates:2"},
                                {"Points_X", "Points_Y", "Points_Z"},
                                {"POINT_X", "POINT_Y", "POINT_Z"},
                                {"CoordX", "CoordY", "CoordZ"},
                                {"coord_x", "coord_y", "coord_z"},
                                {"XCoord", "YCoord", "ZCoord"},
                                {"x_coord", "y_coord", "z_coord"},
                                {"X-Coordinate", "Y-Coordinate", "Z-Coordinate"},
                                {"X-Koordinate", "Y-Koordinate", "Z-Koordinate"},
                                {"pos_x", "pos_y", "pos_z"},
                                {"PosX", "PosY", "PosZ"},
                                {"pos.x", "pos.y", "pos.z"},
                                {"posx", "posy", "posz"},
                                {"Position.X", "Position.Y", "Position.Z"},
                                {"positionX", "positionY", "positionZ"},
                                {"position[0]", "position[1]", "position[2]"},
                                {"Position(X)", "Position(Y)", "Position(Z)"},
                                {"x_pos", "y_pos", "z_pos"},
                                {"world_x", "world_y", "world_z"},
                                {"X_World", "Y_World", "Z_World"},
                                {"location_x", "location_y", "location_z"},
                                {"xyz[0]", "xyz[1]", "xyz[2]"},
                                {"X-Wert", "Y-Wert", "Z-Wert"},
                                {"vertex.x", "vertex.y", "vertex.z"},
                                {"Oost", "Noord", "Hoogte"},
                                {"x", "y", "height"},
                                {"X", "Y", "Elevation"}};
constexpr const char* kOthers[] = {"scalars", "intensity", "time",  "R",  "Temperature",
                                   "quality", "pixel_x",   "index", "dx", "error"};
constexpr const char* kTexts[] = {"Name", "Label", "Point", "Code", "Punktnummer"};
struct UnitName {
  const char* name;
  double mm;
};
constexpr UnitName kUnits[] = {{"mm", 1}, {"cm", 10}, {"m", 1000}, {"inch", 25.4}, {"Meter", 1000}};

/// A table and what it says.
class Table {
 public:
  explicit Table(unsigned seed) : random_(seed) {}

  int upto(int most) { return static_cast<int>(random_() % static_cast<unsigned>(most + 1)); }
  bool one_in(int n) { return upto(n - 1) == 0; }

  void make() {
    between_ = (const char*[]){",", ";", "\t", "|", " ", "   ", ", ", " ; "}[upto(7)];
    is_blank_ = between_[0] == ' ' && between_[1] != ';';
    has_decimal_commas_ = !is_comma() && one_in(4);
    quotes_ = one_in(5);
    exponent_ = upto(5);
    end_ = (const char*[]){"\n", "\n", "\r\n", "\r"}[upto(3)];
    const auto& names = kSpellings[static_cast<std::size_t>(upto(std::size(kSpellings) - 1))];
    int order[] = {0, 1, 2};
    std::shuffle(std::begin(order), std::end(order), random_);
    const int before = upto(2), between = one_in(3) ? 1 : 0, after = upto(2);
    for (int i = 0; i < before; ++i) add_other();
    for (const int axis : order) {
      columns_.push_back({axis, axis == 0 ? names.x : axis == 1 ? names.y : names.z});
      if (axis == order[0] && between > 0) add_other();
    }
    for (int i = 0; i < after; ++i) add_other();
    if (one_in(8)) text_ += "\xef\xbb\xbf";
    if (one_in(6)) line("# made by a program");
    unit_ = one_in(2) ? nullptr : &kUnits[static_cast<std::size_t>(upto(std::size(kUnits) - 1))];
    unit_style_ = upto(is_blank_ ? 3 : 4);
    heading();
    const int rows = 1 + upto(90);
    for (int i = 0; i < rows; ++i) row(i);
    if (one_in(3)) text_.erase(text_.size() - std::string_view(end_).size());
  }

  const std::string& text() const { return text_; }
  const std::vector<ScanPoint>& points() const { return points_; }
  std::uint64_t missing() const { return missing_; }
  bool has_unit() const { return unit_ != nullptr; }

 private:
  struct Column {
    int axis;  ///< 3: a number, 4: text
    std::string name;
  };

  bool is_comma() const { return between_[0] == ','; }
  void line(const std::string& text) { text_ += text + end_; }
  void add_other() {
    const bool is_text = one_in(2);
    columns_.push_back(
        {is_text ? 4 : 3, is_text ? kTexts[upto(std::size(kTexts) - 1)] : kOthers[upto(std::size(kOthers) - 1)]});
  }
  std::string joined(const std::vector<std::string>& cells) const {
    std::string out;
    for (const auto& cell : cells) out += (out.empty() && &cell == cells.data() ? "" : between_) + cell;
    return out;
  }

  void heading() {
    std::vector<std::string> cells, units;
    const bool has_bracket = columns_.front().name.find_first_of("[(") != std::string::npos;
    for (const Column& column : columns_) {
      std::string name = column.name;
      units.push_back(unit_ != nullptr && column.axis < 3 ? unit_->name : "-");
      if (unit_ != nullptr && column.axis < 3) {
        if (name.find_first_of("[(") != std::string::npos || has_bracket) {
          unit_style_ = 3;
        }
        if (unit_style_ == 0) name += std::string("(") + unit_->name + ")";
        if (unit_style_ == 1) name += std::string(is_blank_ ? "[" : " [") + unit_->name + "]";
        if (unit_style_ == 2) name += std::string("_") + unit_->name;
        if (unit_style_ == 4) name += std::string(" / ") + unit_->name;
      }
      cells.push_back(quotes_ ? '"' + name + '"' : name);
    }
    const char* const mark = unit_style_ != 3 && one_in(4) ? (const char*[]){"#", "# ", "//"}[upto(2)] : "";
    line(mark + joined(cells));
    if (unit_ != nullptr && unit_style_ == 3) line(joined(units));
  }

  std::string number(double& value, bool is_wide) {
    char text[64];
    std::snprintf(text, sizeof text, exponent_ == 0 ? "%.6E" : exponent_ == 1 ? "%.9g" : "%.4f", value);
    std::string out = text;
    value = std::strtod(text, nullptr);
    if (exponent_ == 0 && is_wide) std::replace(out.begin(), out.end(), 'E', 'D');
    if (has_decimal_commas_) std::replace(out.begin(), out.end(), '.', ',');
    return quotes_ ? '"' + out + '"' : out;
  }

  void row(int i) {
    std::vector<std::string> cells;
    double at[3] = {};
    bool lacks = false;
    for (const Column& column : columns_) {
      double value = std::uniform_real_distribution<double>(-200, 200)(random_);
      if (column.axis == 4) {
        const std::string label = "P" + std::to_string(i);
        cells.push_back(one_in(4) ? "\"a" + std::string(between_) + "b\"" : label);
        continue;
      }
      if (column.axis < 3 && i > 0 && one_in(40)) {
        cells.push_back((const char*[]){"NA", "nan", "NaN", "N/A", "null"}[upto(4)]);
        lacks = true;
        continue;
      }
      cells.push_back(number(value, one_in(2)));
      if (column.axis < 3) at[column.axis] = value * (unit_ != nullptr ? unit_->mm : 1);
    }
    line(joined(cells));
    if (lacks) {
      ++missing_;
    } else {
      points_.push_back({at[0], at[1], at[2], 0, 0, 0});
    }
    if (one_in(30)) line("");
    if (one_in(40)) line("# a, b; c");
  }

  std::mt19937 random_;
  std::string text_;
  const char* between_ = ",";
  const char* end_ = "\n";
  bool is_blank_ = false;
  bool has_decimal_commas_ = false;
  bool quotes_ = false;
  int exponent_ = 0;
  int unit_style_ = 0;
  const UnitName* unit_ = nullptr;
  std::vector<Column> columns_;
  std::vector<ScanPoint> points_;
  std::uint64_t missing_ = 0;
};

TEST(TableSweep, ReadsEachTableExactlyOrRefusesIt) {
  constexpr unsigned kTables = 1500;
  int exact = 0, refused = 0;
  for (unsigned seed = 1; seed <= kTables; ++seed) {
    Table table(seed);
    table.make();
    auto reading = read(table.text(), "table.csv");
    if (!reading.summary) {
      ++refused;
      if (std::getenv("PLUMBLINE_SHOW_REFUSED") != nullptr) {
        std::printf("%u: %s\n%.200s\n\n", seed, reading.message().c_str(), table.text().c_str());
      }
      EXPECT_THAT(reading.message(), HasSubstr("table.csv: line ")) << table.text().substr(0, 300);
      continue;
    }
    ++exact;
    EXPECT_TRUE(same_points(reading.points(), table.points())) << seed << '\n' << table.text().substr(0, 300);
    EXPECT_EQ(reading.summary->not_finite, table.missing()) << seed;
    EXPECT_EQ(reading.summary->header.is_in_mm, table.has_unit()) << seed;
  }
  std::printf("%d read exactly, %d refused\n", exact, refused);
  EXPECT_GE(exact, kTables * 95 / 100);
}

/// The heading that an error proposes.
std::string proposed_in(const std::string& message) {
  const std::string_view mark = "such as ";
  const std::size_t at = message.find(mark);
  return at == std::string::npos
             ? ""
             : message.substr(at + mark.size(), message.find(' ', at + mark.size()) - at - mark.size());
}

TEST(TableSweep, ProposesAHeadingThatWorks) {
  const std::pair<const char*, const char*> kFiles[] = {
      {"foo,bar,baz\n", "1.5,2.5,3.5\n"},
      {"foo bar baz\n", "1.5 2.5 3.5\n"},
      {"a;b;c;d\n", "1,5;2,5;3,5;4\n"},
      {"Punkt;a;b;c\n", "P1;1,5;2,5;3,5\n"},
      {"# u,v,w\n", "1.5,2.5,3.5\n"},
      {"x,y,depth\n", "1.5,2.5,3.5\n"},
      {"Easting,Northing,Down\n", "1.5,2.5,3.5\n"},
      {"latitude,longitude,altitude\n", "1.5,2.5,3.5\n"},
      {"x,y,z,X,Y,Z\n", "1.5,2.5,3.5,4,5,6\n"},
      {"x [px],y [px],z [px]\n", "1.5,2.5,3.5\n"},
      {"x [m],y,z\n", "1.5,2.5,3.5\n"},
      {"x y z\n", "1.5 2.5 3.5 4.5\n"},  // as R writes it, the first column has no name
      {"y,x,z\n", "1.5,2.5,3.5,4.5\n"},
      {"x,y,z\n", "1,5,2,5,3,5\n"},
      {"My scan\n", "1.5 2.5 3.5\n"},
      {"", "P1 1.5 2.5 3.5\n"},
      {"", "P1,1.5,2.5,3.5\n"},
  };
  for (const auto& [heading, row] : kFiles) {
    const std::string table = std::string(heading) + row + row;
    const auto reading = read(table, "table.csv");
    ASSERT_FALSE(reading.summary.has_value()) << table;
    const std::string line = proposed_in(reading.message());
    ASSERT_NE(line, "") << reading.message();
    const bool is_comment = table.front() == '#';
    const auto again =
        read(is_comment ? std::string(heading) + line + '\n' + row + row : line + '\n' + table, "table.csv");
    ASSERT_TRUE(again.summary.has_value()) << line << '\n' << table << again.message();
    EXPECT_EQ(again.summary->points, 2U) << line << '\n' << table;
  }
}

TEST(TableSweep, AsksWhetherLeadingWholeNumbersCount) {
  std::string grid, id, floats;
  for (int i = 0; i < 40; ++i) {
    const std::string xyz = std::to_string(i) + ".5 " + std::to_string(i) + ".25 0.125\n";
    grid += std::to_string(i / 7) + ' ' + std::to_string(i % 7) + ' ' + xyz;
    id += "3 " + xyz;
    floats += "3.0 " + xyz;
  }
  for (const auto& [table, heading, counters] : {std::tuple(grid, "row,col,x,y,z", 2), std::tuple(id, "id,x,y,z", 1)}) {
    const auto reading = read(table, "scan.xyz");
    EXPECT_EQ(reading.code(), ErrorCode::kUnsupported);
    EXPECT_EQ(proposed_in(reading.message()), heading);
    auto named = read(std::string(heading) + '\n' + table, "scan.xyz");
    ASSERT_TRUE(named.summary.has_value()) << named.message();
    EXPECT_TRUE(same_point(named.points()[3], {3.5, 3.25, 0.125, 0, 0, 0}));
    auto plain = read((counters == 2 ? "x,y,z,-,-\n" : "x,y,z,-\n") + table, "scan.xyz");
    ASSERT_TRUE(plain.summary.has_value()) << plain.message();
    EXPECT_TRUE(same_point(plain.points()[3],
                           counters == 2 ? ScanPoint{0, 3, 3.5, 0, 0, 0} : ScanPoint{3, 3.5, 3.25, 0, 0, 0}));
  }
  EXPECT_TRUE(read(floats).summary.has_value());
}

TEST(TableSweep, KeepsTheHandOfSurveyedTables) {
  auto reading = read("Northing,Easting,Elevation\n1,2,3\n", "nez.csv");
  ASSERT_TRUE(reading.summary.has_value()) << reading.message();
  EXPECT_TRUE(same_points(reading.points(), {{2, 1, 3, 0, 0, 0}}));
  reading = read("X (North);Y (East);Z\n1;2;3\n", "gk.csv");
  ASSERT_TRUE(reading.summary.has_value()) << reading.message();
  EXPECT_TRUE(same_points(reading.points(), {{2, 1, 3, 0, 0, 0}}));
}

}  // namespace table_sweep_test
}  // namespace plumbline::testing
