// Scenes far from 0, where floats are coarser than hair.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <string>

#include "scene/read/load_scene.h"
#include "scene/read/scene_strands.h"

namespace tress::scene {
namespace {

namespace fs = std::filesystem;

class FarScene : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(::testing::TempDir()) / ("tress_far_" + std::to_string(getpid()));
    fs::create_directories(folder_);
    std::ofstream(folder_ / "tuft.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// The same scene, moved by `far` along each axis: the hair by a transform of its file, or by the scene's.
  Scene scene_at(int far, bool by_file, const std::string& camera = {}) const {
    std::ofstream(folder_ / "hair.usda") << fmt::format(R"(#usda 1.0
(
 metersPerUnit = 0.01
 upAxis = "Y"
)
def Xform "x" {{
  double3 xformOp:translate = ({0}, {0}, -{0})
  uniform token[] xformOpOrder = ["xformOp:translate"]
  def BasisCurves "hair" {{
    uniform token type = "linear"
    int[] curveVertexCounts = [3, 3]
    point3f[] points = [(0.001,0.002,0.003), (0.5,0,-1), (0.1234567,0,-2), (1,0,0), (1,0,-1.7654321), (1,0,-2)]
    float[] widths = [0.01] (interpolation = "constant")
  }}
}})",
                                                        by_file ? far : 0);
    const std::string text = fmt::format(
        R"({{"camera": {{{1}}},
             "lights": [{{"sphere": {{"center": [{0}, {0}, {2}], "radius_cm": 2, "radiance": [1, 1, 1]}}}}],
             "meshes": [{{"file": "tuft.obj", "translate": [{0}, {0}, {0}]}}],
             "grooms": [{{"file": "hair.usda", "translate": [{3}, {3}, {3}]}}]}})",
        far,
        camera.empty() ? fmt::format(R"("eye": [{0}, {1}, {0}], "look_at": [{0}, {0}, {0}])", far, far - 20) : camera,
        far + 9, by_file ? 0 : far);
    auto scene =
        load_scene({reinterpret_cast<const unsigned char*>(text.data()), text.size()}, "s.json", folder_, {}, {});
    EXPECT_TRUE(scene) << scene.error().message();
    Scene found;
    if (scene) found = std::move(*scene);
    return found;
  }

  fs::path folder_;
};

// far_from_origin: at 1 km a float is rounded by up to 0.004 cm, the radius of a hair. Sums of doubles and of a float
// are rounded once here: by 2e-7 of 2 cm at most.
TEST_F(FarScene, HasThePlacesOfTheOneAtZeroCountedFromItsOrigin) {
  const Scene near = scene_at(0, true);
  EXPECT_EQ(near.origin, glm::dvec3(0.0));
  for (const int far : {10'000, 100'000})
    for (const bool by_file : {true, false}) {
      const Scene scene = scene_at(far, by_file);
      EXPECT_EQ(scene.origin, glm::dvec3(far));
      EXPECT_EQ(scene.camera.eye, near.camera.eye);
      EXPECT_EQ(scene.camera.look_at, near.camera.look_at);
      ASSERT_EQ(scene.grooms.size(), 1u);
      ASSERT_EQ(scene.grooms[0].points.size(), near.grooms[0].points.size());
      for (std::size_t i = 0; i < near.grooms[0].points.size(); ++i)
        EXPECT_LT(glm::distance(scene.grooms[0].points[i], near.grooms[0].points[i]), 1e-6f) << far << " " << i;
      EXPECT_EQ(scene.grooms[0].radius_cm, near.grooms[0].radius_cm);
      ASSERT_EQ(scene.meshes.size(), 1u);
      EXPECT_EQ(scene.meshes[0].positions, near.meshes[0].positions);
      EXPECT_EQ(scene.lights[0].center, near.lights[0].center);
      const auto strands = strands_of(scene), strands_near = strands_of(near);
      ASSERT_TRUE(strands && strands_near);
      EXPECT_LT(glm::distance(strands->points[2], strands_near->points[2] + glm::vec3(static_cast<float>(far))), 0.01f)
          << "the world's own places, rounded";
    }
}

// Nothing changes where the camera is near 0 or is placed by the hair.
TEST_F(FarScene, IsOneByItsCamera) {
  EXPECT_EQ(scene_at(1000, true).origin, glm::dvec3(0.0));
  const Scene framed = scene_at(100'000, true, R"("frame": true)");
  EXPECT_EQ(framed.origin, glm::dvec3(0.0));
  EXPECT_NEAR(framed.grooms[0].points[0].x, 100'000, 1);
  const Scene keyed =
      scene_at(100'000, false,
               R"("frames": [{"frame": 0, "eye": [100000, 99000, 100000], "look_at": [100001, 100002, 100003]},
                                             {"frame": 9, "eye": [100050, 99000, 100000], "look_at": [100001, 100002, 100003]}])");
  EXPECT_EQ(keyed.origin, glm::dvec3(100001, 100002, 100003));
  EXPECT_EQ(keyed.camera.look_at, glm::vec3(0));
  EXPECT_EQ(keyed.camera.eye, glm::vec3(-1, -1002, -3));
}

}  // namespace
}  // namespace tress::scene
