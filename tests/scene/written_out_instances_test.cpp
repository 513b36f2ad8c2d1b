// Instances that files hold: they are the same strands as written out, and share them. What files say of them is used,
// named, or an error.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <glm/ext/matrix_transform.hpp>
#include <glm/ext/vector_double4.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "scene/groom_fixture.h"
#include "scene/read/groom_files.h"
#include "scene/read/grooms/groom_formats.h"
#include "scene/read/grooms/usd_file.h"
#include "scene/read/load_scene.h"
#include "scene/read/scene_strands.h"
#include "scene/read/shared_strands.h"
#include "tress/base/random.h"

namespace tress::scene::file_instances {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

namespace fs = std::filesystem;

fs::path written(const std::string& name, const std::string& text) {
  const fs::path file = fs::path(testing::TempDir()) / name;
  std::ofstream(file, std::ios::binary) << text;
  return file;
}

Scene loaded(const fs::path& file, const Overrides& overrides = {}) {
  auto scene = load_scene(file, overrides);
  EXPECT_TRUE(scene) << scene.error().message();
  return scene ? std::move(*scene) : Scene();
}

std::string error_of(const std::string& name, const std::string& text) {
  const auto groom = read_groom_file(written(name, text));
  return groom ? "" : groom.error().message();
}

std::vector<std::string> ignored(const GroomFile& groom) {
  std::vector<std::string> names;
  for (const IgnoredAttribute& one : groom.ignored) names.push_back(one.name + ": " + one.why);
  return names;
}

struct Strand {
  std::vector<glm::dvec3> points;
  double width;
};

Strand at(const glm::dmat4& place, double scale, Strand strand) {
  for (glm::dvec3& point : strand.points) point = glm::dvec3(place * glm::dvec4(point, 1));
  strand.width *= scale;
  return strand;
}

/// Strands of a prototype, of points that a float has exactly.
std::vector<Strand> tuft(std::uint64_t seed, std::size_t count) {
  RandomStream random(seed, 1);
  std::vector<Strand> strands(count);
  for (Strand& strand : strands) {
    const auto number = [&random] { return std::floor(1024 * random.next()) / 256 - 2; };
    for (int i = 0; i < 4; ++i) strand.points.emplace_back(number(), number(), number());
    strand.width = (1 + std::floor(7 * random.next())) / 256;
  }
  return strands;
}

std::string triple(const glm::dvec3& v) { return fmt::format("({}, {}, {})", v.x, v.y, v.z); }

std::string curves(const std::string& name, const std::vector<Strand>& strands, const std::string& more = "") {
  std::vector<std::string> points;
  std::vector<double> widths;
  for (const Strand& strand : strands) {
    for (const glm::dvec3& point : strand.points) points.push_back(triple(point));
    widths.push_back(strand.width);
  }
  return fmt::format(
      "def BasisCurves \"{}\" {{ uniform token type = \"linear\" int[] curveVertexCounts = {} point3f[] points = [{}] "
      "float[] widths = {} (interpolation = \"uniform\") {} }}\n",
      name, std::vector<std::size_t>(strands.size(), 4), fmt::join(points, ", "), widths, more);
}

const std::string usda = "#usda 1.0\n(metersPerUnit = 0.01 upAxis = \"Z\")\n";

/// Compares the strands of a scene with those that are expected, in any order. Floats of coordinates up to 40 are
/// rounded to 2e-6, by the file, by the place of the first instance, by matrices and by the result.
void expect_strands(const Scene& scene, std::vector<Strand> expected, double within = 2e-5) {
  const auto strands = strands_of(scene);
  ASSERT_TRUE(strands) << strands.error().message();
  ASSERT_EQ(strands->strand_count(), expected.size());
  for (std::size_t s = 0; s < strands->strand_count(); ++s) {
    const std::uint32_t begin = strands->first_point[s], end = strands->first_point[s + 1];
    const auto found = std::ranges::find_if(expected, [&](const Strand& strand) {
      bool is_same = strand.points.size() == end - begin;
      for (std::uint32_t i = begin; i < end && is_same; ++i)
        is_same = glm::distance(strand.points[i - begin], glm::dvec3(strands->points[i])) < within &&
                  std::abs(strand.width - double{strands->width_at(i)}) < 1e-5 * strand.width;
      return is_same;
    });
    ASSERT_NE(found, expected.end()) << "strand " << s << " is not expected";
    expected.erase(found);
  }
}

/// A rotation by a random angle about a random axis, and its quaternion as a text.
std::pair<glm::dmat4, std::string> random_turn(RandomStream& random) {
  const glm::dvec3 axis = glm::normalize(glm::dvec3(random.next(), random.next(), random.next()) - 0.4);
  const double angle = 6 * double{random.next()};
  const glm::dvec3 v = std::sin(angle / 2) * axis;
  return {glm::rotate(glm::dmat4(1.0), angle, axis),
          fmt::format("({}, {}, {}, {})", std::cos(angle / 2), v.x, v.y, v.z)};
}

/// An instancer of two prototypes, one of which has two sets of curves and a transform of its own.
struct Instancer {
  std::string text;
  std::vector<Strand> strands;
  std::size_t seen = 0;

