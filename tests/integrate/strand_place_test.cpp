// Where along its strand a hit is, and of which fiber that makes it.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "integrate/scattering.h"
#include "scene/model/strand_fibers.h"
#include "tress/base/random.h"

namespace tress::integrate {
namespace {

using scene::StrandBasis;

constexpr float radius_cm = 0.05f;

/// Strands of one cm a segment down from z = 0 at x = 0, 1, ..., whose absorption is `sigma_a` of the points.
scene::Scene hanging(StrandBasis basis, const std::vector<std::vector<float>>& strands) {
  scene::Scene scene;
  scene.materials.resize(1);
  scene.materials[0].fiber.eccentricity = 1;
  scene.materials[0].pigment =
      scene::Pigment{{.kind = scene::Source::Kind::attribute, .value = glm::vec3(1)},
                     [](const glm::vec3& value, const fiber::FiberParameters&) { return value; }};
  scene.grooms.resize(1);
  scene::Groom& groom = scene.grooms[0];
  groom.basis = basis;
  groom.first_point = {0};
  const scene::StrandSegments segments(basis);
  for (const std::vector<float>& strand : strands) {
    const auto x = static_cast<float>(groom.strand_count());
    for (std::size_t i = 0; i < strand.size(); ++i) {
      const float place = (float(i) - float(segments.first)) / float(segments.points_a_segment);
      groom.points.emplace_back(x, 0, -place);
      groom.radius_cm.push_back(radius_cm);
      groom.color.emplace_back(strand[i]);
    }
    groom.first_point.push_back(static_cast<std::uint32_t>(groom.points.size()));
  }
  EXPECT_FALSE(scene::assign_fibers(&scene));
  return scene;
}

std::optional<geometry::Hit> hit_at(const geometry::FiberScene& fibers, float x, float down) {
  return fibers.intersect({.origin = {x, -5, -down}, .direction = {0, 1, 0}});
}

TEST(StrandPlace, IsCountedInSegmentsFromTheRoot) {
  for (const auto basis : {StrandBasis::linear, StrandBasis::bspline, StrandBasis::open_bspline, StrandBasis::bezier}) {
    const std::size_t points = basis == StrandBasis::bezier ? 13 : basis == StrandBasis::open_bspline ? 7 : 5;
    const std::vector<float> strand(points, 0.5f);
    const scene::Scene scene = hanging(basis, {strand, strand});
    const geometry::FiberScene fibers(scene);
    for (const float x : {0.0f, 1.01f})
      for (const float down : {0.1f, 1.0f, 1.6f, 3.9f}) {
        const auto hit = hit_at(fibers, x, down);
        ASSERT_TRUE(hit) << down;
        EXPECT_EQ(hit->strand, x > 0.5f ? 1u : 0u);
        EXPECT_NEAR(hit->place, down, 1e-3f) << int(basis);  // Embree's ribbons of four straight pieces a segment
      }
  }
}

/// The colors are whole powers, so that no rounding makes them differ: in ten pieces of one strand, and as strands.
TEST(StrandPlace, AStrandOfTenColorsIsTenStrandsOfOne) {
  std::vector<float> colors;
  std::vector<std::vector<float>> ten;
  for (int k = 0; k < 10; ++k) {
    const auto sigma_a = static_cast<float>(0.01 * std::pow(scene::color_ratio, 3 * k));
    colors.insert(colors.end(), {sigma_a, sigma_a});
    ten.push_back({sigma_a, sigma_a});
  }
  const scene::Scene one = hanging(StrandBasis::linear, {colors}), many = hanging(StrandBasis::linear, ten);
  const geometry::FiberScene of_one(one), of_many(many);
  for (int k = 0; k < 10; ++k)
    for (const float along : {0.02f, 0.3f, 0.55f, 0.97f}) {
      const auto a = hit_at(of_one, 0.01f, 2 * k + along), b = hit_at(of_many, k + 0.01f, along);
      ASSERT_TRUE(a && b);
      EXPECT_EQ(one.fibers[fiber_of(one, *a)], many.fibers[fiber_of(many, *b)]) << k;
    }
}

TEST(StrandPlace, HitsBetweenTwoColorsAreOfBothByHowNearTheyAre) {
  scene::Scene scene = hanging(StrandBasis::linear, {std::vector<float>{0.01f, 5.0f}});
  const geometry::FiberScene fibers(scene);
  scene::Groom& groom = scene.grooms[0];
  groom.choices.clear();  // every station another, and none between two absorptions
  groom.choices_a_station = 1;
  for (std::size_t station = 0; station < groom.first_station(1); ++station)
    groom.choices.push_back({0, static_cast<std::uint16_t>(station)});
  const auto stations = static_cast<float>(groom.stations_a_segment);
  RandomStream random(11);
  constexpr int n = 20000;
  for (const float station : {3.25f, 17.5f, 30.9f}) {
    const auto before = static_cast<std::uint32_t>(station), after = before + 1;
    int second = 0;
    for (int i = 0; i < n; ++i) {
      auto hit = hit_at(fibers, radius_cm * (random.next() - 0.5f), station / stations + 1e-5f * random.next());
      ASSERT_TRUE(hit);
      hit->place = station / stations;
      const std::uint32_t fiber = fiber_of(scene, *hit);
      EXPECT_EQ(fiber, fiber_of(scene, *hit));
      ASSERT_TRUE(fiber == before || fiber == after);
      second += fiber == after;
    }
    const double share = station - std::floor(station);
    EXPECT_NEAR(double(second) / n, share, 4.5 * std::sqrt(share * (1 - share) / n));
  }
}

}  // namespace
}  // namespace tress::integrate
