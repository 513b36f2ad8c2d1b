// Strands of every format: the same in all, points of every curve as textbooks have them, what cannot be is refused.
// The files are made by tests/scene/grooms/make_fixtures.py.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "scene/groom_fixture.h"
#include "scene/read/groom_files.h"
#include "scene/read/groom_writers.h"
#include "scene/read/grooms/curve_bases.h"
#include "scene/read/load_scene.h"

namespace tress::scene {
namespace {

namespace fs = std::filesystem;

GroomFile read(const fs::path& file) {
  auto groom = read_groom_file(file);
  EXPECT_TRUE(groom) << groom.error().message();
  return groom ? std::move(*groom) : GroomFile{};
}

struct OnCurve {
  glm::vec3 point{0.0f};
  float width = 0;
  glm::vec3 color{0.0f};
};

/// On one segment of a strand as it is drawn.
OnCurve at(const GroomFile& groom, std::size_t strand, std::size_t segment, float t) {
  const StrandBasis basis = groom.basis.value_or(StrandBasis::bspline);
  const std::int64_t begin = groom.first_point[strand], end = groom.first_point[strand + 1];
  const auto vertex = [&](std::int64_t i) -> OnCurve {
    const auto get = [&](std::int64_t k) {
      const auto i = static_cast<std::size_t>(k);
      return OnCurve{groom.points[i], groom.width_at(i), groom.color_at(strand, i)};
    };
    if (i >= begin && i < end) return get(i);
    const OnCurve a = get(i < begin ? begin : end - 1), b = get(i < begin ? begin + 1 : end - 2);
    return {2.0f * a.point - b.point, 2 * a.width - b.width, 2.0f * a.color - b.color};
  };
  const float s = 1 - t;
  std::vector<float> weights{s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6,
                             (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6, t * t * t / 6};
  std::int64_t first = begin + static_cast<std::int64_t>(segment) - (basis == StrandBasis::bspline ? 1 : 0);
  if (basis == StrandBasis::linear) weights = {s, t};
  if (basis == StrandBasis::bezier) {
    weights = {s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t};
    first = begin + 3 * static_cast<std::int64_t>(segment);
  }
  OnCurve sum;
  for (std::size_t k = 0; k < weights.size(); ++k) {
    const OnCurve v = vertex(first + static_cast<std::int64_t>(k));
    sum.point += weights[k] * v.point;
    sum.width += weights[k] * v.width;
    sum.color += weights[k] * v.color;
  }
  return sum;
}

TEST(GroomFormats, TheSameStrandsInEveryFormat) {
  const GroomFile hair = read(fixture("same.hair"));
  ASSERT_EQ(hair.strand_count(), 9u);
  for (const char* name :
       {"same.usda", "same.abc", "same.pbrt", "same.data", "same.ply", "same_big.ply", "same_little.ply"}) {
    const GroomFile other = read(fixture(name));
    ASSERT_EQ(other.strand_count(), 9u) << name;
    const bool has_widths = std::string(name) != "same.data";
    for (std::size_t s = 0; s < 9; ++s)
      for (std::size_t segment = 0; segment < 8; ++segment)
        for (const float t : {0.0f, 0.375f, 1.0f}) {
          const OnCurve a = at(hair, s, segment, t), b = at(other, s, segment, t);
          EXPECT_LT(glm::distance(b.point, a.point), 1e-6f) << name << " " << s << " " << segment;
          EXPECT_NEAR(b.width, has_widths ? a.width : 0, 1e-7f) << name << " " << s << " " << segment;
        }
  }
}

TEST(GroomFormats, EveryBasisWrapAndInterpolationAsTextbooksHaveThem) {
  std::ifstream stream(fixture("bases/expected.txt"));
  std::map<std::string, GroomFile> files;
  std::string line;
  int rows = 0;
  while (std::getline(stream, line)) {
    if (line.starts_with("#")) continue;
    std::istringstream words(line);
    std::string file, prim;
    std::size_t curve = 0, segment = 0;
    float t = 0, x = 0, y = 0, z = 0, width = 0;
    ASSERT_TRUE(words >> file >> prim >> curve >> segment >> t >> x >> y >> z >> width) << line;
    if (!files.contains(file)) files[file] = read(fixture("bases/" + file));
    const GroomFile& groom = files[file];
    std::size_t strand = 0;
    for (const GroomPart& part : groom.parts) {
      if (part.name == "/Groom/" + prim) break;
      strand += part.strands;
    }
    ASSERT_LT(strand + curve, groom.strand_count()) << line;
    const OnCurve found = at(groom, strand + curve, segment, t);
    EXPECT_LT(glm::distance(found.point, glm::vec3(x, y, z)), 1e-6f) << line;
    EXPECT_NEAR(found.width, width, 1e-6f) << line;
    EXPECT_LT(glm::distance(found.color, glm::vec3(width, width / 2, 1 - width)), 1e-6f) << line;
    ++rows;
  }
  EXPECT_EQ(files.size(), 12u);
  EXPECT_GT(rows, 600);
}

TEST(GroomFormats, CurvesOfSeveralBasesBecomeBezierSegmentsExactly) {
  for (const StrandBasis basis : {StrandBasis::linear, StrandBasis::bspline, StrandBasis::open_bspline}) {
    GroomFile groom, bezier;
    groom.basis = basis;
    groom.first_point = {0, 5};
    groom.points = {{0, 0, 0}, {1, 2, -1}, {0.5f, 3, -2}, {0, 1, -3}, {2, 0, -4}};
    groom.width = {0.5f, 0.25f, 0.5f, 0.125f, 0.25f};
    bezier.basis = StrandBasis::bezier;
    bezier.points = as_bezier<glm::vec3>(basis, groom.first_point, groom.points);
    bezier.width = as_bezier<float>(basis, groom.first_point, groom.width);
    bezier.first_point = {0, static_cast<std::uint32_t>(bezier.points.size())};
    const std::size_t segments = basis == StrandBasis::open_bspline ? 2 : 4;
    ASSERT_EQ(bezier.points.size(), 3 * segments + 1);
    for (std::size_t i = 0; i < segments; ++i)
      for (const float t : {0.0f, 0.25f, 0.75f, 1.0f}) {
        EXPECT_LT(glm::distance(at(groom, 0, i, t).point, at(bezier, 0, i, t).point), 2e-6f);
        EXPECT_NEAR(at(groom, 0, i, t).width, at(bezier, 0, i, t).width, 2e-7f);
      }
  }
}

TEST(GroomFormats, CountsOfSegmentsAndVaryingValuesAsUsdHasThem) {
  const CurveKind bspline{CurveBasis::bspline, CurveWrap::nonperiodic},
      bezier{CurveBasis::bezier, CurveWrap::nonperiodic};
  const std::vector<std::uint64_t> of_bspline{5, 4, 6, 7}, of_bezier{4, 7, 10, 4, 7};
  const std::vector<std::uint64_t> bspline_segments{2, 1, 3, 4}, bezier_segments{1, 2, 3, 1, 2};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(segments_of(bspline, of_bspline[i]), bspline_segments[i]);
    EXPECT_EQ(varying_of(bspline, of_bspline[i]), bspline_segments[i] + 1);
  }
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(segments_of(bezier, of_bezier[i]), bezier_segments[i]);
    EXPECT_EQ(varying_of(bezier, of_bezier[i]), bezier_segments[i] + 1);
  }
  EXPECT_EQ(varying_of({CurveBasis::bezier, CurveWrap::periodic}, 9), 3u);
  EXPECT_EQ(fault_of(bezier, 5), "3 n + 1");
  EXPECT_EQ(fault_of({CurveBasis::bezier, CurveWrap::periodic}, 7), "a multiple of 3");
}

TEST(GroomFormats, AlembicKeepsIdsAndRootsAndLeavesGuidesOut) {
  const GroomFile groom = read(fixture("same.abc"));
  ASSERT_EQ(groom.id.size(), 9u);
  EXPECT_EQ(groom.id[8], 8);
  ASSERT_EQ(groom.root_uv.size(), 9u);
  EXPECT_EQ(groom.root_uv[2], glm::vec2(0.125f, 0.5f));
  EXPECT_EQ(groom.basis, StrandBasis::open_bspline);
  std::string ignored;
  for (const IgnoredAttribute& one : groom.ignored) ignored += one.name + ": " + one.why + "\n";
  EXPECT_NE(ignored.find("groom_closest_guides"), std::string::npos) << ignored;
  EXPECT_NE(ignored.find("/turned/guides: its curves are guides"), std::string::npos) << ignored;
}

TEST(GroomFormats, PbrtSaysItsMaterialInTheWordsOfTheCommandLine) {
  const GroomFile groom = read(fixture("same.pbrt"));
  ASSERT_EQ(groom.materials.size(), 1u);
  EXPECT_NE(groom.materials[0].find("--sigma-a 0.1,0.2,0.4"), std::string::npos) << groom.materials[0];
  ASSERT_EQ(groom.ignored.size(), 1u);
  EXPECT_NE(groom.ignored[0].name.find("sphere"), std::string::npos);
}

TEST(GroomFormats, PbrtsMaterialsAreListedOnceTheirColorsAreRead) {
  const std::pair<std::string, std::string> materials[] = {
      {R"("float eumelanin" [ 0.3 ])", "hair: --melanin 0.3,0 --set 'materials/*/eccentricity=1'; eta 1.55"},
      {R"("rgb reflectance" [ 0.5 0.25 0.125 ])", "hair: --color 0.5,0.25,0.125 --set 'materials/*/eccentricity=1'"},
      {"", "hair: --melanin 1.3,0 --set 'materials/*/eccentricity=1'"},
      {R"("spectrum sigma_a" [ 400 0.1 700 0.2 ])", "hair: a color that is not rgb, which is not read; --set"},
      {R"("texture reflectance" "roots")", "hair: a color that is not rgb"}};
  for (const auto& [said, listed] : materials) {
    const fs::path file = fs::path(::testing::TempDir()) / "tress_material.pbrt";
    std::ofstream(file) << "WorldBegin\nMaterial \"hair\" " << said
                        << "\nShape \"curve\" \"point3 P\" [ 0 0 0 0 0 -1 0 0 -2 0 0.5 -3 ]\n";
    const GroomFile groom = read(file);
    ASSERT_EQ(groom.materials.size(), 1u) << said;
    EXPECT_EQ(groom.materials[0].find(listed), 0u) << groom.materials[0];
    fs::remove(file);
  }
}

/// A render takes the materials of the scene: those of the file are named, not dropped in silence.
TEST(GroomFormats, ARenderNamesTheMaterialsOfAFileThatItDoesNotUse) {
  const auto scene = load_scene(fixture("same.pbrt"));
  ASSERT_TRUE(scene) << scene.error().message();
  std::string notes;
  for (const std::string& note : scene->notes) notes += note + "\n";
  EXPECT_NE(notes.find("material of the file, not used: hair: --sigma-a 0.1,0.2,0.4"), std::string::npos) << notes;
}

TEST(GroomFormats, WhatIsMalformedIsRefusedByItsNameAndWhy) {
  std::ifstream stream(fixture("malformed/expected.txt"));
  std::string line;
  int files = 0;
  while (std::getline(stream, line)) {
    const std::size_t tab = line.find('\t');
    ASSERT_NE(tab, std::string::npos);
    const auto groom = read_groom_file(fixture("malformed/" + line.substr(0, tab)));
    ASSERT_FALSE(groom) << line;
    const std::string said = groom.error().message();
    EXPECT_NE(said.find(line.substr(0, tab)), std::string::npos) << said;
    EXPECT_NE(said.find(line.substr(tab + 1)), std::string::npos) << said << "\nwanted: " << line;
    ++files;
  }
  EXPECT_GE(files, 55);
}

/// Whole as far as the first sample goes, which is all that `tress info` reads.
TEST(GroomFormats, WhatIsMalformedAtALaterFrameIsRefusedThere) {
  for (const char* name : {"timed_samples_of_255.abc", "timed_later_sample_cut.abc"}) {
    const fs::path file = fixture(std::string("malformed/") + name);
    EXPECT_TRUE(read_groom_file(file)) << name;
    const auto groom = read_groom_file(file, {}, 1000.0);
    ASSERT_FALSE(groom) << name;
    EXPECT_NE(groom.error().message().find("children"), std::string::npos) << groom.error().message();
  }
}

TEST(GroomFormats, EveryTruncationIsRefusedOrRead) {
  for (const char* name : {"same.abc", "same.usda", "same.pbrt", "same.data", "same_little.ply"}) {
    std::ifstream stream(fixture(name), std::ios::binary);
    const std::string whole((std::istreambuf_iterator<char>(stream)), {});
    const fs::path file = fs::path(testing::TempDir()) / ("tress_cut_" + std::string(name));
    for (std::size_t size = 1; size < whole.size(); size += 1 + whole.size() / 97) {
      std::ofstream(file, std::ios::binary) << whole.substr(0, size);
      const auto groom = read_groom_file(file);
      EXPECT_TRUE(groom || groom.error().message().find("tress_cut_") != std::string::npos) << size;
    }
    fs::remove(file);
  }
}

TEST(GroomFormats, ConvertedStrandsAreTheSame) {
  for (const char* name :
       {"same.hair", "same.usda", "same.abc", "same.pbrt", "bases/catmullRom_pinned.usda",
        "bases/bezier_nonperiodic.usda", "bases/linear_periodic.usda", "bases/bspline_periodic.usda"}) {
    const GroomFile groom = read(fixture(name));
    const fs::path file = fs::path(testing::TempDir()) / "tress_converted.usda";
    std::vector<std::string> notes;
    const auto error = write_groom_file(groom, file, &notes);
    ASSERT_FALSE(error) << error->message();
    const GroomFile again = read(file);
    EXPECT_EQ(again.points, groom.points) << name;
    EXPECT_EQ(again.first_point, groom.first_point) << name;
    EXPECT_EQ(again.id, groom.id) << name;
    EXPECT_EQ(again.root_uv, groom.root_uv) << name;
    for (std::size_t i = 0; i < groom.points.size(); ++i) ASSERT_EQ(again.width_at(i), groom.width_at(i)) << name;
    EXPECT_EQ(again.basis, groom.basis.value_or(StrandBasis::bspline)) << name;
    fs::remove(file);
  }
}

TEST(GroomFormats, HairHasPointsOnTheCurvesOfOtherBases) {
  const GroomFile groom = read(fixture("bases/catmullRom_pinned.usda"));
  const fs::path file = fs::path(testing::TempDir()) / "tress_converted.hair";
  std::vector<std::string> notes;
  ASSERT_FALSE(write_groom_file(groom, file, &notes));
  const GroomFile again = read(file);
  ASSERT_EQ(again.strand_count(), groom.strand_count());
  for (std::size_t s = 0; s < again.strand_count(); ++s)
    for (std::uint32_t i = again.first_point[s]; i + 1 < again.first_point[s + 1]; ++i) {
      const std::uint32_t of_strand = i - again.first_point[s];
      const OnCurve expected = at(groom, s, of_strand / 4, static_cast<float>(of_strand % 4) / 4);
      EXPECT_LT(glm::distance(again.points[i], expected.point), 1e-6f);
      EXPECT_NEAR(again.width_at(i), expected.width, 1e-6f);
    }
  fs::remove(file);
}

TEST(GroomFormats, AGroomCanBeScaledTurnedAndMoved) {
  const fs::path folder = fs::path(testing::TempDir()) / "tress_moved";
  fs::create_directories(folder);
  fs::copy_file(fixture("same.usda"), folder / "a.usda", fs::copy_options::overwrite_existing);
  std::ofstream(folder / "scene.json") << R"({"grooms": [{"file": "a.usda"},
      {"file": "a.usda", "scale": 2, "rotate_deg": [0, 0, 90], "translate": [10, 0, 0]}]})";
  const auto scene = load_scene(folder / "scene.json");
  ASSERT_TRUE(scene) << scene.error().message();
  ASSERT_EQ(scene->grooms.size(), 2u);
  for (std::size_t i = 0; i < scene->grooms[0].points.size(); ++i) {
    const glm::vec3 p = scene->grooms[0].points[i], q = scene->grooms[1].points[i];
    EXPECT_LT(glm::distance(q, glm::vec3(10 - 2 * p.y, 2 * p.x, 2 * p.z)), 1e-5f);
    EXPECT_FLOAT_EQ(scene->grooms[1].radius_cm[i], 2 * scene->grooms[0].radius_cm[i]);
  }
  fs::remove_all(folder);
}

}  // namespace
}  // namespace tress::scene