  explicit Instancer(std::uint64_t seed, std::size_t count, const std::string& orientations = "quatf[] orientationsf") {
    RandomStream random(seed, 2);
    const std::vector<Strand> a = tuft(seed, 3), b = tuft(seed + 1, 2), c = tuft(seed + 2, 1);
    const glm::dmat4 own = glm::scale(glm::translate(glm::dmat4(1.0), {1, 0, 2}), glm::dvec3(0.5)),
                     all = glm::translate(glm::dmat4(1.0), {0, 8, 0});
    std::vector<int> indices, ids, invisible, inactive;
    std::vector<std::string> positions, turns, scales;
    for (std::size_t i = 0; i < count; ++i) {
      const glm::dvec3 position = 16.0 * glm::dvec3(random.next(), random.next(), random.next());
      const double scale = 0.5 + double{random.next()};
      const auto [turn, words] = random_turn(random);
      indices.push_back(static_cast<int>(2 * random.next()));
      ids.push_back(1000 - 3 * static_cast<int>(i));
      positions.push_back(triple(position));
      turns.push_back(words);
      scales.push_back(triple(glm::dvec3(scale)));
      if (i % 5 == 3) invisible.push_back(ids.back());
      if (i % 7 == 4) inactive.push_back(ids.back());
      if (i % 5 == 3 || i % 7 == 4) continue;
      ++seen;
      const glm::dmat4 place = glm::scale(all * glm::translate(glm::dmat4(1.0), position) * turn, glm::dvec3(scale));
      if (indices.back() == 0) {
        for (const Strand& strand : a) strands.push_back(at(place, scale, strand));
      } else {
        for (const std::vector<Strand>& set : {b, c})
          for (const Strand& strand : set) strands.push_back(at(place * own, 0.5 * scale, strand));
      }
    }
    text = fmt::format(
        "def PointInstancer \"i\" (inactiveIds = {}) {{\n double3 xformOp:translate = (0, 8, 0) uniform token[] "
        "xformOpOrder = [\"xformOp:translate\"]\n rel prototypes = [</i/A>, </i/B>]\n int[] protoIndices = {}\n "
        "point3f[] positions = [{}]\n {} = [{}]\n float3[] scales = [{}]\n int64[] ids = {}\n int64[] invisibleIds = "
        "{}\n{} def Xform \"B\" {{ double3 xformOp:translate = (1, 0, 2) double3 xformOp:scale = (0.5, 0.5, 0.5) "
        "uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:scale\"]\n{}{} }} }}\n",
        inactive, indices, fmt::join(positions, ", "), orientations, fmt::join(turns, ", "), fmt::join(scales, ", "),
        ids, invisible, curves("A", a), curves("b", b), curves("c", c));
  }
};

TEST(FileInstances, OfAUsdInstancerAreItsStrandsWrittenOut) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Instancer given(seed, 40);
    const Scene scene = loaded(written("i.usda", usda + given.text));
    expect_strands(scene, given.strands);
    ASSERT_EQ(scene.grooms.size(), 2u) << "one for each prototype";
    EXPECT_EQ(scene.grooms[0].instances.size() + scene.grooms[1].instances.size(), given.seen);
    EXPECT_EQ(scene.grooms[0].strand_count() + scene.grooms[1].strand_count(), 6u);
    for (const Groom& groom : scene.grooms) EXPECT_EQ(groom.object, "i");
  }
  // Half floats of up to 1 are rounded to 2.4e-4, and the strands reach 6 times 1.5 cm.
  const Instancer halves(4, 40, "quath[] orientations");
  expect_strands(loaded(written("i.usda", usda + halves.text)), halves.strands, 5e-3);
}

