// How far rows are off under the attenuation that their forms ask: held against integrals, and reported by the service.
#include "fit/absorbed_error.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

#include "adaptive/drive_service.h"
#include "adaptive/toy_target.h"
#include "fit/fit_mixture.h"
#include "table/error_quantiles.h"
#include "tress/adaptive/service.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double pi = std::numbers::pi;
constexpr float blur = 0.2f;

/// Two bundles that overlap, of attributes 1 and 3: any component between them has some of both.
std::vector<TracedRay> overlapping() {
  std::vector<TracedRay> rays;
  for (int i = 0; i < 64; ++i) {
    const float t = (static_cast<float>(i) + 0.5f) / 64;
    rays.push_back({0.9f * t * t, 0.5f / 64, 1.0f});
    rays.push_back({0.8f + 0.7f * t, 0.4f / 64, 3.0f});
  }
  return rays;
}

/// The definition, at 20,000 steps and without any of the library's sums.
template <class Density>
double by_brute_force(const std::vector<TracedRay>& rays, double rate, const Density& fit) {
  constexpr int points = 20000;
  std::vector<double> g(points), f(points);
  double mass = 0, error = 0, variation = 0;
  for (const TracedRay& ray : rays) mass += ray.weight * std::exp(-rate * ray.attribute);
  for (int i = 0; i < points; ++i) {
    const double x = -pi + 2 * pi * i / points;
    double density = 0;
    for (const TracedRay& ray : rays) {
      for (int turn = -1; turn <= 1; ++turn) {
        const double d = (x - ray.azimuth + 2 * pi * turn) / blur;
        density += ray.weight * std::exp(-rate * ray.attribute - 0.5 * d * d);
      }
    }
    density /= blur * std::sqrt(2 * pi);
    error += (density - fit(x)) * (density - fit(x));
    variation += (density - mass / (2 * pi)) * (density - mass / (2 * pi));
  }
  return error / variation;
}

double gamma_law(double rate, double mean, double variance) {
  return variance > 0 ? std::pow(1 + rate * variance / mean, -mean * mean / variance) : std::exp(-rate * mean);
}

Mixture fitted(const TracedNodes& nodes, int components) {
  std::vector<ObservedPair> pairs;
  for (int i = 0; i < 128; ++i) {
    const auto x = static_cast<float>(-pi + 2 * pi * i / 128);
    pairs.push_back({x, nodes.density(x)});
  }
  Mixture fit = fit_mixture(pairs, nodes.energy(), nodes.variation(), nullptr, {0.0001, components}).mixture;
  assign_attributes(fit, nodes);
  return fit;
}

// Tolerance: both sums are within 0.001 of |g - f| at half of the narrowest scale (ESTIMATOR.md, E3), so within 0.002
// of its square; g is of floats, 1e-5 of |g|, which is 2e-5 |g|/|g - f| of the square: errors here are above 1e-4 of
// |g|^2, so another 0.002.
constexpr double relative = 0.005;

TEST(AbsorbedError, IsTheIntegralForMixtures) {
  const std::vector<TracedRay> rays = overlapping();
  const TracedNodes nodes(rays, blur);
  for (const int components : {1, 2, 4}) {
    const Mixture fit = fitted(nodes, components);
    for (const double rate : {0.25, 1.0, 3.0}) {
      const auto colored = [&](double x) {
        double f =
            fit.uniform_weight / (2 * pi) * gamma_law(rate, fit.uniform_attribute_mean, fit.uniform_attribute_variance);
        for (const Component& part : fit.parts()) {
          f += part.weight * gamma_law(rate, part.attribute_mean, part.attribute_variance) *
               part.shape.density(static_cast<float>(x));
        }
        return f;
      };
      const double expected = by_brute_force(rays, rate, colored);
      ASSERT_GT(expected, 1e-4);
      const std::optional<double> found = absorbed_error(fit, nodes, static_cast<float>(rate));
      ASSERT_TRUE(found);
      EXPECT_NEAR(*found, expected, relative * expected) << components << " components, rate " << rate;
    }
  }
}

