#include "hal/sim/plant/plant.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <sstream>

#include "hal/sim/part/dose_field.hpp"
#include "hal/sim/sim_machine.hpp"
#include "tests/hal/sim/sim_fixture.hpp"
#include "tests/hal/small_print.hpp"

namespace plumbline {
namespace {

using namespace std::chrono_literals;
using testing::IsEmpty;
using testing::SizeIs;

TEST(Plant, AcceptsACarefulPrintAndKeepsThePart) {
  Plant plant(small_printer());
  SimMachine machine(plant);
  const auto printed = print_layers(machine.machine(), {.layers = 20, .draw = draw_random});
  ASSERT_TRUE(printed) << printed.error().message();
  plant.conclude(JobEnd::kFinished);
  EXPECT_THAT(texts_of(plant.objections()), IsEmpty());
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

TEST(Plant, LightsNothingThroughAMaskThatDidNotCome) {
  Plant plant(small_printer({"panel.flip_timeout@t=1s"}));
  SimMachine simulated(plant);
  const Machine machine = simulated.machine();
  const auto present = [&] {
    auto mask = machine.mask.lend();
    EXPECT_TRUE(mask);
    draw_random(1, mask->image());
    return machine.mask.present(std::move(*mask));
  };
  ASSERT_TRUE(present());
  plant.wait(2s);
  EXPECT_EQ(present().error().code(), ErrorCode::kFlipTimeout);
  EXPECT_FALSE(machine.mask.presented());
  EXPECT_EQ(machine.lamp.begin_exposure(1s).error().code(), ErrorCode::kMaskNotPresented);
  EXPECT_THAT(plant.lights(), IsEmpty());
}

TEST(Plant, RunsTheSameEveryTime) {
  std::vector<std::string> runs;
  for (int run = 0; run < 2; ++run) {
    Plant plant(small_printer({"lamp.flickers@layer=2", "stage.skips@layer=3,by=0.01"}));
    SimMachine machine(plant);
    ASSERT_TRUE(print_layers(machine.machine(), {.layers = 6, .draw = draw_random}));
    plant.conclude(JobEnd::kFinished);
    std::ostringstream all;
    all << plant.now().time_since_epoch().count();
    for (const auto& objection : texts_of(plant.objections())) all << '\n' << objection;
    for (const auto& light : plant.lights()) all << '\n' << std::hexfloat << light.dose.value();
    runs.push_back(all.str());
  }
  EXPECT_EQ(runs[0], runs[1]);
  EXPECT_THAT(runs[0], testing::HasSubstr("dose off"));
}

/// A minimal recovery after a power cut: it knows the layer, but not how much light the layer got.
Status resume(const Machine& machine, std::uint32_t from, std::uint32_t layers) {
  PLUMBLINE_TRY(machine.stage.home());
  for (std::uint32_t k = from; k < layers; ++k) {
    auto mask = machine.mask.lend();
    if (!mask) return tl::unexpected<Error>(mask.error());
    draw_random(k, mask->image());
    PLUMBLINE_TRY(machine.stage.move_to(ZPosition(50_um * (k + 1)), Speed(4)));
    PLUMBLINE_TRY(machine.mask.present(std::move(*mask)));
    PLUMBLINE_TRY(machine.lamp.expose(2500ms));
    PLUMBLINE_TRY(machine.mask.blank());
    PLUMBLINE_TRY(machine.stage.move_to(ZPosition(50_um * (k + 1)) + 5_mm, Speed(4)));
  }
  return {};
}

TEST(Plant, ContinuesTheSamePartAfterAPowerCutAtAnyTime) {
  // Some cuts are during homing, the others spread over five layers of some 6 s each.
  for (int percent = 0; percent < 100; percent += 3) {
    SCOPED_TRACE(percent);
    Plant plant(small_printer({"power.cut@t=" + std::to_string(20 + 0.5 * percent) + "s"}));
    {
      SimMachine machine(plant);
      const auto printed = print_layers(machine.machine(), {.layers = 5, .draw = draw_random});
      ASSERT_FALSE(printed);
      EXPECT_EQ(printed.error().code(), ErrorCode::kPowerLost);
      EXPECT_FALSE(plant.powered());
      // Every device reports it, and no time passes.
      const Machine devices = machine.machine();
      const TimePoint now = plant.now();
      const auto power_lost = [](const auto& result) {
        return !result && result.error().code() == ErrorCode::kPowerLost;
      };
      EXPECT_TRUE(power_lost(devices.clock.sleep_until(now + 1s)));
      EXPECT_TRUE(power_lost(devices.events.next_event(now + 1s)));
      EXPECT_TRUE(power_lost(devices.mask.lend()));
      EXPECT_TRUE(power_lost(devices.mask.blank()));
      EXPECT_TRUE(power_lost(devices.lamp.begin_exposure(1s)));
      EXPECT_TRUE(power_lost(devices.stage.position()));
      EXPECT_TRUE(power_lost(devices.stage.begin_homing()));
      EXPECT_TRUE(power_lost(devices.stage.begin_move(ZPosition(), Speed(1))));
      EXPECT_TRUE(power_lost(devices.stick.identity()));
      EXPECT_TRUE(power_lost(devices.stick.mount()));
      EXPECT_TRUE(power_lost(devices.panel.set_light(PanelLight::kFault, LightState::kOn)));
      EXPECT_TRUE(power_lost(devices.panel.beep(1s)));
      EXPECT_TRUE(power_lost(devices.thermals.temperature(TemperatureSite::kLamp)));
      EXPECT_TRUE(power_lost(devices.thermals.set_fan(Fan::kLamp, 1)));
      EXPECT_FALSE(plant.wait(1s));
      EXPECT_EQ(plant.now(), now);
    }
    const auto cured = static_cast<std::uint32_t>(plant.part().layers().size());
    // Print the last layer again if its exposure was cut short.
    const bool cut_short = cured > 0 && plant.lights().back().ended - plant.lights().back().began < 2500ms;
    plant.restore_power();
    EXPECT_FALSE(plant.light());
    SimMachine machine(plant);
    EXPECT_FALSE(machine.machine().stage.homed());
    EXPECT_FALSE(machine.machine().mask.presented());
    const auto resumed = resume(machine.machine(), cut_short ? cured - 1 : cured, 5);
    ASSERT_TRUE(resumed) << resumed.error().message();
    plant.conclude(JobEnd::kFinished);
    ASSERT_THAT(plant.part().layers(), SizeIs(5));
    std::uint32_t k = 0;
    std::vector<std::uint64_t> words(BitImage::words_needed(100, 60));
    plant.part().for_each_layer([&](const CuredLayer&, ConstBitImage image) {
      draw_random(k++, BitImage(words, 100, 60));
      EXPECT_TRUE(std::equal(words.begin(), words.end(), image.words().begin())) << k;
    });
    // The expected trace: the interrupted layer got more light than requested.
    if (cut_short) {
      EXPECT_THAT(kinds_of(plant.objections()), testing::ElementsAre(ObjectionKind::kDoseOff));
      EXPECT_EQ(plant.objections()[0].layer, cured - 1);
    } else {
      EXPECT_THAT(texts_of(plant.objections()), IsEmpty());
    }
  }
}

TEST(Plant, TurnsOffAndStopsWhenTheFirmwareIsKilled) {
  Plant plant(small_printer());
  auto machine = std::make_unique<SimMachine>(plant);
  ASSERT_TRUE(print_layers(machine->machine(), {.layers = 2}));
  auto mask = machine->machine().mask.lend();
  ASSERT_TRUE(mask);
  ASSERT_TRUE(machine->machine().mask.present(std::move(*mask)));
  auto exposure = machine->machine().lamp.begin_exposure(60s);
  ASSERT_TRUE(exposure);
  // Leak the exposure, because none of a killed firmware's destructors run.
  alignas(Exposure) std::array<std::byte, sizeof(Exposure)> left{};
  new (left.data()) Exposure(std::move(*exposure));
  EXPECT_TRUE(plant.light());
  machine.reset();
  ASSERT_TRUE(plant.wait(50ms));
  EXPECT_FALSE(plant.light());
}

TEST(Plant, ChargesTheTimeOfDrawingAMask) {
  PlantSettings settings = small_printer({"compute.slow@layer=2,by=1.5,for=30s"});
  settings.compute_per_mask = 300ms;
  Plant plant(settings);
  SimMachine machine(plant);
  std::vector<double> takes;
  const Machine devices = machine.machine();
  const auto lend = [&] {
    const TimePoint before = devices.clock.now();
    ASSERT_TRUE(devices.mask.lend());
    takes.push_back(std::chrono::duration<double>(devices.clock.now() - before).count());
  };
  lend();
  ASSERT_TRUE(print_layers(devices, {.layers = 2}));
  lend();
  ASSERT_TRUE(plant.wait(30s));
  lend();
  EXPECT_THAT(takes, testing::ElementsAre(0.3, 1.8, 0.3));
}

/// A shape without supports: a post, and from layer 3 on a block beside it that an arm joins to the post in layer 6.
void draw_block(std::uint32_t layer, BitImage image) {
  image.clear();
  for (std::uint32_t y = 10; y < 50; ++y) {
    for (std::uint32_t x = 0; x < 100; ++x) {
      if (x < 30 || (x >= 60 && x < 90 && layer >= 3) || layer >= 6) image.set(x, y);
    }
  }
}

TEST(Plant, ObjectsToWhatDropsAndToItsShadow) {
  Plant plant(small_printer());
  SimMachine machine(plant);
  ASSERT_TRUE(print_layers(machine.machine(), {.layers = 8, .draw = draw_block}));
  plant.conclude(JobEnd::kFinished);
  EXPECT_THAT(kinds_of(plant.objections()), testing::ElementsAre(ObjectionKind::kDropped, ObjectionKind::kShadowed));
  // 30 x 40 pixels of 0.25 mm2 in 3 layers of 0.05 mm. In the next 2 layers these, and 10 x 40 that are joined to the post through
  // them only.
  EXPECT_THAT(to_string(plant.objections()[0]),
              testing::HasSubstr("layer 3, 0.200 mm: region dropped: 0.045 ml at (37.75, 5.25) mm, layers 3 to 5"));
  EXPECT_THAT(to_string(plant.objections()[1]),
              testing::HasSubstr("layer 6, 0.350 mm: light blocked by what lies on the film: 0.04 ml"));
  std::vector<std::uint64_t> pixels;
  plant.part().for_each_layer([&](const CuredLayer&, ConstBitImage image) {
    pixels.push_back(image.count());
    EXPECT_FALSE(image.at(70, 20));
  });
  EXPECT_EQ(pixels, (std::vector<std::uint64_t>{1200, 1200, 1200, 1200, 1200, 1200, 2400, 2400}));
}

TEST(Plant, ForgetsTheShadowWhenSomebodyCleansTheFilm) {
  for (const bool raised : {false, true}) {
    Plant plant(small_printer());
    SimMachine machine(plant);
    const auto draw = [&](std::uint32_t layer, BitImage image) {
      if (layer == 6) {
        // Somebody opens the cover before layer 6. The plate is 5 mm up; with room below it, the film is cleaned.
        if (raised) plant.stage().drift(30_mm);
        plant.open_cover();
        plant.close_cover();
        if (raised) plant.stage().drift(-30_mm);
      }
      draw_block(layer, image);
    };
    ASSERT_TRUE(print_layers(machine.machine(), {.layers = 8, .draw = draw}));
    plant.conclude(JobEnd::kFinished);
    bool cured = false;
    plant.part().for_each_layer([&](const CuredLayer&, ConstBitImage image) { cured = cured || image.at(70, 20); });
    EXPECT_EQ(cured, raised);
    ASSERT_EQ(plant.objections().size(), raised ? 1U : 2U) << testing::PrintToString(texts_of(plant.objections()));
    EXPECT_EQ(plant.objections()[0].loss->last_layer, 5U);
  }
}

TEST(Plant, PrintsTheNextPartOnACleanFilm) {
  Plant plant(small_printer());
  SimMachine machine(plant);
  for (int part = 0; part < 2; ++part) {
    ASSERT_TRUE(print_layers(machine.machine(), {.layers = 5, .draw = draw_block}));
  }
  plant.conclude(JobEnd::kFinished);
  std::vector<std::uint32_t> layers;
  for (const Loss& loss : plant.part().hanging().losses()) {
    EXPECT_EQ(loss.kind, LossKind::kDropped);
    EXPECT_NEAR(loss.ml, 30 * 40 * 0.25 * 0.05 * 2 / 1000, 1e-9);
    layers.push_back(loss.layer);
  }
  EXPECT_THAT(layers, testing::ElementsAre(3, 8)) << "the plant counts on";
}

TEST(Plant, PrintsOnThePlateFromWhichThePartWasTaken) {
  PlantSettings settings = small_printer({"compute.slow@layer=2,by=0.1"});
  settings.layers_on_plate = 3;
  settings.height_on_plate = ZPosition(10_um);
  Plant plant(settings);
  SimMachine machine(plant);
  const auto print = [&](std::uint32_t layers) {
    const auto printed = print_layers(machine.machine(), {.layers = layers, .draw = draw_block});
    ASSERT_TRUE(printed) << printed.error().message();
    plant.conclude(JobEnd::kFinished);
  };
  for (int part = 0; part < 2; ++part) {
    print(5);
    EXPECT_EQ(plant.has_fault(FaultKind::kComputeSlow), part == 1) << "the first begins with layer 3";
    plant.take_part_off();
    EXPECT_THAT(plant.part().layers(), IsEmpty());
    EXPECT_THAT(plant.lights(), IsEmpty());
  }
  print(4);
  ASSERT_THAT(kinds_of(plant.objections()), testing::Each(ObjectionKind::kDropped))
      << "nothing was pressed into the film";
  std::vector<std::uint32_t> dropped;
  for (const Objection& objection : plant.objections()) dropped.push_back(objection.loss->layer);
  EXPECT_THAT(dropped, testing::ElementsAre(6, 3, 3));
  EXPECT_THAT(plant.lights(), SizeIs(4));
}

TEST(Plant, CuresDownFacingSurfacesAsDeepAsTheWorkingCurve) {
  // A bridge of two layers whose underside is layer 6. Its first one cures Dp ln(E / Ec) deep from its own lower side.
  PlantSettings settings = small_printer();
  for (const auto cure :
       {std::chrono::milliseconds(1500), std::chrono::milliseconds(2500), std::chrono::milliseconds(9000)}) {
    Plant plant(settings);
    SimMachine machine(plant);
    const auto draw = [](std::uint32_t layer, BitImage image) {
      image.clear();
      for (std::uint32_t y = 10; y < 50; ++y) {
        for (std::uint32_t x = 0; x < 100; ++x) {
          if (x < 30 || x >= 70 || layer >= 6) image.set(x, y);
        }
      }
    };
    ASSERT_TRUE(print_layers(machine.machine(), {.layers = 8, .cure = cure, .draw = draw}));
    plant.conclude(JobEnd::kFinished);
    EXPECT_THAT(texts_of(plant.objections()), IsEmpty());
    const double dose = settings.lamp.irradiance.value() * std::chrono::duration<double>(cure).count();
    const double deep = settings.resin.penetration_mm * std::log(dose / settings.resin.critical.value());
    // Layer 6 fills 0.3 to 0.35 mm from the plate.
    const DoseField field({.resin = settings.resin, .pitch_x_mm = 0.5, .pitch_y_mm = 0.5}, plant.part());
    const double both = dose * (1 + std::exp(-0.05 / settings.resin.penetration_mm));
    const double together = settings.resin.penetration_mm * std::log(both / settings.resin.critical.value());
    const auto depths = field.cured_depths(50, 30);
    ASSERT_THAT(depths, SizeIs(2));
    EXPECT_NEAR(depths[0], std::max(0.0, 0.35 - together), 1e-4);
    EXPECT_NEAR(depths[1], 0.4, 1e-9);
    const double bridge_mm2 = 40 * 40 * 0.25;
    EXPECT_NEAR(plant.part().hanging().bleed_mm3(), bridge_mm2 * std::max(0.0, deep - 0.05), 1e-3);
    plant.part().for_each_layer([&](const CuredLayer& layer, ConstBitImage image) {
      EXPECT_EQ(image.at(50, 30), layer.z > ZPosition(300_um));
    });
  }
}

TEST(Plant, CuresGreyAsItsPanelsLightSays) {
  // 7.5 mJ/cm2 of 2.4. A panel with 4 levels and gamma 2 lets 0, 1/9, 4/9 or all of the light through.
  for (const GreyScale& grey : {GreyScale{256, 1}, GreyScale{4, 2}}) {
    PlantSettings settings = small_printer();
    settings.panel.grey = grey;
    Plant plant(settings);
    SimMachine machine(plant);
    const auto draw = [](std::uint32_t, BitImage image) {
      image.clear();
      for (std::uint32_t y = 10; y < 50; ++y) {
        for (std::uint32_t x = 0; x < 60; ++x) image.set(x, y);
      }
    };
    const auto add_greys = [](std::uint32_t layer, GreyRuns& greys) {
      if (layer != 0) return;
      for (std::uint32_t y = 20; y < 40; ++y) {
        greys.add({100 * y + 10, 10, 113});
        greys.add({100 * y + 20, 10, 28});
        greys.add({100 * y + 60, 10, 113});
      }
    };
    ASSERT_TRUE(print_layers(machine.machine(), {.layers = 1, .draw = draw, .add_greys = add_greys}));
    plant.conclude(JobEnd::kFinished);
    EXPECT_THAT(texts_of(plant.objections()), IsEmpty());
    EXPECT_EQ(plant.part().layers()[0].pixels, 40U * 60) << "ten columns more, ten less";
    DoseModel model{.resin = settings.resin, .pitch_x_mm = 0.5, .pitch_y_mm = 0.5};
    const DoseField field(model, plant.part());
    const double share = grey.levels == 4 ? std::round(255 * 4.0 / 9) / 255 : 113 / 255.0;
    const double dose = plant.lights()[0].dose.value(), deep = 0.11 * std::log(share * dose / 2.4);
    for (const std::uint32_t column : {15U, 65U}) {
      const auto depths = field.cured_depths(column, 30);
      ASSERT_THAT(depths, SizeIs(2)) << grey.levels << " " << column;
      EXPECT_NEAR(depths[0], std::max(0.0, 0.05 - deep), 1e-5);
    }
    EXPECT_THAT(field.cured_depths(25, 30), IsEmpty()) << "28 / 255 of 7.5 are 0.8 of 2.4";
  }
}

TEST(Plant, TakesTornPiecesOutOfTheLayersBeforeToo) {
  PlantSettings settings = small_printer();
  Plant plant(settings);
  SimMachine machine(plant);
  // A plate of 2000 mm2 below a neck of two pixels: 15 N against 2.5 N.
  const auto draw = [](std::uint32_t layer, BitImage image) {
    image.clear();
    for (std::uint32_t y = 10; y < 50; ++y) {
      for (std::uint32_t x = 0; x < 100; ++x) {
        const bool neck = y == 30 && (x == 50 || x == 51);
        if (layer < 3   ? x < 60
            : layer < 5 ? neck
                        : (layer < 7 ? std::abs(int(x) - 50) < 2 && std::abs(int(y) - 30) < 2 : true))
          image.set(x, y);
      }
    }
  };
  ASSERT_TRUE(print_layers(machine.machine(), {.layers = 9, .draw = draw}));
  plant.conclude(JobEnd::kFinished);
  EXPECT_THAT(kinds_of(plant.objections()), testing::ElementsAre(ObjectionKind::kTorn));
  EXPECT_EQ(plant.objections()[0].loss->layer, 3U);
  EXPECT_EQ(plant.objections()[0].layer, 7U);
  std::vector<std::uint64_t> pixels;
  plant.part().for_each_layer([&](const CuredLayer&, ConstBitImage image) { pixels.push_back(image.count()); });
  EXPECT_EQ(pixels, (std::vector<std::uint64_t>{2400, 2400, 2400, 0, 0, 0, 0, 0, 0}));
}

TEST(Plant, MovesAsItIsBuiltAndNotAsTheFirmwareBelieves) {
  PlantSettings settings = small_printer();
  settings.built_otherwise = {.believed = {100, 60}, .panel = {100, 60}, .travel_ratio = -0.5};
  Plant plant(settings);
  SimMachine run(plant);
  ZStage& stage = run.machine().stage;
  const Distance before = plant.stage().height();
  const auto report = stage.begin_jog(4_mm)->finish();
  ASSERT_TRUE(report) << report.error().message();
  EXPECT_TRUE(report->arrived);
  EXPECT_NEAR((plant.stage().height() - before).micrometres(), -2000, 2);
}

TEST(Plant, ShowsAMaskAsItsPanelIsBuilt) {
  using Mirror = PanelLayout::Mirror;
  PlantSettings settings = small_printer();
  // The firmware sends masks of 60 x 100 as they are; the panel needs 100 x 60 turned by 90 degrees and mirrored.
  settings.built_otherwise = {.believed = {60, 100}, .panel = {100, 60, 90, Mirror::kX}};
  Plant plant(settings);
  SimMachine run(plant);
  auto mask = run.machine().mask.lend();
  ASSERT_TRUE(mask);
  ASSERT_EQ(mask->image().columns(), 60U);
  mask->image().clear();
  mask->image().set(7, 2);
  ASSERT_TRUE(run.machine().mask.present(std::move(*mask)));
  const ConstBitImage seen = plant.panel().visible();
  EXPECT_EQ(seen.count(), 1U);
  // 90 degrees puts (c, r) at (r, 99 - c); mirrored: (59 - r, 99 - c).
  EXPECT_TRUE(seen.at(97, 52));

  settings.built_otherwise->believed = {60, 99};
  Plant other(settings);
  SimMachine other_run(other);
  auto wrong = other_run.machine().mask.lend();
  const auto shown = other_run.machine().mask.present(std::move(*wrong));
  ASSERT_FALSE(shown);
  EXPECT_EQ(shown.error().code(), ErrorCode::kPanelFailed);
}

}  // namespace
}  // namespace plumbline