TEST(FileInstances, TakeTheMemoryOfOneAndOfTheirPlaces) {
  const Instancer given(5, 1000);
  const auto groom = read_groom_file(written("i.usda", usda + given.text));
  ASSERT_TRUE(groom) << groom.error().message();
  EXPECT_EQ(groom->strand_count(), 6u);
  EXPECT_EQ(groom->points.size(), 24u);
  ASSERT_EQ(groom->parts.size(), 3u);
  EXPECT_EQ(groom->parts[0].instances + groom->parts[1].instances, given.seen);
  GroomFile all = *groom;
  EXPECT_FALSE(write_out("i.usda", &all));
  EXPECT_EQ(all.strand_count(), given.strands.size());
  EXPECT_TRUE(all.shared.empty());
}

TEST(FileInstances, AreInstancesOfTheScenesInstances) {
  const Instancer given(6, 12);
  written("i.usda", usda + given.text);
  const fs::path file = written(
      "i.json",
      R"({"camera": {"frame": true}, "grooms": [{"file": "i.usda", "translate": [1, 0, 0], "instances": [{"scale": 2}, {"translate": [0, 0, 40]}]}]})");
  std::vector<Strand> all;
  for (const Strand& strand : given.strands) {
    const glm::dmat4 moved = glm::translate(glm::dmat4(1.0), {1, 0, 0});
    all.push_back(at(glm::scale(glm::dmat4(1.0), glm::dvec3(2.0)) * moved, 2, strand));
    all.push_back(at(glm::translate(glm::dmat4(1.0), {1, 0, 40}), 1, strand));
  }
  expect_strands(loaded(file), all, 4e-5);
}

TEST(FileInstances, MayBeInOneAnother) {
  const std::vector<Strand> a = tuft(7, 2);
  const std::string inner =
      "def PointInstancer \"in\" { rel prototypes = </o/P/in/A> int[] protoIndices = [0, 0] point3f[] positions = [(1, "
      "0, 0), (0, 2, 0)]\n" +
      curves("A", a) + "}\n";
  const Scene scene = loaded(written(
      "n.usda",
      usda +
          "def PointInstancer \"o\" { rel prototypes = [</o/P>] int[] protoIndices = [0, 0, 0] point3f[] positions = "
          "[(0, 0, 0), (0, 0, 10), (0, 0, 20)]\n def Xform \"P\" {\n" +
          inner + "} }\n"));
  std::vector<Strand> all;
  for (int i = 0; i < 3; ++i)
    for (const glm::dvec3 place : {glm::dvec3(1, 0, 10 * i), glm::dvec3(0, 2, 10 * i)})
      for (const Strand& strand : a) all.push_back(at(glm::translate(glm::dmat4(1.0), place), 1, strand));
  expect_strands(scene, all);
  ASSERT_EQ(scene.grooms.size(), 1u);
  EXPECT_EQ(scene.grooms[0].instances.size(), 6u);
}

TEST(FileInstances, OfAStretchedPrototypeShareIt) {
  const std::vector<Strand> a = tuft(20, 2);
  const Scene scene = loaded(written(
      "p.usda", usda +
                    "def PointInstancer \"i\" { rel prototypes = [</i/P>] int[] protoIndices = [0, 0] point3f[] "
                    "positions = [(0, 0, 0), (6, 0, 0)]\n def Xform \"P\" { double3 xformOp:scale = (1, 1, 3) uniform "
                    "token[] xformOpOrder = [\"xformOp:scale\"]\n" +
                    curves("A", a) + "} }\n"));
  std::vector<Strand> all;
  for (const double x : {0, 6})
    for (const Strand& strand : a)
      all.push_back(at(glm::scale(glm::translate(glm::dmat4(1.0), {x, 0, 0}), {1, 1, 3}), std::cbrt(3.0), strand));
  expect_strands(scene, all);
  EXPECT_EQ(scene.grooms[0].instances.size(), 2u);
}

