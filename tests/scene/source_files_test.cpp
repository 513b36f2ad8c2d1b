// What sources take of files: attributes by name, root uv, ids; and what is said where they are not there.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <string>

#include "scene/read/input_files.h"
#include "scene/read/load_scene.h"
#include "scene/read/texture_file.h"
#include "tress/fiber/parameter_ranges.h"

namespace tress::scene {
namespace {

namespace fs = std::filesystem;

class SourceFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(::testing::TempDir()) / ("tress_source_files_" + std::to_string(getpid()));
    fs::create_directories(folder_);
    fs::copy_file(fs::path(TRESS_SOURCE_DIR) / "scenes" / "skin.png", folder_ / "skin.png",
                  fs::copy_options::overwrite_existing);
    write("hair.usda", R"(#usda 1.0
(metersPerUnit = 0.01
upAxis = "Z")
def BasisCurves "hair" {
  uniform token type = "linear"
  int[] curveVertexCounts = [3, 3]
  point3f[] points = [(0,0,0), (0,0,-1), (0,0,-2), (1,0,0), (1,0,-1), (1,0,-2)]
  float[] widths = [0.01] (interpolation = "constant")
  color3f[] primvars:displayColor = [(0.1,0.1,0.1)] (interpolation = "constant")
  color3f[] primvars:dye = [(1,0,0), (0,1,0), (0,0,1), (1,0,0), (0,1,0), (0,0,1)] (interpolation = "vertex")
  float[] primvars:mask = [0.25, 0.75] (interpolation = "uniform")
  int[] primvars:id = [7, 9] (interpolation = "uniform")
  texCoord2f[] primvars:st = [(0.25,0.5), (0.75,0.5)] (interpolation = "uniform")
})");
    write("hair.ply", R"(ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
property float strand_id
property uchar red
property uchar green
property uchar blue
property uchar mask
end_header
0 0 0 0 255 0 0 51
0 0 -1 0 255 0 0 255
1 0 0 1 255 0 0 51
1 0 -1 1 255 0 0 255
)");
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write(const std::string& name, const std::string& text) const { std::ofstream(folder_ / name) << text; }

  Result<Scene> scene(const std::string& material, const std::string& file = "hair.usda") const {
    write("s.json", R"({"camera": {"eye": [0, -10, 0]}, "materials": [{"name": "m", )" + material +
                        R"(}], "grooms": [{"file": ")" + file +
                        R"(", "cm_per_unit": 1, "up": "z", "material": "m"}]})");
    return load_scene(folder_ / "s.json");
  }
  Groom groom(const std::string& material, const std::string& file = "hair.usda") const {
    auto loaded = scene(material, file);
    EXPECT_TRUE(loaded) << loaded.error().message();
    return loaded && !loaded->grooms.empty() ? loaded->grooms[0] : Groom{};
  }
  std::string refusal(const std::string& material, const std::string& file = "hair.usda") const {
    const auto loaded = scene(material, file);
    return loaded ? "" : loaded.error().message();
  }

  fs::path folder_;
};

TEST_F(SourceFiles, AttributesAreReadByName) {
  const std::string dye = R"("color": {"attribute": "dye"})",
                    mask = R"("melanin": {"eumelanin": {"attribute": "mask"}})";
  const Groom by_point = groom(dye);
  ASSERT_EQ(by_point.color.size(), 6u);
  EXPECT_EQ(by_point.color[1], glm::vec3(0, 1, 0));
  EXPECT_EQ(by_point.stations_a_segment, 16u);
  const Groom by_strand = groom(mask);
  ASSERT_EQ(by_strand.color.size(), 2u);
  EXPECT_EQ(by_strand.color[1], glm::vec3(0.75f));
  EXPECT_EQ(by_strand.stations_a_segment, 0u);
  EXPECT_EQ(groom(R"("color": {"attribute": "displayColor"})").color.at(1), glm::vec3(0.1f));
  EXPECT_EQ(groom(R"("color": "file")").color.at(1), glm::vec3(0.1f));
  const Groom ply = groom(mask, "hair.ply");
  ASSERT_EQ(ply.color.size(), 4u);
  EXPECT_EQ(ply.color[0], glm::vec3(0.2f));
  EXPECT_EQ(groom(R"("color": "file")", "hair.ply").color.at(1), glm::vec3(1, 0, 0));
}

