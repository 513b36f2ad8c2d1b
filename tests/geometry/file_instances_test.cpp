// Instances of a file against the same strands written out in another: every hit.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <numbers>
#include <string>

#include "scene/read/load_scene.h"
#include "straight_strands.h"

namespace tress::geometry {
namespace {

namespace fs = std::filesystem;

struct TwoFiles {
  std::string shared, plain;
};

/// Tufts of four bent strands: 30 instances, turned about z and scaled, and the same strands one after the other.
TwoFiles tufts_of_usd() {
  RandomStream random(2026, 11);
  std::vector<glm::dvec3> own;
  for (int i = 0; i < 16; ++i) own.emplace_back(random_point(random, 1));
  const auto curves = [](const std::string& name, std::size_t count, const std::string& points, double width) {
    std::string counts = "4";
    for (std::size_t i = 1; i < count; ++i) counts += ", 4";
    return fmt::format(
        "def BasisCurves \"{}\" {{ uniform token basis = \"bspline\" uniform token wrap = \"pinned\" int[] "
        "curveVertexCounts = [{}] point3f[] points = [{}] float[] widths = [{}] (interpolation = \"constant\") }}\n",
        name, counts, points, width);
  };
  const auto words = [](const glm::dvec3& p) { return fmt::format("({}, {}, {}), ", p.x, p.y, p.z); };
  std::string points, indices, positions, turns, scales, written;
  for (const glm::dvec3& point : own) points += words(point);
  for (int i = 0; i < 30; ++i) {
    const glm::dvec3 position(random_point(random, 5));
    const double half = std::numbers::pi * double{random.next()}, scale = 0.5 + double{random.next()};
    const double c = std::cos(2 * half), s = std::sin(2 * half);
    indices += "0, ";
    positions += words(position);
    turns += fmt::format("({}, 0, 0, {}), ", std::cos(half), std::sin(half));
    scales += words(glm::dvec3(scale));
    std::string placed;
    for (const glm::dvec3& p : own)
      placed += words(position + scale * glm::dvec3(c * p.x - s * p.y, s * p.x + c * p.y, p.z));
    written += curves(fmt::format("c{}", i), 4, placed, 0.125 * scale);
  }
  const std::string head = "#usda 1.0\n(metersPerUnit = 0.01 upAxis = \"Z\")\n";
  return {head + fmt::format("def PointInstancer \"i\" {{ rel prototypes = </i/A> int[] protoIndices = [{}] point3f[] "
                             "positions = [{}] quatf[] orientationsf = [{}] float3[] scales = [{}]\n{} }}\n",
                             indices, positions, turns, scales, curves("A", 4, points, 0.125)),
          head + written};
}

scene::Scene loaded(const std::string& name, const std::string& text) {
  const fs::path file = fs::path(testing::TempDir()) / name;
  std::ofstream(file, std::ios::binary) << text;
  auto scene = scene::load_scene(file, {.eccentricity = 1.0f});  // round: major axes follow from ids and verticals
  EXPECT_TRUE(scene) << scene.error().message();
  return scene ? std::move(*scene) : scene::Scene();
}

TEST(FileInstances, AreHitAsTheSameStrandsWrittenOut) {
  const TwoFiles files = tufts_of_usd();
  scene::Scene shared = loaded("shared.usda", files.shared), plain = loaded("plain.usda", files.plain);
  ASSERT_EQ(shared.grooms.size(), 1u);
  EXPECT_EQ(shared.grooms[0].instances.size(), 30u);
  EXPECT_EQ(shared.grooms[0].points.size() * 30, plain.grooms[0].points.size());
  for (scene::Scene* scene : {&shared, &plain}) scene->image.curve_error_px = 1e-4f;
  const FiberScene a(shared), b(plain);
  EXPECT_LT(a.bytes(), b.bytes());
  RandomStream random(2026, 12);
  int hits = 0, differ = 0;
  for (int i = 0; i < 40000; ++i) {
    Ray ray;
    ray.direction = random_direction(random);
    ray.origin = random_point(random, 4) - 20.0f * ray.direction;
    const std::optional<Hit> one = a.intersect(ray), other = b.intersect(ray);
    if (one.has_value() != other.has_value()) ++differ;
    if (!one || !other) continue;
    ++hits;
    const bool is_same = one->instance * 4 + one->strand == other->strand;
    if (!is_same) ++differ;
    // Where rays graze a strand, a rounding of 2e-6 cm of its place moves a hit by sqrt(2 * 0.06 * 2e-6) = 5e-4 cm.
    if (is_same) {
      EXPECT_NEAR(one->distance_cm, other->distance_cm, 2e-3f);
      EXPECT_NEAR(glm::distance(one->axis, other->axis), 0, 2e-3f);
    }
  }
  EXPECT_GT(hits, 3000);
  // Rounding of 2e-6 cm decides at the edges of strands of 0.03 cm and more for some 1e-4 of the hits; more than 10 of
  // 4,000 have a probability below 1e-9.
  EXPECT_LE(differ, 10);
}

}  // namespace
}  // namespace tress::geometry