TEST(FileInstances, OfPrimsThatReferToOneShareIt) {
  const std::vector<Strand> a = tuft(8, 3);
  const auto instance = [](const std::string& name, const std::string& more) {
    return fmt::format(
        "def Xform \"{}\" (instanceable = true references = </Proto>) {{ double3 xformOp:translate = (0, {}, 0) {} "
        "}}\n",
        name, name.substr(1),
        more + " float3[] extentsHint = [(0, 0, 0), (1, 1, 1)] string userProperties:by = \"me\"");
  };
  const std::string order = "uniform token[] xformOpOrder = [\"xformOp:translate\"]",
                    scaled =
                        "double3 xformOp:scale = (1, 1, -2) uniform token[] xformOpOrder = [\"xformOp:translate\", "
                        "\"xformOp:scale\"]";
  const std::string text = usda + instance("x5", order) + instance("x9", order) + instance("x2", scaled) +
                           instance("x7", order) + "over \"Proto\" {\n" + curves("h", a) + "}\n";
  const Scene scene = loaded(written("r.usda", text));
  std::vector<Strand> all;
  for (const Strand& strand : a) {
    for (const double y : {5, 9, 7}) all.push_back(at(glm::translate(glm::dmat4(1.0), {0, y, 0}), 1, strand));
    all.push_back(at(glm::scale(glm::translate(glm::dmat4(1.0), {0, 2, 0}), {1, 1, -2}), std::cbrt(2.0), strand));
  }
  expect_strands(scene, all);
  ASSERT_EQ(scene.grooms.size(), 2u) << "what is stretched is a copy";
  EXPECT_EQ(scene.grooms[1].instances.size(), 3u);
  EXPECT_THAT(scene.notes, Contains(HasSubstr("mirrored, or stretched unevenly, are copies")));
}

TEST(FileInstances, OfPrimsWithAttributesOfTheirOwnShareNothing) {
  const auto text = [](const std::string& more) {
    return usda + "def Xform \"a\" (references = </Proto>) { }\ndef Xform \"b\" (references = </Proto>) { " + more +
           " }\nover \"Proto\" {\n" + curves("h", tuft(8, 3)) + "}\n";
  };
  EXPECT_EQ(loaded(written("r.usda", text(""))).grooms[0].instances.size(), 2u);
  for (const char* more : {"color3f[] primvars:displayColor = [(1, 0, 0)]",
                           "over \"h\" { float[] widths = [0.5] ( interpolation = "
                           "\"constant\" ) }"})
    EXPECT_TRUE(loaded(written("r.usda", text(more))).grooms[0].instances.empty()) << more;
}

TEST(FileInstances, MoveWithTheirTimeSamples) {
  const std::string text =
      usda +
      "def PointInstancer \"i\" { rel prototypes = [</i/A>] int[] protoIndices = [0, 0]\n point3f[] "
      "positions.timeSamples = { 0: [(0, 0, 0), (5, 0, 0)], 10: [(0, 0, 10), (5, 0, 20)] }\n quatf[] "
      "orientationsf.timeSamples = { 0: [(1, 0, 0, 0), (1, 0, 0, 0)], 10: [(-0.70710678, 0, 0, -0.70710678), (1, "
      "0, 0, 0)] }\n" +
      curves("A", tuft(9, 2)) + "}\n";
  Overrides overrides;
  overrides.frame = 10;
  const Scene last = loaded(written("m.usda", text), overrides);
  const glm::mat3 quarter(0, 1, 0, -1, 0, 0, 0, 0, 1);
  ASSERT_EQ(last.grooms[0].instances.size(), 2u);
  // Places are counted from the first, which turns by a quarter about z.
  const Similarity first = last.grooms[0].instances[0].first, second = last.grooms[0].instances[1].first;
  const glm::vec3 root(tuft(9, 2)[0].points[0]), own = last.grooms[0].points[0];
  EXPECT_NEAR(glm::distance(first.point(own), quarter * root + glm::vec3(0, 0, 10)), 0, 1e-5f);
  EXPECT_NEAR(glm::distance(second.point(own), root + glm::vec3(5, 0, 20)), 0, 1e-5f);

  overrides.frame = 0;
  overrides.settings = {R"(camera/shutter={"open": 0, "close": 1})", "camera/motion_samples=3"};
  const Scene open = loaded(written("m.usda", text), overrides);
  ASSERT_EQ(open.grooms[0].instances.size(), 2u);
  EXPECT_TRUE(open.grooms[0].later.empty()) << "the strands themselves rest";
  const Instance& moving = open.grooms[0].instances[1];
  ASSERT_EQ(moving.later.size(), 2u);
  EXPECT_NEAR(glm::distance(moving.later[1].point(open.grooms[0].points[0]), root + glm::vec3(5, 0, 2)), 0, 1e-5f);
  EXPECT_NEAR(std::abs(glm::determinant(open.grooms[0].instances[0].later[1].turn)), 1, 1e-5f)
      << "of quaternions of opposite signs the shorter way";
  EXPECT_NEAR(open.grooms[0].instances[0].later[1].turn[0].x, std::cos(0.05 * std::numbers::pi), 5e-3f);
}

