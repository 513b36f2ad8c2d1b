// Normals of files as the minor axes of fibers, and the basis that a scene says for strands whose file does not.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <string>
#include <vector>

#include "scene/groom_fixture.h"
#include "scene/read/groom_files.h"
#include "scene/read/groom_writers.h"
#include "scene/read/grooms/given_basis.h"
#include "scene/read/load_scene.h"

namespace tress::scene {
namespace {

namespace fs = std::filesystem;

const float half_root_3 = std::sqrt(3.0f) / 2;
/// Of make_fixtures.py, at unit length.
const std::vector<glm::vec3> written_down{
    {1, 0, 0}, {0.5f, half_root_3, 0}, {-0.5f, half_root_3, 0}, {-1, 0, 0}, {0, 0, 1}, {0, 0, -1}, {0, 1, 0},
    {0, 0, 0}};

void expect_near(const std::vector<glm::vec3>& found, const std::vector<glm::vec3>& expected, const char* what) {
  ASSERT_EQ(found.size(), expected.size()) << what;
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_LT(glm::distance(found[i], expected[i]), 1e-6f) << what << i;
}

TEST(GroomAxes, AreReadFromAlembicUsdAndRibbonsOfPbrt) {
  for (const char* name : {"normals.usda", "normals.abc", "normals.pbrt"}) {
    const auto groom = read_groom_file(fixture(name));
    ASSERT_TRUE(groom) << groom.error().message();
    std::vector<glm::vec3> at_ends;
    const std::size_t stride = groom->basis == StrandBasis::bezier ? 3 : 1;
    for (std::size_t i = 0; i < groom->normal.size();) {
      at_ends.push_back(groom->normal[i]);
      i += at_ends.size() % 4 == 0 ? 1 : stride;
    }
    expect_near(at_ends, written_down, name);
  }
}

class InAScene : public testing::Test {
 protected:
  InAScene() { fs::create_directories(folder_); }
  ~InAScene() override { fs::remove_all(folder_); }

  Scene scene(const std::string& grooms, const char* more = "") {
    std::ofstream(folder_ / "scene.json") << R"({"grooms": [)" << grooms << "]" << more << "}";
    auto scene = load_scene(folder_ / "scene.json");
    EXPECT_TRUE(scene) << scene.error().message();
    return scene ? std::move(*scene) : Scene();
  }

  std::string error_of(const std::string& grooms) {
    std::ofstream(folder_ / "scene.json") << R"({"grooms": [)" << grooms << "]}";
    const auto scene = load_scene(folder_ / "scene.json");
    EXPECT_FALSE(scene);
    return scene ? "" : scene.error().message();
  }

  fs::path folder_ = fs::path(testing::TempDir()) / ("tress_axes_and_bases_" + std::to_string(getpid()));
};

TEST_F(InAScene, NormalsAreMinorAxesInTheWorldUnlessItLeavesThemOut) {
  fs::copy_file(fixture("normals.usda"), folder_ / "a.usda");
  const Scene all = scene(R"({"file": "a.usda"}, {"file": "a.usda", "up": "y"}, {"file": "a.usda", "normals": false},
      {"file": "a.usda", "scale": 2, "rotate_deg": [0, 0, 90], "translate": [9, 0, 0]})");
  ASSERT_EQ(all.grooms.size(), 4u);
  std::vector<glm::vec3> raised, turned;
  for (const glm::vec3& n : written_down) {
    raised.emplace_back(n.x, -n.z, n.y);
    turned.emplace_back(-n.y, n.x, n.z);
  }
  expect_near(all.grooms[0].minor_axis, written_down, "as they are");
  expect_near(all.grooms[1].minor_axis, raised, "y up");
  expect_near(all.grooms[3].minor_axis, turned, "turned");
  EXPECT_TRUE(all.grooms[2].minor_axis.empty());
  int said = 0;
  for (const std::string& note : all.notes) said += note.find("\"normals\": false") != std::string::npos;
  EXPECT_EQ(said, 3);
}

/// Points that coincide are left out, and so are what is given there and strands without length.
TEST_F(InAScene, NormalsStayWithTheirPoints) {
  std::ofstream(folder_ / "a.usda") << R"(#usda 1.0
def BasisCurves "Hair" {
    uniform token type = "linear"
    int[] curveVertexCounts = [2, 4]
    point3f[] points = [(5, 5, 5), (5, 5, 5), (0, 0, 0), (0, 0, 0), (0, 0, 1), (0, 0, 2)]
    normal3f[] normals = [(0, 1, 0), (0, 1, 0), (1, 0, 0), (0, 3, 0), (0, 1, 0), (-2, 0, 0)] (interpolation = "vertex")
})";
  const Scene one = scene(R"({"file": "a.usda", "up": "z"})");
  ASSERT_EQ(one.grooms.size(), 1u);
  expect_near(one.grooms[0].minor_axis, {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}}, "");
}

