// Strands that are there for a share of the rays.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "geometry/straight_strands.h"

namespace tress::geometry {
namespace {

constexpr int rays = 20000;
constexpr double z_limit = 4.5;  ///< beyond it once in 150,000 times; keys are fixed

double error_of(double share) { return std::sqrt(share * (1 - share) / rays); }

/// How many of the rays along y at x and z meet a strand, by the number of the strand. is_drawn: by numbers that are
/// evenly spaced.
std::array<double, 2> shares_met(const FiberScene& fibers, float x, float z, bool is_drawn = false) {
  std::array<double, 2> met{};
  for (std::uint64_t key = 0; key < rays; ++key) {
    Ray ray{.origin = {x, -5, z}, .direction = {0, 1, 0}};
    ray.key = key;
    if (is_drawn) {
      ray.drawn = static_cast<float>(key) / rays;
      if (const std::optional<Hit> hit = fibers.intersect(ray)) met[hit->strand] += 1.0 / rays;
      continue;
    }
    const std::optional<Hit> hit = fibers.intersect(ray), again = fibers.intersect(ray);
    EXPECT_EQ(hit.has_value(), again.has_value());
    EXPECT_EQ(hit.has_value(), fibers.occluded(ray)) << "shadow rays decide as others do";
    if (hit) met[hit->strand] += 1.0 / rays;
  }
  return met;
}

TEST(Presence, IsTheShareOfTheRaysThatMeetAStrand) {
  for (const bool linear : {true, false}) {
    scene::Scene scene =
        straight_scene({{{0, 0, 0}, {0, 0, -8}, 0.5f, 0.5f, 1}, {{0, 3, 0}, {0, 3, -8}, 0.5f, 0.5f, 0.8f}}, linear);
    scene.grooms[0].presence = {0.3f, 0.6f};
    const FiberScene fibers(scene);
    const auto [first, second] = shares_met(fibers, 0.1f, -3.3f);
    EXPECT_NEAR(first, 0.3, z_limit * error_of(0.3)) << linear;
    EXPECT_NEAR(second, 0.7 * 0.6, z_limit * error_of(0.42)) << "independent of the first, " << linear;
    const auto [drawn_first, drawn_second] = shares_met(fibers, 0.1f, -3.3f, true);
    EXPECT_NEAR(drawn_first, 0.3, 1.5 / rays) << "to one of the numbers";
    EXPECT_NEAR(drawn_second, 0.7 * 0.6, 1.5 / rays);
    scene.grooms[0].presence = {0, 1};
    const auto [none, all] = shares_met(FiberScene(scene), 0.1f, -3.3f);
    EXPECT_EQ(none, 0);
    EXPECT_NEAR(all, 1, 1e-9);
  }
}

TEST(Presence, GoesByThePlaceOnTheStrand) {
  scene::Scene scene = straight_scene({{{0, 0, 0}, {0, 0, -8}, 0.5f, 0.5f, 1}}, true, 3);
  const scene::Source zero{.value = glm::vec3(0.0f)}, one{.value = glm::vec3(1.0f)};
  scene.materials[0].presence =
      scene::Source{.kind = scene::Source::Kind::ramp, .parts = {zero, one, zero}, .places = {0, 0.25f, 1}};
  scene::assign_fibers(&scene);
  const FiberScene fibers(scene);
  for (const float along : {0.1f, 0.25f, 0.55f, 0.9f}) {
    const double share = along < 0.25f ? along / 0.25 : (1 - along) / 0.75;
    // Stations are 1/32 of the strand apart, and the ramp has its corner at one of them.
    EXPECT_NEAR(shares_met(fibers, 0.1f, -8 * along)[0], share, z_limit * error_of(share) + 1e-5) << along;
  }
}

// What fills a bend belongs to both segments: it is there once, not twice.
TEST(Presence, IsThatOfTheStrandInTheBendsOfPolygons) {
  scene::Scene scene = straight_scene({{{0, 0, 0}, {0, 0, -8}, 0.5f, 0.5f, 1}}, true, 3);
  scene.grooms[0].points = {{-4, 0, 0}, {0, 0, 0}, {0, 0, -4}};
  scene.grooms[0].presence = {0.3f};
  const FiberScene fibers(scene);
  EXPECT_NEAR(shares_met(fibers, 0.25f, 0.25f)[0], 0.3, z_limit * error_of(0.3));
  EXPECT_NEAR(shares_met(fibers, 0.25f, 0.25f, true)[0], 0.3, 1.5 / rays);
}

TEST(Presence, OfTheRaysThatLeaveAHitIsDrawnAnew) {
  scene::Scene scene =
      straight_scene({{{0, 0, 0}, {0, 0, -8}, 0.5f, 0.5f, 1}, {{0, 3, 0}, {0, 3, -8}, 0.5f, 0.5f, 1}}, true);
  scene.grooms[0].presence = {1, 0.5f};
  const FiberScene fibers(scene);
  int together = 0;
  for (std::uint64_t key = 0; key < rays; ++key) {
    Ray past{.origin = {0.1f, 1.5f, -3.3f}, .direction = {0, 1, 0}},
        first{.origin = {0.1f, -5, -3.3f}, .direction = {0, 1, 0}};
    past.key = first.key = key;
    const std::optional<Hit> hit = fibers.intersect(first);
    ASSERT_TRUE(hit && hit->strand == 0);
    together += fibers.occluded(past) == fibers.occluded(ray_from(*hit, {0, 1, 0}));
  }
  EXPECT_NEAR(double(together) / rays, 0.5, z_limit * error_of(0.5));
}

// A pixel has 0.1 cm at y = 0 and 0.15 cm at y = 5; strands of 0.02 and 0.8 cm of width, at least three pixels each.
TEST(LeastWidth, WidensWhatTheCameraSeesThinAndLetsTheRestThrough) {
  for (const bool linear : {true, false}) {
    scene::Scene scene =
        straight_scene({{{0, 0, 0}, {0, 0, -8}, 0.01f, 0.01f, 1}, {{2, 5, 0}, {2, 5, -8}, 0.4f, 0.01f, 1}}, linear);
    scene.camera.eye = {0, -10, -4};
    scene.camera.look_at = {0, 0, -4};
    scene.camera.vertical_fov_deg = 90;
    scene.image.height = 200;
    scene.image.least_width_px = 3;
    const FiberScene fibers(scene);
    EXPECT_TRUE(fibers.has_presence());
    for (const float x : {-0.14f, 0.0f, 0.145f})
      EXPECT_NEAR(shares_met(fibers, x, -3.3f, true)[0], 0.01 / 0.15, 1.5 / rays) << linear << " " << x;
    for (const float x : {-0.16f, 0.155f}) EXPECT_EQ(shares_met(fibers, x, -3.3f, true)[0], 0) << linear << " " << x;
    EXPECT_NEAR(shares_met(fibers, 2.1f, -1.0f, true)[1], 1, 0.01) << "wider than 0.45 cm there, not at the next point";
    EXPECT_EQ(shares_met(fibers, 2.215f, -7.9f, true)[1] > 0, true) << "and not at its tip";
    EXPECT_EQ(shares_met(fibers, 2.235f, -7.9f, true)[1], 0);
    scene.image.least_width_px = 0.1f;
    EXPECT_FALSE(FiberScene(scene).has_presence());
  }
}

}  // namespace
}  // namespace tress::geometry