TEST(FileInstances, OfPrimsThatReferMoveAsThePrimsDo) {
  const std::string moving =
                        "def Xform \"a\" (references = </P>) { double3 xformOp:translate.timeSamples = { 0: (0, 0, 0), "
                        "10: (0, 0, 10) } "
                        "uniform token[] xformOpOrder = [\"xformOp:translate\"] }\n",
                    prototype = "over \"P\" {\n" + curves("h", tuft(19, 2)) + "}\n";
  Overrides overrides;
  overrides.frame = 0;
  overrides.settings = {R"(camera/shutter={"open": 0, "close": 1})"};
  const Scene one = loaded(written("one.usda", usda + moving + prototype), overrides);
  EXPECT_TRUE(one.grooms[0].instances.empty()) << "it is drawn once";
  ASSERT_EQ(one.grooms[0].later.size(), 1u);
  EXPECT_NEAR(one.grooms[0].later[0].points[0].z - one.grooms[0].points[0].z, 1, 1e-6f);
  const Scene two =
      loaded(written("two.usda", usda + "def Xform \"b\" (references = </P>) { }\n" + moving + prototype), overrides);
  ASSERT_EQ(two.grooms[0].instances.size(), 2u);
  EXPECT_TRUE(two.grooms[0].later.empty());
  EXPECT_TRUE(two.grooms[0].instances[0].later.empty());
  ASSERT_EQ(two.grooms[0].instances[1].later.size(), 1u);
  EXPECT_NEAR(two.grooms[0].instances[1].later[0].offset.z - two.grooms[0].instances[1].first.offset.z, 1, 1e-6f);
}

TEST(FileInstances, ThatGoWithinTheShutterRest) {
  const std::string text =
      usda +
      "def PointInstancer \"i\" { rel prototypes = [</i/A>] int[] protoIndices = [0, 0, 0]\n point3f[] "
      "positions.timeSamples = { 0: [(0, 0, 0), (5, 0, 0), (9, 0, 0)], 10: [(0, 0, 10), (5, 0, 10), (9, 0, 10)] }\n "
      "int64[] invisibleIds.timeSamples = { 0: [], 1: [2] }\n" +
      curves("A", tuft(9, 2)) + "}\n";
  Overrides overrides;
  overrides.frame = 0;
  overrides.settings = {R"(camera/shutter={"open": 0, "close": 1})"};
  const Scene scene = loaded(written("g.usda", text), overrides);
  ASSERT_EQ(scene.grooms[0].instances.size(), 3u);
  for (const Instance& instance : scene.grooms[0].instances) EXPECT_TRUE(instance.later.empty());
  EXPECT_THAT(scene.notes, Contains(HasSubstr("stand still while the shutter is open")));
}

/// Floats 100,000 cm from 0 are 0.008 cm apart, so places are counted from near the camera before they are rounded.
TEST(FileInstances, FarFromZeroAreWhereTheyAre) {
  written("far.usda", usda +
                          "def PointInstancer \"i\" { double3 xformOp:translate = (100000.25, 0, 0) uniform token[] "
                          "xformOpOrder = [\"xformOp:translate\"] rel prototypes = [</i/A>] int[] protoIndices = [0, "
                          "0] point3f[] positions = [(0, 0, 0.125), (0.0625, 3, 0)]\n" +
                          curves("A", tuft(17, 2)) + "}\n");
  const Scene scene = loaded(
      written("far.json",
              R"({"camera": {"eye": [100000, -50, 0], "look_at": [100000, 0, 0]}, "grooms": [{"file": "far.usda"}]})"));
  const Groom& groom = scene.grooms[0];
  ASSERT_EQ(groom.instances.size(), 2u);
  EXPECT_EQ(scene.origin.x, 100000);
  const glm::vec3 root(tuft(17, 2)[0].points[0]);
  EXPECT_NEAR(glm::distance(groom.instances[0].first.point(groom.points[0]), root + glm::vec3(0.25, 0, 0.125)), 0,
              2e-6f);
  EXPECT_NEAR(glm::distance(groom.instances[1].first.point(groom.points[0]), root + glm::vec3(0.3125, 3, 0)), 0, 2e-6f);
}