TEST_F(InAScene, NormalsAreKeptByConvertWhereTheFormatCan) {
  for (const char* name : {"normals.usda", "normals.abc", "normals.pbrt"}) {
    const auto groom = read_groom_file(fixture(name));
    ASSERT_TRUE(groom);
    std::vector<std::string> notes;
    ASSERT_FALSE(write_groom_file(*groom, folder_ / "again.usda", &notes));
    const auto again = read_groom_file(folder_ / "again.usda");
    ASSERT_TRUE(again) << again.error().message();
    expect_near(again->normal, groom->normal, name);
    notes.clear();
    ASSERT_FALSE(write_groom_file(*groom, folder_ / "again.hair", &notes));
    EXPECT_NE(std::ranges::find(notes, ".hair has no normals"), notes.end());
  }
}

TEST_F(InAScene, NormalsThatFitNothingAreNamedAndLeftOut) {
  std::ofstream(folder_ / "a.usda") << R"(#usda 1.0
def BasisCurves "Hair" {
    uniform token type = "linear"
    int[] curveVertexCounts = [3]
    point3f[] points = [(0, 0, 0), (0, 0, 1), (0, 0, 2)]
    normal3f[] normals = [(0, 1, 0), (1, 0, 0)]
})";
  const auto groom = read_groom_file(folder_ / "a.usda");
  ASSERT_TRUE(groom);
  EXPECT_TRUE(groom->normal.empty());
  ASSERT_EQ(groom->ignored.size(), 1u);
  EXPECT_NE(groom->ignored[0].name.find("normals"), std::string::npos);
}

/// Weights of four points in a row on a segment, as textbooks have them.
std::vector<float> weights(const std::string& basis, float t) {
  const float s = 1 - t, t2 = t * t, t3 = t2 * t;
  if (basis.ends_with("catmull_rom"))
    return {(-t3 + 2 * t2 - t) / 2, (3 * t3 - 5 * t2 + 2) / 2, (-3 * t3 + 4 * t2 + t) / 2, (t3 - t2) / 2};
  if (basis.ends_with("bspline"))
    return {s * s * s / 6, (3 * t3 - 6 * t2 + 4) / 6, (-3 * t3 + 3 * t2 + 3 * t + 1) / 6, t3 / 6};
  if (basis == "bezier") return {s * s * s, 3 * s * s * t, 3 * s * t2, t3};
  if (basis == "hermite") return {2 * t3 - 3 * t2 + 1, t3 - 2 * t2 + t, 3 * t2 - 2 * t3, t3 - t2};
  return {s, t};
}

template <class T>
T mixed(const std::vector<T>& p, std::size_t first, const std::vector<float>& w) {
  T sum{};
  for (std::size_t k = 0; k < w.size(); ++k) sum += w[k] * p[first + k];
  return sum;
}

template <class T>
std::vector<T> with_ends_mirrored(std::vector<T> p) {
  const std::size_t n = p.size();
  const T before = 2.0f * p[0] - p[1], after = 2.0f * p[n - 1] - p[n - 2];
  p.insert(p.begin(), before);
  p.push_back(after);
  return p;
}

