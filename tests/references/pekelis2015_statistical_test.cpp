// Samples of pekelis2015 follow its density, whatever its rows have become. Fixed seeds, family false-alarm rate 1e-4.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <iterator>
#include <memory>
#include <numbers>

#include "models/registry.h"
#include "models/sampled_density.h"
#include "references/taught_pekelis.h"
#include "support/seed.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr float degree = std::numbers::pi_v<float> / 180;

struct Case {
  float e, roughness, theta_deg, phi_deg;
};
constexpr Case cases[] = {{1.00f, 0.20f, 0, 0}, {0.85f, 0.10f, 40, 130}, {0.90f, 0.50f, -70, -95}};

enum class State { exact, absent, open, converged };

TEST(pekelis2015_statistics, samples_follow_the_density_in_every_state_and_reading) {
  double smallest = 1;
  std::uint64_t seed = test::seed(31);
  std::size_t tests = 0;
  for (const PekelisReading reading : {PekelisReading::corrected, PekelisReading::as_printed}) {
    for (const Case& c : cases) {
      for (const State state : {State::exact, State::absent, State::open, State::converged}) {
        if (reading == PekelisReading::as_printed && state != State::exact) continue;
        FiberParameters parameters;
        parameters.eccentricity = c.e;
        parameters.roughness = c.roughness;
        const FiberDirection wr{c.theta_deg * degree, c.phi_deg * degree};
        std::unique_ptr<FiberModel> without_rows;
        std::unique_ptr<test::TaughtPekelis> taught;
        const FiberModel* model = nullptr;
        if (state == State::exact) {
          without_rows = make_pekelis2015({.estimator = Estimator::exact}, reading);
          without_rows->add_fiber(parameters);
          model = without_rows.get();
        } else {
          taught = std::make_unique<test::TaughtPekelis>(parameters, reading);
          if (state != State::absent) taught->teach(wr, state == State::open ? 1 : 16, 1500);
          model = &taught->model();
        }
        const double p = test::density_p_value(*model, model->begin(0, wr, 0.3f, 0.6f, 0), seed++);
        EXPECT_GT(p, test::sidak_level(1e-4, 15))
            << static_cast<int>(state) << " e " << c.e << " theta " << c.theta_deg;
        smallest = std::min(smallest, p);
        ++tests;
      }
    }
  }
  EXPECT_EQ(tests, 15u);
  std::printf("smallest p value of %zu: %.3g\n", tests, smallest);
}

}  // namespace
}  // namespace tress::inline v0_2::fiber