TEST(FileInstances, OfNumberedFilesAreCopies) {
  for (int frame = 1; frame <= 2; ++frame)
    written(fmt::format("n.{:04}.usda", frame),
            usda + fmt::format("def PointInstancer \"i\" {{ rel prototypes = [</i/A>] int[] protoIndices = [0, 0] "
                               "point3f[] positions = [(0, 0, 0), (5, 0, {})]\n{} }}\n",
                               frame, curves("A", tuft(18, 2))));
  Overrides overrides;
  overrides.frame = 1;
  overrides.settings = {R"(camera/shutter={"open": 0, "close": 1})"};
  const Scene scene =
      loaded(written("n.json", R"({"camera": {"frame": true}, "grooms": [{"file": "n.####.usda"}]})"), overrides);
  ASSERT_EQ(scene.grooms.size(), 1u);
  EXPECT_EQ(scene.grooms[0].strand_count(), 4u);
  EXPECT_TRUE(scene.grooms[0].instances.empty());
  EXPECT_EQ(scene.grooms[0].later.size(), 1u);
  EXPECT_THAT(scene.notes, Contains(HasSubstr("of numbered files are copies")));
}

TEST(FileInstances, KeepIdsAndRootsOfTheirStrands) {
  const std::string text =
      usda +
      "def PointInstancer \"i\" { rel prototypes = [</i/A>, </i/B>] int[] protoIndices = [0, 1, 0, 1] point3f[] "
      "positions = [(0, 0, 0), (5, 0, 0), (9, 0, 0), (14, 0, 0)]\n" +
      curves("A", tuft(10, 2), "texCoord2f[] primvars:st = [(0, 0.25), (0.5, 0.75)] (interpolation = \"uniform\")") +
      curves("B", tuft(11, 1), "texCoord2f[] primvars:st = [(1, 1)] (interpolation = \"uniform\")") + "}\n" +
      curves("plain", tuft(12, 1));
  const Scene scene = loaded(written("k.usda", text));
  ASSERT_EQ(scene.grooms.size(), 3u);
  EXPECT_TRUE(scene.grooms[0].instances.empty());
  EXPECT_THAT(scene.grooms[0].id, ElementsAre(3)) << "its place in the file, so that mattes differ";
  EXPECT_THAT(scene.grooms[1].id, ElementsAre(0, 1));
  EXPECT_THAT(scene.grooms[1].root_uv, ElementsAre(glm::vec2(0, 0.25f), glm::vec2(0.5f, 0.75f)));
  EXPECT_THAT(scene.grooms[2].id, ElementsAre(2));
  EXPECT_THAT(scene.grooms[2].root_uv, ElementsAre(glm::vec2(1, 1)));
}

/// An instancer with one more attribute, or with others in place of its own.
std::string instancer_with(const std::string& more, const std::string& indices = "[0, 0]",
                           const std::string& prototypes = "</i/A>") {
  return usda + "def PointInstancer \"i\" { rel prototypes = [" + prototypes + "] int[] protoIndices = " + indices +
         "\n point3f[] positions = [(0, 0, 0), (5, 0, 0)]\n" + more + "\n" + curves("A", tuft(13, 2)) + "}\n";
}

TEST(FileInstances, ThatAreWrongAreErrors) {
  for (const auto& [text, expected] :
       {std::pair{instancer_with("", "[0, 1]"),
                  "/i.protoIndices: expected numbers of the 1 prototypes, from 0, found 1"},
        {instancer_with("", "[0, -1]"), "/i.protoIndices: expected numbers of the 1 prototypes, from 0, found -1"},
        {instancer_with("", "[0, 0, 0]"), "/i.positions: expected 3, as many as protoIndices, found 2"},
        {instancer_with("float3[] scales = [(1, 1, 1)]"), "/i.scales: expected 2, as many as protoIndices, found 1"},
        {instancer_with("quath[] orientations = [(1, 0, 0, 0)]"),
         "/i.orientations: expected 8, as many as protoIndices, found 4"},
        {instancer_with("int64[] ids = [1, 2, 3]"), "/i.ids: expected 2, as many as protoIndices, found 3"},
        {instancer_with("", "[0, 0]", "</i>"), "prims in one another"}}) {
    EXPECT_THAT(error_of("w.usda", text), HasSubstr("w.usda"));
    EXPECT_THAT(error_of("w.usda", text), HasSubstr(expected));
  }
}

TEST(FileInstances, ThatUsdItselfToleratesAreNamed) {
  const auto named = [](const std::string& text) {
    const auto groom = read_groom_file(written("t.usda", text));
    EXPECT_TRUE(groom) << groom.error().message();
    return groom ? ignored(*groom) : std::vector<std::string>();
  };
  EXPECT_THAT(named(instancer_with("", "[0, 1]", "</i/A>, </i/none>")),
              ElementsAre("/i: prototypes: what it refers to is not there: /i/none"));
  EXPECT_THAT(named(instancer_with("float3[] scales = [(1, 1, 1), (0, 0, 0)]")),
              ElementsAre("/i: 1 of 2 instances: their scale is 0"));
  EXPECT_THAT(
      named(instancer_with("quath[] orientations = [(1, 0, 0, 0), (1, 0, 0, 0)] quatf[] orientationsf = [(1, 0, "
                           "0, 0), (1, 0, 0, 0)]")),
      ElementsAre("/i: orientations: orientationsf is in its place"));
  EXPECT_THAT(named(instancer_with("float[] primvars:x = [1, 2]")),
              ElementsAre("/i: primvars:x: instances have the attributes of their prototype"));
  for (const FormatItem& item : usd_instancer_items()) {
    if (item.name == "protoIndices" || item.name == "positions") continue;
    const auto found = named(instancer_with(fmt::format("custom int {} = None", item.name)));
    if (*item.why == 0)
      EXPECT_THAT(found, ElementsAre()) << item.name;
    else
      EXPECT_THAT(found, ElementsAre(fmt::format("/i: {}: {}", item.name, item.why)));
  }
}

// ---- pbrt --------------------------------------------------------------------------------------------------------

std::string shape(const Strand& strand) {
  std::string points;
  for (const glm::dvec3& point : strand.points) points += fmt::format("{} {} {} ", point.x, point.y, point.z);
  return fmt::format("Shape \"curve\" \"point3 P\" [{}] \"float width\" {}\n", points, strand.width);
}

/// Objects of two and of one strand, one of which has a transform within, and what is drawn of them. Without instances
/// the same strands as curves.
struct PbrtScene {
  std::string shared, plain;
  std::vector<Strand> strands;

  explicit PbrtScene(std::size_t count) {
    RandomStream random(2026, 3);
    const std::vector<Strand> a = tuft(14, 2), b = tuft(15, 1);
    const glm::dmat4 own = glm::translate(glm::dmat4(1.0), {0, 0, 3});
    shared = "WorldBegin\nObjectBegin \"a\"\n" + shape(a[0]) + shape(a[1]) +
             "ObjectEnd\nObjectBegin \"b\"\nTranslate 0 0 3\n" + shape(b[0]) + "ObjectEnd\n";
    plain = "WorldBegin\n";
    for (std::size_t i = 0; i < count; ++i) {
      const glm::dvec3 position = 16.0 * glm::dvec3(random.next(), random.next(), random.next());
      const double degrees = std::floor(360 * random.next()), scale = 0.5 + double{random.next()};
      const bool is_b = i % 3 == 1;
      shared += fmt::format(
          "AttributeBegin\nTranslate {} {} {}\nRotate {} 1 2 3\nScale {} {} {}\nObjectInstance \"{}\"\nAttributeEnd\n",
          position.x, position.y, position.z, degrees, scale, scale, scale, is_b ? "b" : "a");
      const glm::dmat4 place = glm::scale(
          glm::rotate(glm::translate(glm::dmat4(1.0), position), degrees * std::numbers::pi / 180, {1, 2, 3}),
          glm::dvec3(scale));
      for (const Strand& strand : is_b ? b : a) strands.push_back(at(is_b ? place * own : place, scale, strand));
    }
    for (const Strand& strand : strands) plain += shape(strand);
  }
};

TEST(FileInstances, OfPbrtObjectsAreTheirStrandsWrittenOut) {
  const PbrtScene given(50);
  Overrides overrides;
  overrides.cm_per_unit = 1;
  overrides.y_up = false;
  const Scene scene = loaded(written("o.pbrt", given.shared), overrides);
  expect_strands(scene, given.strands);
  ASSERT_EQ(scene.grooms.size(), 2u);
  EXPECT_EQ(scene.grooms[0].instances.size(), 33u);
  EXPECT_EQ(scene.grooms[0].strand_count(), 2u);
  EXPECT_EQ(scene.grooms[1].instances.size(), 17u);
}

TEST(FileInstances, GiveTheSameUnitAndAxesAsTheirStrandsWrittenOut) {
  const PbrtScene given(20);
  const Scene scene = loaded(written("o.pbrt", given.shared)), plain = loaded(written("p.pbrt", given.plain));
  const auto all = strands_of(plain);
  ASSERT_TRUE(all);
  std::vector<Strand> expected;
  for (std::size_t s = 0; s < all->strand_count(); ++s) {
    expected.push_back({{}, double{all->width_at(all->first_point[s])}});
    for (std::uint32_t i = all->first_point[s]; i < all->first_point[s + 1]; ++i)
      expected.back().points.emplace_back(all->points[i]);
  }
  expect_strands(scene, expected, 1e-4);  // of 30 cm, in a unit that has the rounding of the points
}

TEST(FileInstances, OfPbrtThatAreStretchedAreCopies) {
  const Strand strand = tuft(16, 1)[0];
  const std::string text = "WorldBegin\nObjectBegin \"a\"\n" + shape(strand) +
                           "ObjectEnd\nObjectInstance \"a\"\nTranslate 4 0 0\nObjectInstance \"a\"\nScale 1 1 2\n"
                           "ObjectInstance \"a\"\nObjectInstance \"none\"\n";
  const auto groom = read_groom_file(written("s.pbrt", text));
  ASSERT_TRUE(groom) << groom.error().message();
  EXPECT_EQ(groom->strand_count(), 2u);
  ASSERT_EQ(groom->shared.size(), 1u);
  EXPECT_EQ(groom->shared[0].places.size(), 2u);
  EXPECT_THAT(groom->remarks, Contains(HasSubstr("are copies")));
  EXPECT_THAT(ignored(*groom), ElementsAre("ObjectInstance \"none\": no object with curves has the name"));
}

// ---- Alembic -----------------------------------------------------------------------------------------------------

TEST(FileInstances, OfAlembicShareTheirStrands) {
  Overrides overrides;
  overrides.cm_per_unit = 1;
  overrides.y_up = false;
  overrides.frame = 0;
  overrides.settings = {R"(camera/shutter={"open": 0, "close": 1})"};
  const Scene scene = loaded(fixture("instances.abc"), overrides);
  const std::vector<Strand> own{{{{0, 0, 0}, {0, 0, 5}}, 0.0625}, {{{1, 0, 0}, {1, 0, 2}, {1, 1, 5}}, 0.0625}};
  const glm::dmat4 up = glm::translate(glm::dmat4(1.0), {0, 0, 1});
  std::vector<Strand> all;
  for (const Strand& strand : own) {
    all.push_back(at(up, 1, strand));
    all.push_back(at(glm::translate(glm::dmat4(1.0), {4, 0, 0}) * up, 1, strand));
    all.push_back(
        at(glm::scale(glm::rotate(glm::translate(glm::dmat4(1.0), {8, 0, 0}), std::numbers::pi / 2, {0, 0, 1}),
                      glm::dvec3(2.0)) *
               up,
           2, strand));
    all.push_back(at(glm::scale(glm::translate(glm::dmat4(1.0), {0, 8, 0}), {1, 1, 3}) * up, std::cbrt(3.0), strand));
  }
  expect_strands(scene, all);
  ASSERT_EQ(scene.grooms.size(), 2u) << "what is stretched is a copy";
  const Groom& shared = scene.grooms[1];
  ASSERT_EQ(shared.instances.size(), 3u) << "with the original";
  EXPECT_THAT(shared.id, ElementsAre(7, 8));
  EXPECT_TRUE(shared.later.empty());
  EXPECT_TRUE(shared.instances[0].later.empty());
  ASSERT_EQ(shared.instances[1].later.size(), 1u);
  EXPECT_NEAR(shared.instances[1].later[0].offset.z - shared.instances[1].first.offset.z, 2, 1e-5f);
  const auto groom = read_groom_file(fixture("instances.abc"));
  ASSERT_TRUE(groom);
  EXPECT_THAT(ignored(*groom), ElementsAre("/nowhere/a: what it is an instance of is not there: /b"));
}

}  // namespace
}  // namespace tress::scene::file_instances