/// Values at the points of a strand, on segment i as the basis of that name has them, by the book.
template <class T>
T by_the_book(const std::string& basis, const std::vector<T>& values, std::size_t i, float t) {
  const bool is_mirrored = basis == "bspline" || basis == "catmull_rom";
  const std::size_t step = basis == "bezier" ? 3 : basis == "hermite" ? 2 : 1;
  std::vector<T> p = is_mirrored ? with_ends_mirrored(values) : values;
  if (basis.starts_with("clamped")) {
    p.insert(p.begin(), values.front());
    p.push_back(values.back());
  }
  if (basis == "hermite") {  // point, point, tangent, tangent as the weights have them
    std::vector<T> q{p[2 * i], p[2 * i + 1], p[2 * i + 2], p[2 * i + 3]};
    return mixed(q, 0, weights(basis, t));
  }
  return mixed(p, step * i, weights(basis, t));
}

/// The same of what is drawn.
template <class T>
T as_drawn(const Groom& groom, const std::vector<T>& values, std::size_t strand, std::size_t i, float t) {
  const std::vector<T> own(values.begin() + groom.first_point[strand], values.begin() + groom.first_point[strand + 1]);
  static const std::vector<std::string> names{"bspline", "linear", "open_bspline", "bezier"};
  return by_the_book(names[static_cast<std::size_t>(groom.basis)], own, i, t);
}

/// Seven points make a strand of every basis but hermite, which has eight.
std::string ply_of(const std::vector<std::vector<glm::vec3>>& strands, const std::vector<float>& widths) {
  std::string rows;
  std::size_t count = 0;
  for (std::size_t s = 0; s < strands.size(); ++s)
    for (std::size_t i = 0; i < strands[s].size(); ++i, ++count)
      rows += std::to_string(strands[s][i].x) + " " + std::to_string(strands[s][i].y) + " " +
              std::to_string(strands[s][i].z) + " " + std::to_string(widths[i]) + " " + std::to_string(s) + "\n";
  return "ply\nformat ascii 1.0\nelement vertex " + std::to_string(count) +
         "\nproperty float x\nproperty float y\nproperty float z\nproperty float width\nproperty int strand_id\n"
         "end_header\n" +
         rows;
}

TEST_F(InAScene, StrandsOfEveryBasisThatItSaysAreThoseOfTheTextbook) {
  ASSERT_EQ(basis_names().size(), 8u);
  for (const std::string& basis : basis_names()) {
    const std::size_t count = basis == "hermite" ? 8 : 7;
    std::vector<std::vector<glm::vec3>> strands(2);
    std::vector<float> widths;
    // Sixteenths, which text and floats have exactly.
    for (std::size_t i = 0; i < count; ++i) {
      const int k = static_cast<int>(i);
      strands[0].emplace_back(0.0625f * static_cast<float>(k * k % 7), 0.25f * static_cast<float>(k % 3), -0.5f * k);
      strands[1].emplace_back(1.0f + 0.125f * static_cast<float>(k % 2), -0.0625f * static_cast<float>(k * k),
                              -0.25f * k);
      widths.push_back(0.03125f - 0.001953125f * static_cast<float>(k % 4));
    }
    if (basis == "hermite") {  // widths of tangents are rates of change
      for (std::size_t i = 1; i < count; i += 2) widths[i] = 0;
    }
    std::ofstream(folder_ / "a.ply") << ply_of(strands, widths);
    const Scene one = scene(R"({"file": "a.ply", "cm_per_unit": 1, "up": "z", "basis": ")" + basis + R"("})");
    ASSERT_EQ(one.grooms.size(), 1u) << basis;
    const Groom& groom = one.grooms[0];
    ASSERT_EQ(groom.strand_count(), 2u);
    const std::size_t segments = basis == "bezier"           ? 2
                                 : basis == "hermite"        ? 3
                                 : basis.starts_with("open") ? count - 3
                                                             : count - 1;
    for (std::size_t s = 0; s < 2; ++s)
      for (std::size_t i = 0; i < segments; ++i)
        for (const float t : {0.0f, 0.25f, 0.75f, 1.0f}) {
          const glm::vec3 point = by_the_book(basis, strands[s], i, t);
          EXPECT_LT(glm::distance(as_drawn(groom, groom.points, s, i, t), point), 1e-6f) << basis << " " << s << i;
          EXPECT_NEAR(as_drawn(groom, groom.radius_cm, s, i, t), by_the_book(basis, widths, i, t) / 2, 1e-6f) << basis;
        }
  }
}