// Floats would hold neither g nor its square where 1e-26 of the light is left.
TEST(AbsorbedError, IsReportedAtAnyRateThatLeavesLight) {
  const TracedNodes nodes(overlapping(), blur);
  const Mixture fit = fitted(nodes, 2);
  const std::optional<double> dark = absorbed_error(fit, nodes, 60.0f);
  ASSERT_TRUE(dark);
  EXPECT_TRUE(std::isfinite(*dark));
  EXPECT_GT(*dark, absorbed_error(fit, nodes, 0.5f).value());
  EXPECT_FALSE(absorbed_error(fit, nodes, 100.0f)) << "exp(-100) of the light is left";
  EXPECT_FALSE(absorbed_error(Mixture{}, TracedNodes({}, blur), 1.0f));
}

TEST(AbsorbedError, OfManyRatesFourStandForAll) {
  EXPECT_TRUE(representative_rates({}).empty());
  const std::vector<float> four{1, 2, 3, 4};
  EXPECT_EQ(representative_rates(four), four);
  const std::vector<float> seven{1, 2, 3, 4, 5, 6, 7};
  EXPECT_EQ(representative_rates(seven), (std::vector<float>{1, 3, 5, 7}));
}

// Of 8,000 nodes a hash takes 1,000 with a deviation of 30: 150 off is a chance of 6e-7 over all hashes; this one is
// fixed.
TEST(AbsorbedError, OneRowInEightStandsForTheOthers) {
  int chosen = 0;
  for (std::uint32_t lobe = 0; lobe < 80; ++lobe) {
    for (std::uint32_t node = 0; node < 100; ++node) {
      chosen += stands_for_others({lobe, {1.55f, 0.85f, 0.0f}}, node) ? 1 : 0;
      EXPECT_EQ(stands_for_others({lobe, {1.55f, 0.85f, 0.0f}}, node),
                stands_for_others({lobe, {1.55f, 0.85f, -0.0f}}, node));
    }
  }
  EXPECT_NEAR(chosen, 1000, 150);
}

TEST(ErrorQuantiles, AreThoseOfTheSortedValuesToAHundredth) {
  ErrorQuantiles quantiles;
  EXPECT_EQ(quantiles.quantile(0.5), 0);
  std::vector<double> values;
  RandomStream random(5, 0);
  for (int i = 0; i < 1001; ++i) {
    values.push_back(std::pow(10.0, -6 * static_cast<double>(random.next())));
    quantiles.add(values.back());
  }
  std::ranges::sort(values);
  for (const double share : {0.1, 0.5, 0.9, 1.0}) {
    const double exact = values[static_cast<std::size_t>(std::ceil(share * 1001)) - 1];
    EXPECT_GE(quantiles.quantile(share), exact * (1 - 1e-7));
    EXPECT_LE(quantiles.quantile(share), exact * (1 + 1.0 / 128 + 1e-7));
  }
  EXPECT_EQ(quantiles.count(), 1001u);
}

class Nothing final : public RowForm {
 public:
  std::size_t bytes(const RowView&) const override { return 64; }
  void write(const RowView&, void*) const override {}
};

struct Learned {
  PassReport report;
  TableSnapshot image;
  std::uint64_t measured = 0;  ///< rows that have converged and stand for others
  double largest = -1;         ///< error of theirs at `rates`, from what is published
};

constexpr std::uint32_t size = 16;

