// `corrected` against `exact`: the same mean, whatever the rows have become. Seeds are fixed; the family of z-tests has
// a false-alarm rate of 1e-4.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "models/learned_model.h"
#include "support/chi_square.h"
#include "support/seed.h"

namespace tress {
namespace {

using fiber::Estimator;
using fiber::FiberDirection;
using fiber::FiberEvent;
using fiber::FiberParameters;
using fiber::FiberValue;
using test::LearnedModel;
using test::Rows;

constexpr float pi = std::numbers::pi_v<float>;
constexpr double family_level = 1e-4;

// Many directions: wr, wi and xi at random. The mean of (corrected - exact) per lobe is the bias of the decision's hash
// and of the few rays; both read the same (wr, wi), so that what is left to chance is the correction alone.
TEST(corrected, mean_over_directions_is_that_of_exact) {
  constexpr int directions = 10000;
  FiberParameters parameters;
  parameters.sigma_a = {0.1f, 0.4f, 1.0f};
  const FiberDirection taught{0.3f, 0.7f};
  std::vector<double> p_values;
  for (const Rows rows : {Rows::open, Rows::converged}) {
    const auto rows_of = test::model_in(rows, parameters, taught, false);
    rows_of->read_by(Estimator::corrected);
    const LearnedModel exact(parameters, Estimator::exact);
    std::array<test::SampleMean, 3> difference, value;
    RandomStream random(test::seed(101));
    for (int i = 0; i < directions; ++i) {
      // Half the events at the direction that was taught, so that rows are what `rows` says.
      const FiberDirection wr =
          i % 2 == 0 ? taught : FiberDirection{2.6f * (random.next() - 0.5f), 2 * pi * (random.next() - 0.5f)};
      const float xi1 = random.next(), xi2 = random.next();
      const FiberEvent event = rows_of->begin(wr, xi1, xi2);
      const FiberDirection wi{2.6f * (random.next() - 0.5f), 2 * pi * (random.next() - 0.5f)};
      const FiberValue one = rows_of->model().evaluate(event, wi);
      const FiberValue other = exact.model().evaluate(exact.begin(wr, xi1, xi2), wi);
      for (std::size_t p = 0; p < 3; ++p) {
        difference[p].add(static_cast<double>(one.s[p + 1].g - other.s[p + 1].g));
        value[p].add(static_cast<double>(other.s[p + 1].g));
      }
    }
    for (std::size_t p = 0; p < 3; ++p) {
      p_values.push_back(test::z_test(difference[p].mean(), 0, difference[p].standard_error()));
      EXPECT_GT(p_values.back(), test::sidak_level(family_level, 6)) << test::name_of(rows) << " lobe " << p + 1;
      std::printf("%s p %zu: mean difference %.2g +- %.2g of %.3g\n", test::name_of(rows), p + 1, difference[p].mean(),
                  difference[p].standard_error(), value[p].mean());
    }
  }
}

// The decision is a hash of 192 bits of input: it must come 1 time in 16 for the neighbours of a direction, of a
// known direction and of xi, each held while the others stand still, in every range of floats that occurs.
TEST(corrected, decision_comes_one_time_in_sixteen_along_every_argument) {
  constexpr int count = 4000;
  const FiberParameters parameters;
  const FiberDirection taught{0.3f, 0.7f};
  const auto model = test::model_in(Rows::converged, parameters, taught, true);
  const FiberDirection wi{0.1f, 2.9f};
  ASSERT_EQ(model->model().evaluate(model->begin(taught), wi).exact_queries, 0);
  model->read_by(Estimator::corrected);
  const FiberValue fitted = model->model().evaluate(model->begin(taught), wi);
  for (int argument = 0; argument < 4; ++argument) {
    int decided = 0;
    for (int i = 0; i < count; ++i) {
      FiberDirection moved_wr = taught, moved_wi = wi;
      float xi1 = 0.37f;
      const float step = static_cast<float>(i) * 1e-6f;
      if (argument == 0) moved_wr.phi += step;
      if (argument == 1) xi1 += step;
      if (argument == 2) moved_wi.theta += step;
      if (argument == 3) moved_wi.phi += step;
      const FiberValue value = model->model().evaluate(model->begin(moved_wr, xi1), moved_wi);
      decided += value.exact_queries == value.queries ? 1 : 0;
    }
    const double mean = count / 16.0;
    EXPECT_GT(test::z_test(decided, mean, std::sqrt(mean * 15 / 16)), test::sidak_level(family_level, 4))
        << "argument " << argument;
  }
  EXPECT_GT(fitted.queries, 0);
}

// Light that arrives from all sides: the mean weight of the sampler under `corrected` is that under `exact`, and its
// negative weights are few. 4.5 standard errors (false alarm 7e-6 each, 4 of them).
TEST(corrected, mean_weight_is_that_of_exact_and_few_weights_are_negative) {
  constexpr int samples = 20000;
  for (const bool clear : {true, false}) {
    FiberParameters parameters;
    parameters.sigma_a = clear ? glm::vec3(0) : glm::vec3(0.1f, 0.4f, 1.0f);
    const FiberDirection known{0.3f, 0.7f};
    const auto model = test::model_in(Rows::converged, parameters, known, false);
    model->read_by(Estimator::corrected);
    const FiberEvent any = model->begin(known);
    double expected = 0;
    for (const glm::vec3& energy : any.energy) expected += static_cast<double>(energy.g);
    test::SampleMean weight;
    int negative = 0;
    float largest = 0;
    RandomStream random(test::seed(7));
    for (int i = 0; i < samples; ++i) {
      const float xi1 = random.next(), xi2 = random.next();
      const auto sample = model->model().sample(model->begin(known, xi1, xi2),
                                                {random.next(), random.next(), random.next(), random.next()});
      const float w = sample.value.total().g / sample.value.pdf;
      weight.add(static_cast<double>(w));
      negative += w < 0 ? 1 : 0;
      largest = std::max(largest, std::fabs(w));
    }
    EXPECT_NEAR(weight.mean(), expected, 2e-3 + 4.5 * weight.standard_error());
    EXPECT_LT(negative, samples / 50);
    std::printf("%s: mean weight %.5f +- %.5f, energy %.5f; %.2f %% negative, largest %.2f\n",
                clear ? "clear" : "colored", weight.mean(), weight.standard_error(), expected,
                100.0 * negative / samples, static_cast<double>(largest));
  }
}

}  // namespace
}  // namespace tress
