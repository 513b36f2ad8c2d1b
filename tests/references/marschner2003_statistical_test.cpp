// Samples of marschner2003 follow its density, lobe by lobe and as a whole. Fixed seeds, family false-alarm rate 1e-4.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <iterator>

#include "models/registry.h"
#include "models/sampled_density.h"
#include "references/registry.h"
#include "support/seed.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr float degree = std::numbers::pi_v<float> / 180;

struct Case {
  float e, roughness, theta_deg, phi_deg;
};
constexpr Case cases[] = {
    {1.00f, 0.20f, 0, 0},    {0.85f, 0.10f, 40, 130}, {0.50f, 0.50f, 70, -95},
    {0.70f, 0.20f, -60, 10}, {0.85f, 0.20f, 88, 40},
};

TEST(marschner2003_statistics, samples_follow_the_density) {
  double smallest = 1;
  std::uint64_t seed = test::seed(31);
  for (const Case& c : cases) {
    FiberParameters parameters;
    parameters.eccentricity = c.e;
    parameters.roughness = c.roughness;
    const auto model = references::find_model("marschner2003")->make({});
    const FiberId fiber = model->add_fiber(parameters);
    const FiberEvent event = model->begin(fiber, {c.theta_deg * degree, c.phi_deg * degree}, 0.3f, 0.6f, 0);
    const double p = test::density_p_value(*model, event, seed++);
    EXPECT_GT(p, test::sidak_level(1e-4, std::size(cases))) << "e " << c.e << " theta_r " << c.theta_deg;
    smallest = std::min(smallest, p);
  }
  std::printf("smallest p value of %zu: %.3g\n", std::size(cases), smallest);
}

TEST(marschner2003_statistics, samples_of_every_lobe_alone_follow_its_density) {
  double smallest = 1;
  std::uint64_t seed = test::seed(71);
  for (const Lobe lobe : {Lobe::r, Lobe::tt, Lobe::trt, Lobe::glint}) {
    FiberParameters parameters;
    parameters.gain.fill(glm::vec3(0.0f));
    parameters.gain[static_cast<std::size_t>(lobe)] = glm::vec3(1.0f);
    const auto model = references::find_model("marschner2003")->make({});
    const FiberId fiber = model->add_fiber(parameters);
    const FiberEvent event = model->begin(fiber, {0.5f, 0.9f}, 0.3f, 0.6f, 0);
    const double p = test::density_p_value(*model, event, seed++);
    EXPECT_GT(p, test::sidak_level(1e-4, 4)) << lobe_names[static_cast<std::size_t>(lobe)];
    smallest = std::min(smallest, p);
  }
  std::printf("smallest p value of 4: %.3g\n", smallest);
}

}  // namespace
}  // namespace tress::inline v0_2::fiber
