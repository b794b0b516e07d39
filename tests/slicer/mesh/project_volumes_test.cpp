/// What slicers' projects say of their volumes: negative ones are cut out, modifiers and the like are left out.

#include <gtest/gtest.h>

#include "tests/slicer/mesh/sliced_mesh.hpp"
#include "tests/slicer/support/threemf_file.hpp"

namespace plumbline {
namespace {

using namespace testing;

const TestMesh kBody = box_mesh({0, 0, 0}, {20, 14, 10});
const TestMesh kHole = box_mesh({5, 5, -1}, {9, 9, 11});

std::string mesh_element(const TestMesh& mesh) {
  std::string text = "<mesh><vertices>\n";
  for (const Vec3d& v : mesh.vertices) {
    text += "<vertex x=\"" + std::to_string(v[0]) + "\" y=\"" + std::to_string(v[1]) + "\" z=\"" +
            std::to_string(v[2]) + "\"/>\n";
  }
  text += "</vertices><triangles>\n";
  for (const auto& f : mesh.faces) {
    text += "<triangle v1=\"" + std::to_string(f[0]) + "\" v2=\"" + std::to_string(f[1]) + "\" v3=\"" +
            std::to_string(f[2]) + "\"/>\n";
  }
  return text + "</triangles></mesh>";
}
std::string object_element(int id, const std::string& inner) {
  return "<object id=\"" + std::to_string(id) + "\" type=\"model\">" + inner + "</object>";
}
std::string project(const std::string& resources, const std::string& items, std::vector<ZipPart> more) {
  more.insert(more.begin(), {"_rels/.rels", relations_to("/3D/3dmodel.model")});
  more.insert(more.begin() + 1,
              {"3D/3dmodel.model", model_of("<resources>" + resources + "</resources><build>" + items + "</build>")});
  return zip_of(more);
}

/// As PrusaSlicer writes it: one mesh, whose triangles from the 13th on are a volume of that type.
std::string prusa_slicer(const TestMesh& body, const TestMesh& volume, const std::string& type,
                         const std::string& items = "<item objectid=\"1\"/>", const std::string& others = "") {
  TestMesh all = body;
  append(all, volume);
  const std::size_t first = body.faces.size();
  return project(
      object_element(1, mesh_element(all)) + others, items,
      {{"Metadata/Slic3r_PE_model.config",
        "<config><object id=\"1\"><volume firstid=\"0\" lastid=\"" + std::to_string(first - 1) +
            "\"><metadata type=\"volume\" key=\"volume_type\" value=\"ModelPart\"/></volume>"
            "<volume firstid=\"" +
            std::to_string(first) + "\" lastid=\"" + std::to_string(all.faces.size() - 1) +
            "\"><metadata type=\"volume\" key=\"volume_type\" value=\"" + type + "\"/></volume></object></config>"}});
}

SliceReport report_of(const std::string& file, double& volume, std::size_t arena = kArena) {
  const Slicing slicing(MemorySource(file, "project.3mf"), settings_with_pitch(0.2F), arena);
  volume = slicing.volume();
  return slicing.report();
}
double volume_of(const std::string& file) {
  double volume = 0;
  static_cast<void>(report_of(file, volume));
  return volume;
}

TEST(ProjectVolumes, OfPrusaSlicerHaveTheirRoles) {
  EXPECT_NEAR(volume_of(prusa_slicer(kBody, kHole, "ModelPart")), 2832, 0.1);
  for (const char* type : {"ParameterModifier", "SupportEnforcer", "SupportBlocker"}) {
    double volume = 0;
    const SliceReport report = report_of(prusa_slicer(kBody, kHole, type), volume);
    EXPECT_NEAR(volume, 2800, 0.1) << type;
    EXPECT_EQ(report.mesh->project.ignored, 1U) << type;
    EXPECT_EQ(report.mesh->triangles, 12U) << type;
  }
  EXPECT_NEAR(volume_of(prusa_slicer(kBody, kHole, "NegativeVolume")), 2640, 0.1);
}

TEST(ProjectVolumes, ThatAreNegativeMayReachBeyondTheObjectAndBeInsideOut) {
  TestMesh turned = kHole;
  flip(turned, 0, turned.faces.size());
  flip(turned, 3, 4);
  EXPECT_NEAR(volume_of(prusa_slicer(kBody, turned, "NegativeVolume")), 2640, 0.1);
  const TestMesh huge = box_mesh({-300, -300, 3}, {300, 300, 900});
  EXPECT_NEAR(volume_of(prusa_slicer(kBody, huge, "NegativeVolume")), 840, 0.1);
  const TestMesh corner = ball_mesh({20, 14, 10}, 6, 5);
  EXPECT_NEAR(volume_of(prusa_slicer(kBody, corner, "NegativeVolume")), 2800 - 36 * M_PI, 1.5);
}

TEST(ProjectVolumes, ThatAreNegativeAreCutOutOfTheirOwnItem) {
  const std::string two = R"(<item objectid="1"/><item objectid="1" transform="-1 0 0 0 1 0 0 0 1 60 0 0"/>)";
  EXPECT_NEAR(volume_of(prusa_slicer(kBody, kHole, "NegativeVolume", two)), 2 * 2640, 0.1);
  const TestMesh slot = box_mesh({0, 0, 3}, {60, 14, 7});
  const std::string items = R"(<item objectid="1"/><item objectid="2"/>)";
  const auto beside = [&](double from) {
    const std::string other = object_element(2, mesh_element(box_mesh({from, 0, 0}, {40, 14, 10})));
    return volume_of(prusa_slicer(kBody, slot, "NegativeVolume", items, other));
  };
  EXPECT_NEAR(beside(30), 20 * 14 * 6 + 1400, 0.1);
  EXPECT_NEAR(beside(10), 10 * 14 * 6 + 30 * 140, 0.1);
}

TEST(ProjectVolumes, OfBambuStudioAndOrcaSlicerHaveTheirRoles) {
  const auto file = [](const std::string& type, bool first) {
    const std::string parts = R"(<object id="8" type="model"><components>)"
                              R"(<component p:path="/3D/Objects/object_1.model" objectid="1"/>)"
                              R"(<component p:path="/3D/Objects/object_1.model" objectid="2" )"
                              R"(transform="1 0 0 0 1 0 0 0 1 1 0 0"/></components></object>)";
    const ZipPart settings{"Metadata/model_settings.config",
                           R"(<config><object id="8"><metadata key="name" value="x"/>)"
                           R"(<part id="1" subtype="normal_part"/><part id="2" subtype=")" +
                               type + R"("><metadata key="name" value="y"/></part></object></config>)"};
    const ZipPart objects{"3D/Objects/object_1.model",
                          model_of("<resources>" + object_element(1, mesh_element(kBody)) +
                                   object_element(2, mesh_element(kHole)) + "</resources><build/>")};
    return project(parts, R"(<item objectid="8"/>)",
                   first ? std::vector<ZipPart>{settings, objects} : std::vector<ZipPart>{objects, settings});
  };
  for (const bool first : {false, true}) {
    EXPECT_NEAR(volume_of(file("normal_part", first)), 2832, 0.1);
    EXPECT_NEAR(volume_of(file("negative_part", first)), 2640, 0.1);
    for (const char* type : {"modifier_part", "support_enforcer", "support_blocker"}) {
      EXPECT_NEAR(volume_of(file(type, first)), 2800, 0.1) << type;
    }
  }
}

TEST(ProjectVolumes, OfCuraThatAreNoSolidsAreLeftOut) {
  const auto file = [](const std::string& setting, bool of_item) {
    return project(
        object_element(1, mesh_element(kBody)) + object_element(2, (of_item ? "" : setting) + mesh_element(kHole)),
        R"(<item objectid="1"/><item objectid="2">)" + (of_item ? setting : "") + "</item>", {});
  };
  for (const char* name : {"infill_mesh", "cutting_mesh", "support_mesh", "anti_overhang_mesh"}) {
    const auto metadata = [&](const char* value) {
      return std::string("<metadatagroup><metadata name=\"cura:") + name + "\" type=\"xs:string\">" + value +
             "</metadata></metadatagroup>";
    };
    for (const bool of_item : {false, true}) {
      EXPECT_NEAR(volume_of(file(metadata("True"), of_item)), 2800, 0.1) << name;
      EXPECT_NEAR(volume_of(file(metadata("False"), of_item)), 2832, 0.1) << name;
    }
    const std::string old = std::string("<settings><setting key=\"") + name + "\">True</setting></settings>";
    EXPECT_NEAR(volume_of(file(old, false)), 2800, 0.1) << name;
  }
}

TEST(ProjectVolumes, SettingsThatAreNotUsedAreFound) {
  const auto with = [](std::vector<ZipPart> parts) {
    double volume = 0;
    return report_of(project(object_element(1, mesh_element(kBody)), R"(<item objectid="1"/>)", std::move(parts)),
                     volume)
        .mesh->project;
  };
  const UnusedSettings none =
      with({{"Metadata/Slic3r_PE_sla_support_points.txt", "support_points_format_version=1\n"},
            {"Metadata/Slic3r_PE.config",
             "; hollowing_enable = 0\n; relative_correction = 1,1\n; absolute_correction = 0\n"}});
  EXPECT_FALSE(none.hollowing || none.drain_holes || none.support_points || none.correction);
  const UnusedSettings all = with(
      {{"Metadata/Slic3r_PE_sla_support_points.txt", "support_points_format_version=1\nobject_id=1|1 2 3 0.4 0\n"},
       {"Metadata/Slic3r_PE_sla_drain_holes.txt", "drain_holes_format_version=1\nobject_id=1|1 2 3 0 0 1 1 1\n"},
       {"Metadata/Slic3r_PE.config", "; relative_correction = 1.01,1\n"},
       {"Metadata/Slic3r_PE_model.config",
        R"(<config><object id="1"><metadata type="object" key="hollowing_enable" value="1"/></object></config>)"}});
  EXPECT_TRUE(all.hollowing && all.drain_holes && all.support_points && all.correction);
}

}  // namespace
}  // namespace plumbline