/// What a file has at later moments of the shutter becomes what is drawn, as its points do.
TEST(GivenBasis, IsThatOfEveryMoment) {
  GroomFile file;
  file.first_point = {0, 3};
  file.points = {{0, 0, 0}, {0, 0, 1}, {0, 1, 2}};
  file.width = {0.5f, 0.25f, 0.125f};
  file.later = {{{1, 0, 0}, {1, 0, 1}, {1, 1, 2}}};
  file.later_width = {{1, 0.5f, 0.25f}};
  file.normal = {{1, 0, 0}, {1, 0, 0}, {1, 0, 0}};
  ASSERT_FALSE(take_points_as(kind_of_basis("catmull_rom"), "a", &file));
  ASSERT_EQ(file.points.size(), 7u);
  ASSERT_EQ(file.later[0].size(), 7u);
  ASSERT_EQ(file.later_width[0].size(), 7u);
  ASSERT_EQ(file.normal.size(), 7u);
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_LT(glm::distance(file.later[0][i], file.points[i] + glm::vec3(1, 0, 0)), 1e-6f);
    EXPECT_NEAR(file.later_width[0][i], 2 * file.width[i], 1e-6f);
  }
}

TEST_F(InAScene, ABasisThatStrandsCannotHaveIsRefusedByTheStrand) {
  std::ofstream(folder_ / "a.ply") << ply_of({{{0, 0, 0}, {0, 0, 1}, {0, 1, 2}, {0, 1, 3}, {0, 0, 4}}},
                                             {0.01f, 0.01f, 0.01f, 0.01f, 0.01f});
  const std::string said = error_of(R"({"file": "a.ply", "basis": "bezier"})");
  EXPECT_NE(said.find("a.ply"), std::string::npos) << said;
  EXPECT_NE(said.find("strand 0"), std::string::npos) << said;
  EXPECT_NE(said.find("3 n + 1"), std::string::npos) << said;
  EXPECT_NE(error_of(R"({"generate": "straight", "basis": "hermite"})").find("/grooms/0/basis"), std::string::npos);
}

TEST_F(InAScene, AGeneratedGroomGoesThroughItsPointsByCatmullRom) {
  const Scene both = scene(R"({"generate": "wavy", "strands": 5, "taper": {}, "basis": "linear"},
                              {"generate": "wavy", "strands": 5, "taper": {}, "basis": "catmull_rom"})");
  ASSERT_EQ(both.grooms.size(), 2u);
  const Groom &points = both.grooms[0], &smooth = both.grooms[1];
  ASSERT_EQ(smooth.basis, StrandBasis::bezier);
  for (std::uint32_t s = 0; s < 5; ++s) {
    const std::uint32_t count = points.first_point[s + 1] - points.first_point[s];
    ASSERT_EQ(smooth.first_point[s + 1] - smooth.first_point[s], 3 * count - 2);
    for (std::uint32_t i = 0; i < count; ++i) {
      EXPECT_EQ(smooth.points[smooth.first_point[s] + 3 * i], points.points[points.first_point[s] + i]);
      EXPECT_EQ(smooth.radius_cm[smooth.first_point[s] + 3 * i], points.radius_cm[points.first_point[s] + i]);
    }
  }
}

}  // namespace
}  // namespace tress::scene