TEST_F(SourceFiles, AttributesOfAlembicAreReadByName) {
  for (const char* name : {"colored.abc", "same.abc"})
    fs::copy_file(fs::path(TRESS_SOURCE_DIR) / "tests" / "scene" / "grooms" / name, folder_ / name);
  const Groom file = groom(R"("color": "file")", "colored.abc"),
              named = groom(R"("color": {"attribute": "groom_color"})", "colored.abc"),
              number = groom(R"("melanin": {"eumelanin": {"attribute": "groom_id"}})", "same.abc");
  EXPECT_FALSE(file.color.empty());
  EXPECT_EQ(named.color, file.color);
  EXPECT_EQ(named.choices, file.choices);
  EXPECT_EQ(number.color.size(), number.strand_count());
  EXPECT_NE(refusal(R"("color": {"attribute": "Cd"})", "colored.abc").find("colored.abc: attribute \"Cd\""),
            std::string::npos);
}

TEST_F(SourceFiles, AttributesThatAreNotThereAreErrorsThatNameOthers) {
  const std::string usda = refusal(R"("color": {"attribute": "dy"})");
  EXPECT_NE(usda.find("hair.usda: attribute \"dy\": expected one of the curves, of one or three numbers"),
            std::string::npos)
      << usda;
  EXPECT_NE(usda.find("primvars:dye"), std::string::npos) << usda;
  EXPECT_NE(refusal(R"("color": {"attribute": "dye"})", "hair.ply").find("property mask"), std::string::npos);
  write("generated.json", R"({"materials": [{"name": "m", "color": {"attribute": "Cd"}}],
                              "grooms": [{"generate": "wavy", "material": "m"}]})");
  const auto generated = load_scene(folder_ / "generated.json");
  ASSERT_FALSE(generated);
  EXPECT_NE(generated.error().message().find("found an attribute of a file"), std::string::npos);
}

TEST_F(SourceFiles, TexturesOfTilesAreThoseThatExist) {
  const auto copy = [&](const char* name) {
    fs::copy_file(folder_ / "skin.png", folder_ / name, fs::copy_options::overwrite_existing);
  };
  const std::string tiles = R"("sigma_a": {"texture": "scalp.<UDIM>.png"})";
  EXPECT_NE(refusal(tiles).find("scalp.<UDIM>.png: expected files of tiles, 1001 to 1999"), std::string::npos)
      << refusal(tiles);
  copy("scalp.1002.png");
  EXPECT_NE(refusal(tiles).find("expected places on the tiles 1002 of the texture of \"m\", found (0.25, 0.5)"),
            std::string::npos)
      << refusal(tiles);
  copy("scalp.1001.png");
  const auto loaded = scene(tiles);
  ASSERT_TRUE(loaded) << loaded.error().message();
  std::vector<std::string> warnings;
  const auto skin = load_texture(folder_ / "skin.png", &warnings);
  ASSERT_TRUE(skin);
  const Source& source = loaded->materials[0].pigment->source;
  EXPECT_EQ(source.texture->tiles().size(), 2u);
  EXPECT_EQ(source.at({.root_uv = {0.25f, 0.5f}}), skin->at({0.25f, 0.5f}));
  EXPECT_EQ(source.at({.root_uv = {1.25f, 0.5f}}), skin->at({0.25f, 0.5f}));
}

TEST_F(SourceFiles, TexturesLieOverTheRoots) {
  const auto loaded = scene(R"("sigma_a": {"texture": "skin.png"})");
  ASSERT_TRUE(loaded) << loaded.error().message();
  std::vector<std::string> warnings;
  const auto skin = load_texture(folder_ / "skin.png", &warnings),
             raw = load_texture(folder_ / "skin.png", &warnings, false);
  ASSERT_TRUE(skin && raw);
  const Source& source = loaded->materials[0].pigment->source;
  const Groom& groom = loaded->grooms[0];
  ASSERT_EQ(groom.root_uv.size(), 2u);
  for (std::uint32_t s = 0; s < 2; ++s) {
    const glm::vec3 expected = skin->at(groom.root_uv[s]), found = source.at({.root_uv = groom.root_uv[s]});
    EXPECT_EQ(found, expected);
    // Rounded to a power of 1.2.
    const glm::vec3 sigma_a = loaded->fibers[groom.fiber_at(groom.station_at(s, 0, 0), 0)].sigma_a;
    for (int c = 0; c < 3; ++c) EXPECT_LT(std::abs(std::log(sigma_a[c] / expected[c])), std::log(1.2) + 1e-6);
  }
  // A mask's 0.5 is coded as 0.5: sRGB would make 0.21 of it.
  const glm::vec3 a = skin->at({0.3f, 0.3f}), b = raw->at({0.3f, 0.3f});
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(std::pow((b[c] + 0.055f) / 1.055f, 2.4f), a[c], 0.002f);
  EXPECT_NE(refusal(R"("sigma_a": {"texture": "skin.png"})", "hair.ply")
                .find("hair.ply: root uv: expected those of its strands"),
            std::string::npos);
  EXPECT_NE(refusal(R"("sigma_a": {"texture": "no.png"})").find("no.png"), std::string::npos);
}

