// cured_layers FOLDER MESH KEY=VALUE...: how far what a stack of PNG layers cures lies from a mesh, whoever has made the layers.
//
// The layers are the folder's PNG files in the order of their names, 8 bits grey: the share of the dose. All get the same dose. The mesh stands at
// x, y, z, mm from the corner of pixel (0, 0) and from the plate. Nothing falls: a layer may hang in the air.
// Keys and defaults: pitch=0.05 layer=0.05 (mm) x=0 y=0 z=0 (mm) dp=0.12 (mm) ec=3.2 dose=8.75 (mJ/cm2) exchange=0 blur=0.5 (pixels)
// Prints a line of JSON, um: as part.deviation_um of a print's report.

#include <lodepng.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "firmware/machine/part_figures.hpp"
#include "firmware/print/truth/truth_mesh.hpp"
#include "hal/sim/part/deviation.hpp"

namespace {

using namespace plumbline;
namespace fs = std::filesystem;

[[noreturn]] void give_up(const std::string& why) {
  std::fprintf(stderr, "cured_layers: %s\n", why.c_str());
  std::exit(1);
}

std::map<std::string, double> values_of(int argc, char** argv) {
  std::map<std::string, double> values = {{"pitch", 0.05}, {"layer", 0.05}, {"x", 0},    {"y", 0},
                                          {"z", 0},        {"dp", 0.12},    {"ec", 3.2}, {"dose", 8.75},
                                          {"exchange", 0}, {"blur", 0.5}};
  for (int i = 3; i < argc; ++i) {
    const std::string text = argv[i];
    const auto at = text.find('=');
    const auto found = values.find(text.substr(0, at));
    if (at == std::string::npos || found == values.end()) give_up(text + " is none of its keys");
    found->second = std::atof(text.c_str() + at + 1);
  }
  return values;
}

/// A layer as a mask and its grey pixels.
void add_layer(const std::vector<unsigned char>& grey, ZPosition z, double dose, const Resin& resin, CuredPart& part) {
  const std::uint32_t columns = part.columns(), rows = part.rows();
  std::vector<std::uint64_t> words(BitImage::words_needed(columns, rows));
  std::vector<GreyRun> room(grey.size());
  const BitImage mask(words, columns, rows);
  GreyRuns greys(room, columns);
  for (std::uint32_t r = 0; r < rows; ++r) {
    for (std::uint32_t c = 0; c < columns; ++c) {
      const std::uint32_t pixel = r * columns + c;
      if (grey[pixel] >= kLeastCuringLevel) mask.set(c, r);
      if (is_grey(grey[pixel])) greys.add(pixel, grey[pixel]);
    }
  }
  part.expose(z, mask, {}, {}, Dose(dose), Dose(dose), resin, greys.runs());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) give_up("a folder and a mesh are needed");
  const auto values = values_of(argc, argv);
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(argv[1])) {
    if (entry.path().extension() == ".png") files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());
  if (files.empty()) give_up(std::string(argv[1]) + " has no PNG files");
  const auto mesh = firmware::TruthMesh::read(argv[2]);
  if (!mesh) give_up(mesh.error().message());

  const Resin resin{.critical = Dose(values.at("ec")),
                    .penetration_mm = values.at("dp"),
                    .exchange = values.at("exchange"),
                    .blur_px = values.at("blur")};
  const double pitch = values.at("pitch");
  std::vector<CuredPart> part;
  for (std::size_t k = 0; k < files.size(); ++k) {
    std::vector<unsigned char> grey;
    unsigned columns = 0, rows = 0;
    if (lodepng::decode(grey, columns, rows, files[k], LCT_GREY, 8) != 0) give_up(files[k] + " is no PNG file");
    if (part.empty()) {
      part.emplace_back(columns, rows, pitch, pitch,
                        PeelSettings{.traction_kpa = 0, .line_force_n_mm = 0, .suction_kpa = 0}, true);
    }
    if (columns != part[0].columns() || rows != part[0].rows()) give_up(files[k] + " has another size");
    const double z_mm = static_cast<double>(k + 1) * values.at("layer");
    add_layer(grey, ZPosition(Distance::millimetres(z_mm)), values.at("dose"), resin, part[0]);
  }
  Placement placement;
  placement.shift = {values.at("x"), values.at("y"), values.at("z")};
  const auto surface = mesh->surface(placement);
  const DoseModel model{.resin = resin, .pitch_x_mm = pitch, .pitch_y_mm = pitch};
  const auto f =
      firmware::deviation_figures(surface.name, surface.points, deviations_mm(part[0], model, surface.points));
  const auto number = [](const char* name, double value) {
    if (std::isfinite(value)) std::printf(", \"%s\": %.2f", name, value);
  };
  std::printf("{\"points\": %llu, \"missing\": %llu", static_cast<unsigned long long>(f.points),
              static_cast<unsigned long long>(f.missing));
  number("rms", f.rms);
  number("down_mean", f.down_mean);
  number("down_rms", f.down_rms);
  number("wall_mean", f.wall_mean);
  number("wall_rms", f.wall_rms);
  number("top_rms", f.top_rms);
  std::printf("}\n");
  return 0;
}
