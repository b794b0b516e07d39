#include "hal/sim/plant.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <random>
#include <sstream>

#include "hal/sim/sim_machine.hpp"
#include "tests/hal/small_print.hpp"

namespace plumbline {
namespace {

using namespace std::chrono_literals;
using testing::IsEmpty;
using testing::SizeIs;

PlantSettings small_printer() {
  PlantSettings settings;
  settings.panel.columns = 100;
  settings.panel.rows = 60;
  settings.panel.pitch_x_mm = settings.panel.pitch_y_mm = 0.5;
  return settings;
}

std::vector<std::string> objections_of(const Plant& plant) {
  std::vector<std::string> texts;
  for (const Objection& objection : plant.objections()) texts.push_back(to_string(objection));
  return texts;
}

std::vector<Fault> faults(std::initializer_list<const char*> texts) {
  std::vector<Fault> all;
  for (const char* text : texts) all.push_back(parse_fault(text).value());
  return all;
}

void draw_random(std::uint32_t layer, BitImage image) {
  std::mt19937_64 random(layer);
  for (std::uint32_t row = 0; row < image.rows(); ++row) {
    for (auto& word : image.row(row)) word = random() & random();
    image.row(row).back() &= image.last_word_mask();
  }
}

TEST(Plant, HasNoObjectionToACarefulPrintAndKeepsWhatItCured) {
  Plant plant(small_printer());
  SimMachine machine(plant);
  const auto printed = print_layers(machine.machine(), {.layers = 20, .draw = draw_random});
  ASSERT_TRUE(printed) << printed.error().message();
  plant.conclude(JobEnd::kFinished);
  EXPECT_THAT(objections_of(plant), IsEmpty());
  ASSERT_THAT(plant.part().layers(), SizeIs(20));
  std::uint32_t k = 0;
  std::vector<std::uint64_t> words(BitImage::words_needed(100, 60));
  const BitImage expected(words, 100, 60);
  plant.part().for_each_layer([&](const CuredLayer& layer, ConstBitImage image) {
    draw_random(k, expected);
    EXPECT_TRUE(std::equal(words.begin(), words.end(), image.words().begin())) << k;
    EXPECT_EQ(layer.z, ZPosition(50_um * (k + 1)));
    EXPECT_EQ(layer.pixels, expected.count());
    EXPECT_NEAR(layer.dose.value(), 7.5, 7.5e-6);
    EXPECT_NEAR(layer.depth_mm, 0.11 * std::log(7.5 / 2.4), 1e-6);
    ++k;
  });
  EXPECT_EQ(k, 20U);
}

TEST(Plant, IsTheSameEveryTime) {
  std::vector<std::string> runs;
  for (int run = 0; run < 2; ++run) {
    PlantSettings settings = small_printer();
    settings.faults = faults({"lamp.flickers@layer=2", "stage.skips@layer=3,by=0.01"});
    Plant plant(settings);
    SimMachine machine(plant);
    ASSERT_TRUE(print_layers(machine.machine(), {.layers = 6, .draw = draw_random}));
    plant.conclude(JobEnd::kFinished);
    std::ostringstream all;
    all << plant.now().time_since_epoch().count();
    for (const auto& objection : objections_of(plant)) all << '\n' << objection;
    for (const auto& light : plant.lights()) all << '\n' << std::hexfloat << light.dose.value();
    runs.push_back(all.str());
  }
  EXPECT_EQ(runs[0], runs[1]);
  EXPECT_THAT(runs[0], testing::HasSubstr("dose off"));
}

}  // namespace
}  // namespace plumbline