TEST_F(SourceFiles, IdsAreKept) { EXPECT_EQ(groom(R"("hair": "brown")").id, (std::vector<std::int64_t>{7, 9})); }

TEST_F(SourceFiles, RoughnessRampsAreWholeDegrees) {
  const auto loaded = scene(R"("roughness": {"ramp": [[0, 0.1], [1, 0.3]]}, "melanin": {"eumelanin": 1})");
  ASSERT_TRUE(loaded) << loaded.error().message();
  const Groom& groom = loaded->grooms[0];
  ASSERT_EQ(groom.stations_a_segment, 16u);
  const float step = 0.0174533f;
  for (const float place : {0.0f, 0.5f, 1.0f, 2.0f})
    EXPECT_NEAR(loaded->fibers[groom.fiber_at(groom.station_at(0, place, 0), 0)].roughness, 0.1f + 0.1f * place, step)
        << place;
  for (const fiber::FiberParameters& fiber : loaded->fibers)
    EXPECT_NEAR(fiber.roughness / step, std::round(fiber.roughness / step), 1e-3f);
  EXPECT_EQ(loaded->fibers.size(), 14u);  // 5 to 18 degrees
}

TEST_F(SourceFiles, TiltAndMedullaVaryAlongStrandsOnTheirGrids) {
  const auto loaded = scene(R"("tilt_deg": {"ramp": [[0, 2.2], [1, 8.2]]},
    "medulla": {"radius": {"ramp": [[0, 0], [1, 0.8]]}, "scattering": {"ramp": [[0, 0], [1, 10]]},
                "asymmetry": {"random": [-0.4, -0.3]}, "absorption": 2})");
  ASSERT_TRUE(loaded) << loaded.error().message();
  const Groom& groom = loaded->grooms[0];
  ASSERT_EQ(groom.stations_a_segment, 16u);
  const float degree = 0.01745329f;
  for (const float place : {0.0f, 0.5f, 1.0f, 2.0f}) {
    const fiber::FiberParameters& fiber = loaded->fibers[groom.fiber_at(groom.station_at(0, place, 0), 0)];
    // Each is one step away at most: 0.5 degrees, 0.05, and a factor of 1.2.
    EXPECT_NEAR(fiber.tilt, (2.2f + 3 * place) * degree, 0.5f * degree) << place;
    EXPECT_NEAR(fiber.medulla_radius, 0.4f * place, 0.05f) << place;
    EXPECT_NEAR(fiber.medulla_scattering, 5 * place, place + 1e-4f) << place;
    EXPECT_NEAR(fiber.medulla_asymmetry, -0.35f, 0.1f) << place;
    EXPECT_EQ(fiber.medulla_absorption, 2) << place;
    EXPECT_EQ(fiber.eccentricity, 0.85f) << place;
  }
  for (const fiber::FiberParameters& fiber : loaded->fibers) {
    EXPECT_NEAR(2 * fiber.tilt / degree, std::round(2 * fiber.tilt / degree), 1e-3f);
    EXPECT_NEAR(20 * fiber.medulla_radius, std::round(20 * fiber.medulla_radius), 1e-3f);
    EXPECT_EQ(fiber::out_of_range(fiber), nullptr);
  }
}

TEST_F(SourceFiles, ThicknessMultipliesTheRadiiOfPoints) {
  const auto plain = groom(R"("hair": "brown")"), one = groom(R"("thickness": 1)"), twice = groom(R"("thickness": 2)"),
             ramp = groom(R"("thickness": {"root": 1, "tip": 0.25})"),
             attribute = groom(R"("thickness": {"attribute": "dye"})"),
             end = groom(R"("thickness": {"ramp": [[0.5, 3], [1.5, 0]], "along": "tip_cm"})");
  ASSERT_EQ(plain.radius_cm, std::vector<float>(6, 0.005f));
  EXPECT_EQ(one.radius_cm, plain.radius_cm);
  EXPECT_EQ(twice.radius_cm, std::vector<float>(6, 0.01f));
  for (std::size_t i = 0; i < 6; ++i) {
    const float share = float(i % 3) / 2;
    EXPECT_FLOAT_EQ(ramp.radius_cm[i], 0.005f * (1 - 0.75f * share)) << i;
    EXPECT_FLOAT_EQ(attribute.radius_cm[i], i % 3 == 0 ? 0.005f : 0) << i;
    EXPECT_FLOAT_EQ(end.radius_cm[i], i % 3 == 0 ? 0 : i % 3 == 1 ? 0.0075f : 0.015f) << i;
  }
  EXPECT_EQ(ramp.stations_a_segment, 0u);  // its fibers do not vary
  EXPECT_NE(refusal(R"("thickness": {"attribute": "thick"})").find("hair.usda: attribute \"thick\""),
            std::string::npos);
  EXPECT_NE(refusal(R"("thickness": {"root": 1})").find("/materials/0/thickness/tip: expected this key"),
            std::string::npos);
  EXPECT_NE(refusal(R"("thickness": {"root": 1, "tip": 11})").find("/materials/0/thickness/tip: expected 0..10"),
            std::string::npos);
}