Learned learn(unsigned threads, const std::vector<std::vector<float>>& forms, const std::vector<float>& rates = {},
              const Learner* learner = &sketch_learner, const TableSnapshot* cache = nullptr) {
  const tbb::global_control width(tbb::global_control::max_allowed_parallelism, threads);
  const testing::MovingPeaks target;
  Options options;
  options.learner = learner;
  Service service(options, target);
  const SliceId slice = *service.add_slice(testing::toy_slice(0, size));
  EXPECT_FALSE(cache != nullptr && service.load(*cache).has_value());
  for (const std::vector<float>& form : forms) EXPECT_TRUE(service.add_form(slice, std::make_shared<Nothing>(), form));
  Learned learned;
  for (std::uint64_t pass = 0; pass < 12; ++pass) {
    testing::run_pass(service, 1, pass, 3000, threads);
    learned.report = service.publish();
  }
  learned.image = service.snapshot();
  for (const CachedSlice& stored : learned.image.slices) {
    for (const CachedRow& row : stored.rows) {
      if (row.state != RowState::converged || !stands_for_others(stored.description.key, row.node)) continue;
      ++learned.measured;
      std::vector<TracedRay> rays;
      const SliceDescription& d = service.slice(slice);
      target.trace(d, d.axis_a[row.node / size], d.axis_b[row.node % size], rays);
      const TracedNodes nodes(rays, d.blur_rad);
      for (const float rate : rates) {
        learned.largest = std::max(learned.largest, absorbed_error(row.density()->fit, nodes, rate).value_or(-1));
      }
    }
  }
  return learned;
}

TEST(AbsorbedObjective, IsOfTheRowsThatConvergedAtTheRatesOfTheirForms) {
  const Learned learned = learn(1, {{2.0f, 0.5f}, {0.5f, 1.0f}}, {0.5f, 1.0f, 2.0f});
  const AbsorbedObjective& absorbed = learned.report.absorbed_objective;
  EXPECT_GT(absorbed.rows, 8u);
  EXPECT_EQ(absorbed.rows, learned.measured);
  EXPECT_GT(absorbed.p50, 0);
  EXPECT_LE(absorbed.p50, absorbed.p90);
  EXPECT_LE(absorbed.p90, absorbed.max);
  // Rounded up by 1/128; the moments that are saved are rounded to 2^-9 of themselves, so that the share of a part
  // moves by up to rate 2 x attribute 3 / 512 = 1.2 %: in |g - f| of a part, an absolute error of 1.4e-4 |g|^2.
  EXPECT_NEAR(absorbed.max, learned.largest, learned.largest / 100 + 2 * std::sqrt(1.4e-4 * learned.largest) + 1.4e-4);
}

TEST(AbsorbedObjective, IsOfNoRowsWithoutRates) {
  EXPECT_EQ(learn(1, {}).report.absorbed_objective, AbsorbedObjective{});
  EXPECT_EQ(learn(1, {{}, {0.0f, -1.0f, std::nanf(""), INFINITY}}).report.absorbed_objective, AbsorbedObjective{});
}

TEST(AbsorbedObjective, IsOfNoRowThatACacheBrought) {
  const Learned first = learn(1, {{1.0f}});
  ASSERT_GT(first.report.absorbed_objective.rows, 0u);
  const Learned second = learn(1, {{1.0f}}, {}, &sketch_learner, &first.image);
  EXPECT_EQ(second.report.absorbed_objective.rows, second.measured - first.measured);
  EXPECT_GE(second.report.rows_converged, first.report.rows_converged);
}

TEST(AbsorbedObjective, ChangesNoRowAndNoBitWithTheThreads) {
  const Learned clear = learn(1, {});
  const Learned one = learn(1, {{0.5f, 1.0f, 3.0f}});
  EXPECT_EQ(encode_cache(one.image), encode_cache(clear.image)) << "what is learned does not depend on rates";
  for (const unsigned threads : {2u, 8u}) {
    const Learned more = learn(threads, {{0.5f, 1.0f, 3.0f}});
    EXPECT_EQ(more.report.absorbed_objective, one.report.absorbed_objective) << threads << " threads";
    EXPECT_EQ(encode_cache(more.image), encode_cache(one.image));
  }
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
