#include "firmware/archive/archive_settings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <string>
#include <utility>

#include "slicer/core/resin/bottom_fade.hpp"

namespace plumbline::firmware {
namespace {

using ::testing::HasSubstr;
using Files = std::initializer_list<std::pair<const char*, std::string>>;

struct Said {
  ArchiveSettings settings;
  Status result;

  double operator[](PrintKey key) const { return settings.value(key).value_or(-1); }
  std::string refusal() const { return result ? "" : result.error().message(); }
};

/// @param piece  bytes that come at once
Said read(Files files, std::size_t piece = 7) {
  Said said;
  for (const auto& [name, text] : files) {
    SettingsReader reader(settings_file(name).value(), said.settings);
    const auto bytes = std::as_bytes(std::span(text));
    for (std::size_t at = 0; at < bytes.size() && said.result; at += piece) {
      said.result = reader.feed(bytes.subspan(at, std::min(piece, bytes.size() - at)));
    }
    if (said.result) said.result = reader.finish();
  }
  if (said.result) said.result = said.settings.complete();
  return said;
}

const char* const kConfig =
    "layerHeight = 0.05\nexpTime = 9\nexpTimeFirst = 35\nnumFade = 10\nnumFast = 15\nnumSlow = 5\n";
const char* const kPrusaSlicer =
    "exposure_time = 2.5\nlayer_height = 0.1\ninitial_layer_height = 0.2\ndisplay_width = 120.96\n"
    "display_mirror_x = 1\ndisplay_orientation = portrait\n";

TEST(ArchiveSettings, OfAnSl1AreThoseOfItsConfigIniAlone) {
  for (const char* config : {"config.ini", "part/CONFIG.INI"}) {
    const auto said = read({{config, kConfig}, {"prusaslicer.ini", kPrusaSlicer}});
    ASSERT_TRUE(said.result) << said.refusal();
    EXPECT_EQ(said[PrintKey::kExposureTime], 9);
    EXPECT_EQ(said[PrintKey::kInitialExposureTime], 35);
    EXPECT_EQ(said[PrintKey::kLayerHeight], 0.05);
    EXPECT_EQ(said[PrintKey::kInitialLayerHeight], 0.2) << "of the first mask, which only prusaslicer.ini has";
    EXPECT_EQ(said[PrintKey::kFadedLayers], 10);
    EXPECT_EQ(said[PrintKey::kBottomLayerCount], 3) << "as an SL1 does";
    EXPECT_EQ(said.settings.layers(), 20U);
    EXPECT_EQ(said.settings.width_mm(), 120.96);
    EXPECT_TRUE(said.settings.portrait() && said.settings.mirrors_x() && !said.settings.mirrors_y());
  }
  const auto half = read({{"config.ini", "expTime = 9\n"}, {"prusaslicer.ini", kPrusaSlicer}});
  EXPECT_FALSE(half.settings.value(PrintKey::kLayerHeight)) << "what config.ini does not say is asked";
  const char* const kNotes =
      "printer_notes = Don't "
      "remove.\\nLiftHeight_9\\nSTART_CUSTOM_VALUES\\nLiftHeight_5\\nLiftSpeed_60.5\\nLightPWM_255\\n"
      "BottomLayerCount_7\\nEND_CUSTOM_VALUES\\nLiftSpeed_3\n";
  const auto noted = read({{"config.ini", kConfig}, {"prusaslicer.ini", kNotes}});
  ASSERT_TRUE(noted.result) << noted.refusal();
  EXPECT_EQ(noted[PrintKey::kBottomLayerCount], 7);
  EXPECT_EQ(noted[PrintKey::kLiftHeight], 5);
  EXPECT_EQ(noted[PrintKey::kLiftSpeed], 60.5);
  EXPECT_EQ(noted[PrintKey::kLiftHeight2], 0);
  EXPECT_THAT(
      read({{"prusaslicer.ini", "printer_notes = START_CUSTOM_VALUES\\nLiftHeight_99\\nEND_CUSTOM_VALUES"}}).refusal(),
      HasSubstr("LiftHeight is '99', allowed is 0.5 to 30 mm"));
}

TEST(ArchiveSettings, AreReadAsTheyAreWrittenAnywhere) {
  const auto wide = [](const char* text, bool high_first, bool marked) {
    std::string bytes = marked ? (high_first ? "\xfe\xff" : "\xff\xfe") : "";
    for (; *text != 0; ++text) bytes += high_first ? std::string{'\0', *text} : std::string{*text, '\0'};
    return bytes;
  };
  const std::string lines[] = {
      std::string("\xef\xbb\xbf") + "expTime = 9\r\nlayerHeight = 0.1\r\n",
      "EXPTIME=9\nLAYERHEIGHT=0.1",
      "expTime: 9\nlayerHeight: 0.1\n",
      "expTime = \"9\"\n layerHeight\t=\t'0.1' \n",
      "expTime = 9,0\nlayerHeight = 0,1\n",
      "expTime = 9 s\nlayerHeight = 100 um\n",
      "expTime = 9000ms\nlayerHeight = 100\xc2\xb5m\n",
      "# expTime = 4\n[print]\n; expTime = 5\nexpTime = 9\nlayerHeight = 0.1\nexpTime = 9.0\n",
      wide("expTime = 9\nlayerHeight = 0.1\n", false, true),
      wide("expTime = 9\nlayerHeight = 0.1\n", true, true),
      wide("expTime = 9\nlayerHeight = 0.1\n", false, false),
      wide("expTime = 9\nlayerHeight = 0.1\n", true, false),
  };
  for (const std::string& text : lines) {
    for (const std::size_t piece : {1U, 3U, 4096U}) {
      const auto said = read({{"config.ini", text}}, piece);
      ASSERT_TRUE(said.result) << text << said.refusal();
      EXPECT_EQ(said[PrintKey::kExposureTime], 9) << text;
      EXPECT_DOUBLE_EQ(said[PrintKey::kLayerHeight], 0.1) << text;
    }
  }
}

TEST(ArchiveSettings, OfEachSlicerHaveOneTable) {
  const auto chitubox =
      read({{"run.gcode",
             ";fileName:cube\n;layerHeight:0.1\n;resolutionX:1440\n;machineX:68.04\n;normalExposureTime:8\n"
             ";bottomLayExposureTime:45\n;bottomLayerExposureTime:45\n;bottomLayerCount:5\n"
             ";normalLayerLiftHeight:6\n;normalLayerLiftSpeed:65\n;normalDropSpeed:150\n;totalLayer:20\n"
             ";mirror:1\n;START_GCODE_BEGIN\nG21\n;LAYER_START:0\nM106 S255\nG4 P45000\n"}});
  ASSERT_TRUE(chitubox.result) << chitubox.refusal();
  const auto cws =
      read({{"cube.gcode",
             ";(****Build and Slicing Parameters****)\n;(Layer Thickness       = 0.10000 mm )\n"
             ";(Layer Time = 8000 ms )\n;(Bottom Layers Time        = 45000 ms )\n"
             ";(Number of Bottom Layers = 5 )\n;(Lift Distance = 6 mm )\n"
             ";(Z Lift Feed Rate        = 65.00000 mm/s )\n;(Z Lift Retract Rate = 150 mm/s )\n"
             ";(Flip X = True)\n;(Flip Y = False)\n;(Pix per mm X = 21.164 px/mm )\n;(X Resolution = 1440 )\n"
             ";Number of Slices        =  20\n"},
            {"default.slicing", "<SliceBuildConfig><LayerTime>4000</LayerTime></SliceBuildConfig>"}});
  ASSERT_TRUE(cws.result) << cws.refusal();
  const auto klipper = read({{"cube.gcode",
                              ";LayerHeight:0.1\n;BottomLayerCount:5\n;ExposureTime:8\n;BottomExposureTime:45\n"
                              ";TransitionLayerCount:0\n;LiftHeight:6\n;LiftSpeed:65\n;LiftHeight2:0\n;LiftSpeed2:0\n"
                              ";RetractSpeed:150\n;RetractHeight2:0\n;RetractSpeed2:0\n;Mirror:1\n"
                              "SET_PRINT_STATS_INFO TOTAL_LAYER=20 LAYER=1 MATERIAL_TOTAL=3\n"
                              "PRINT_START LAYERS=20 HEIGHT=2\nSET_PRINT_STATS_INFO CURRENT_LAYER=3\n"}});
  ASSERT_TRUE(klipper.result) << klipper.refusal();
  const auto nanodlp =
      read({{"profile.json",
             "{\"Depth\":100,\"SupportDepth\":100,\"CureTime\":8,\"SupportCureTime\":45,\"SupportLayerNumber\":5,"
             "\"WaitHeight\":6,\"Title\":\"a, \\\"b\\\": {[\", \"CustomValues\":{\"CureTime\":\"3\"}}"},
            {"slicer.json", "{\"PWidth\":1440,\"XPixelSize\":0.04725,\"ImageMirror\":1}"},
            {"plate.json", "{\"LayersCount\":20,\"MC\":{\"Count\":2},\"CureTimes\":[]}"}});
  ASSERT_TRUE(nanodlp.result) << nanodlp.refusal();
  const auto uvj =
      read({{"config.json",
             "{\"Properties\":{\"Size\":{\"X\":1440,\"Y\":2560,\"Millimeter\":{\"X\":68.04,\"Y\":120.96},\"Layers\":20,"
             "\"LayerHeight\":0.1},\"Exposure\":{\"LightOnTime\":8.0,\"LiftHeight\":6,\"LiftSpeed\":65,"
             "\"RetractSpeed\":150,\"LightPWM\":255},\"Bottom\":{\"LightOnTime\":45,\"Count\":5,\"LiftHeight\":9}},"
             "\"Layers\":[{\"Z\":0.1,\"Exposure\":{\"LightOnTime\":45}},{\"Z\":0.2}]}"}});
  ASSERT_TRUE(uvj.result) << uvj.refusal();
  for (const Said* said : {&chitubox, &cws, &klipper, &nanodlp, &uvj}) {
    EXPECT_DOUBLE_EQ((*said)[PrintKey::kLayerHeight], 0.1);
    EXPECT_EQ((*said)[PrintKey::kExposureTime], 8);
    EXPECT_EQ((*said)[PrintKey::kInitialExposureTime], 45);
    EXPECT_EQ((*said)[PrintKey::kBottomLayerCount], 5);
    EXPECT_EQ((*said)[PrintKey::kFadedLayers], 0) << "their printers fade only where they are told to";
    EXPECT_EQ((*said)[PrintKey::kLiftHeight], 6);
    EXPECT_EQ((*said)[PrintKey::kLiftHeight2], 0);
    EXPECT_EQ(said->settings.layers(), 20U);
    if (said == &nanodlp) continue;  // its speeds are G-code
    EXPECT_EQ((*said)[PrintKey::kLiftSpeed], 65);
    EXPECT_EQ((*said)[PrintKey::kRetractSpeed], 150);
    EXPECT_EQ((*said)[PrintKey::kRetractHeight2], 0);
  }
  for (const Said* said : {&chitubox, &cws, &nanodlp, &uvj}) {
    EXPECT_NEAR(said->settings.width_mm().value_or(0), 68.04, 0.001);
  }
  for (const Said* said : {&chitubox, &cws, &klipper, &nanodlp}) {
    EXPECT_TRUE(said->settings.turns && said->settings.mirrors_x() && !said->settings.mirrors_y());
  }
  EXPECT_FALSE(uvj.settings.turns);
}

TEST(ArchiveSettings, OfCreationWorkshopAreTheirXmlsWhereTheGcodeIsSilent) {
  const auto one =
      read({{"a.gcode", "G21\n"},
            {"a.slicing",
             "<?xml version=\"1.0\"?>\n<SliceBuildConfig FileVersion=\"2\">\n  <LiftDistance>6</LiftDistance>"
             "<InkConfig><Name>grey</Name>\n<SliceHeight>0.1</SliceHeight><LayerTime> 8000 </LayerTime>"
             "<FirstLayerTime>45000</FirstLayerTime></InkConfig></SliceBuildConfig>"}});
  ASSERT_TRUE(one.result) << one.refusal();
  EXPECT_EQ(one[PrintKey::kLayerHeight], 0.1);
  EXPECT_EQ(one[PrintKey::kExposureTime], 8);
  EXPECT_EQ(one[PrintKey::kInitialExposureTime], 45);
  const auto two =
      read({{"a.slicing", "<LayerTime>8000</LayerTime><LayerTime>5000</LayerTime><LayerTime>5000</LayerTime>"}});
  ASSERT_TRUE(two.result) << two.refusal();
  EXPECT_FALSE(two.settings.value(PrintKey::kExposureTime)) << "the file lists all resins, not the one that is meant";
}

TEST(ArchiveSettings, FollowTheExposuresOfTheLayers) {
  // Two bottom layers, three that fade, two normal ones.
  const double ramp[] = {40, 40, 32, 24, 16, 8, 8};
  const auto print = [](std::initializer_list<double> seconds) {
    std::string chitubox =
        ";normalExposureTime:8\n;bottomLayerExposureTime:40\n;bottomLayerCount:2\nM106 S0\nG4 P500\n";
    std::string cws = ";(Layer Time = 8000)\n;(Bottom Layers Time = 40000)\n;(Number of Bottom Layers = 2)\n";
    std::string uvj =
        "{\"Properties\":{\"Exposure\":{\"LightOnTime\":8},\"Bottom\":{\"LightOnTime\":40,\"Count\":2}},\"Layers\":[";
    for (const double s : seconds) {
      const std::string ms = std::to_string(std::lround(1000 * s));
      chitubox += "G0 Z5 F60;lift\nM106 S255;light on\nG4 P" + ms + ";\nM106 S0;light off\nG4 P200\n";
      cws += ";<Slice> 1\nM106 S255 ; UV on\n;<Delay> " + ms + "\nM106 S0\n;<Slice> Blank\n;<Delay> 1000\n";
      uvj += "{\"Z\":0.1,\"Exposure\":{\"LightOnTime\":" + std::to_string(s) + ",\"LiftHeight\":5}},";
    }
    uvj.pop_back();
    return std::array<Said, 3>{read({{"run.gcode", chitubox}}), read({{"a.gcode", cws}}),
                               read({{"config.json", uvj + "]}"}})};
  };
  for (const Said& said : print({40, 40, 32, 24, 16, 8, 8})) {
    ASSERT_TRUE(said.result) << said.refusal();
    EXPECT_EQ(said[PrintKey::kFadedLayers], 3);
    for (std::uint32_t layer = 0; layer < std::size(ramp); ++layer) {
      EXPECT_DOUBLE_EQ(ramp[layer], 40 - 32 * bottom_fade(layer, 2, 3));
    }
  }
  for (const Said& said : print({40, 40, 8, 8})) {
    ASSERT_TRUE(said.result) << said.refusal();
    EXPECT_EQ(said[PrintKey::kFadedLayers], 0);
  }
  for (const Said& said : print({40, 40, 8, 8, 8, 3, 8})) {
    EXPECT_THAT(said.refusal(), HasSubstr("has an exposure of its own, which this version can't print"));
  }
  for (const Said& said : print({40, 8, 8})) EXPECT_THAT(said.refusal(), HasSubstr("has an exposure of its own"));
}

TEST(ArchiveSettings, SayNothingThatTheyDoNotSay) {
  const auto said = read({{"cube.gcode", ";(Layer Thickness = 0.1 mm )\n;(Layer Time = 8000 ms )\n"}});
  for (const PrintKey key : {PrintKey::kBottomLayerCount, PrintKey::kInitialExposureTime, PrintKey::kFadedLayers,
                             PrintKey::kLiftHeight, PrintKey::kLiftHeight2, PrintKey::kRetractSpeed}) {
    EXPECT_FALSE(said.settings.value(key)) << kPrintFields[index_of(key)].name;
  }
  const auto none = read(
      {{"run.gcode", ";layerHeight:0.1\n;normalExposureTime:8\n;bottomLayerExposureTime:40\n;bottomLayerCount:0\n"}});
  EXPECT_EQ(none[PrintKey::kBottomLayerCount], 1);
  EXPECT_EQ(none[PrintKey::kInitialExposureTime], 8) << "no bottom layers: all are exposed alike";
}

TEST(ArchiveSettings, ThatCannotBePrintedAreRefusedByName) {
  const auto refusal = [](const char* name, const std::string& text) { return read({{name, text}}).refusal(); };
  EXPECT_THAT(refusal("config.ini", "expTime = 121\n"), HasSubstr("expTime is '121', allowed is 0.1 to 120 s"));
  EXPECT_THAT(refusal("config.ini", "expTime = nan\n"), HasSubstr("expTime is 'nan'"));
  EXPECT_THAT(refusal("config.ini", "expTime = -1\n"), HasSubstr("expTime is '-1'"));
  EXPECT_THAT(refusal("config.ini", "expTime = 8 mm\n"), HasSubstr("expTime is '8 mm'"));
  EXPECT_THAT(refusal("config.ini", "expTime = true\n"), HasSubstr("expTime is 'true'"));
  EXPECT_THAT(refusal("config.ini", "numFade = 2.5\n"), HasSubstr("numFade is '2.5', allowed is 0 to 100 layers"));
  EXPECT_THAT(refusal("config.ini", "expTime = 8\nexpTime = 9\n"),
              HasSubstr("expTime is '9', but another line says 8"));
  EXPECT_THAT(refusal("run.gcode", ";bottomLayCount:4\n;bottomLayerCount:6\n"), HasSubstr("but another line says 4"));
  EXPECT_THAT(refusal("run.gcode", ";PWMLight:128\n"), HasSubstr("asks for 50 % of the lamp's power"));
  EXPECT_THAT(refusal("config.ini", "expTime = 2\ncalibrateRegions = 8\n"),
              HasSubstr("is an exposure test of 8 exposures"));
  EXPECT_EQ(refusal("config.ini", "expTime = 2\ncalibrateRegions = 0\n"), "");
  EXPECT_THAT(refusal("profile.json", "{\"Depth\":50,\"SupportDepth\":100,\"SupportLayerNumber\":4}"),
              HasSubstr("its bottom layers are 0.1 mm high and the others 0.05 mm"));
  EXPECT_THAT(refusal("config.json", "{\"Properties\":{"), HasSubstr("is cut off"));
  EXPECT_THAT(refusal("config.json", "}"), HasSubstr("closes more brackets"));
  EXPECT_THAT(refusal("config.json", std::string(20, '[')), HasSubstr("is nested too deeply"));
}

}  // namespace
}  // namespace plumbline::firmware