TEST_F(SourceFiles, GiveWayToOptions) {
  ASSERT_TRUE(scene(R"("eccentricity": {"random": [0.6, 0.9]}, "tilt_deg": {"root": 1, "tip": 9})"));
  Overrides overrides;
  overrides.eccentricity = 0.7f;
  overrides.tilt_deg = 4;
  const auto loaded = load_scene(folder_ / "s.json", overrides);
  ASSERT_TRUE(loaded) << loaded.error().message();
  ASSERT_EQ(loaded->fibers.size(), 1u);
  EXPECT_EQ(loaded->fibers[0].eccentricity, 0.7f);
  EXPECT_FLOAT_EQ(loaded->fibers[0].tilt, 4 * 0.01745329f);
}

TEST_F(SourceFiles, WarnOfWhatOfRenderMansHairIsLeftOut) {
  const auto loaded = scene(R"("marschner": {"diffuseGain": 0.5, "shadowColor": [1, 0, 0]})");
  ASSERT_TRUE(loaded) << loaded.error().message();
  ASSERT_FALSE(loaded->warnings.empty());
  EXPECT_EQ(loaded->warnings[0], "material m: left out, as fibers have nothing of the kind: diffuseGain, shadowColor");
}

TEST_F(SourceFiles, GainsAndTintsOfLobesVaryAndKeepOne) {
  const auto loaded =
      scene(R"("gain": {"R": {"root": 1, "tip": 0}, "TT": 0.5}, "tint": {"TRT": {"attribute": "dye"}})");
  ASSERT_TRUE(loaded) << loaded.error().message();
  const Groom& groom = loaded->grooms[0];
  const auto gain = [&](std::size_t lobe, float place) {
    return loaded->fibers[groom.fiber_at(groom.station_at(1, place, 0), 0)].gain[lobe];
  };
  EXPECT_EQ(gain(0, 0), glm::vec3(1));
  EXPECT_NEAR(gain(0, 1).x, 0.5f, 0.1f);  // a step of 1.2
  EXPECT_EQ(gain(0, 2), glm::vec3(0));
  for (const float place : {0.0f, 1.0f, 2.0f}) {
    EXPECT_EQ(gain(1, place), glm::vec3(0.5f));
    EXPECT_EQ(gain(2, place), glm::vec3(place == 0, place == 1, place == 2));
    EXPECT_EQ(gain(5, place), gain(2, place)) << "GLINT is part of TRT";
    EXPECT_EQ(gain(3, place), glm::vec3(1));
  }
  EXPECT_EQ(scene(R"("gain": {"R": {"ramp": [[0.5, 0.3]]}})")->fibers, scene(R"("gain": {"R": 0.3})")->fibers);
  EXPECT_NE(refusal(R"("gain": {"R": {"attribute": "shine"}})").find("hair.usda: attribute \"shine\""),
            std::string::npos);
}

TEST_F(SourceFiles, EccentricityVariesByStrandOnly) {
  const auto loaded = scene(R"("eccentricity": {"mix": [0.6, 0.9], "share": {"attribute": "mask"}},
                               "tilt_deg": {"ramp": [[0, 2], [1, 8]]})");
  ASSERT_TRUE(loaded) << loaded.error().message();
  const Groom& groom = loaded->grooms[0];
  for (const std::uint32_t strand : {0u, 1u})
    for (const float place : {0.0f, 1.3f, 2.0f})  // the shape of the strand is that of its root
      EXPECT_NEAR(loaded->fibers[groom.fiber_at(groom.station_at(strand, place, 0), 0)].eccentricity,
                  strand == 0 ? 0.675f : 0.825f, 0.01f);
  for (const char* along :
       {R"({"ramp": [[0, 0.6], [1, 0.9]]})", R"({"mix": [0.6, 0.9], "share": {"attribute": "dye"}})"}) {
    const std::string message = refusal(R"("eccentricity": )" + std::string(along));
    EXPECT_NE(message.find("s.json: /materials/0/eccentricity: expected one eccentricity for the whole of a strand"),
              std::string::npos)
        << message;
  }
  EXPECT_NE(refusal(R"("eccentricity": {"attribute": "round"})").find("hair.usda: attribute \"round\""),
            std::string::npos);
}

}  // namespace
}  // namespace tress::scene
