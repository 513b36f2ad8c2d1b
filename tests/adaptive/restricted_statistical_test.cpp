// Rows within an arc of azimuth. Seed 31; false-alarm rate 1e-4 for the file, shared by Sidak's rule.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "adaptive/random_ribbons.h"
#include "support/chi_square.h"
#include "support/quadrature.h"
#include "support/scale.h"
#include "support/seed.h"
#include "tress/adaptive/restricted.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double pi = std::numbers::pi;
constexpr int bins = 100;
const int draws = test::scaled(50000);
constexpr std::size_t tests_in_file = 36;
const Arc arcs[] = {{0, 3.14159265f}, {2.8f, 1.1f}, {-1.9f, 0.02f}, {5.1f, 6.28318531f}};

/// Integral of a density over the arc in bins, and the chi-square of what is drawn there.
template <class Density, class Sample>
void expect_exact(const Arc& arc, std::uint64_t key, Density&& density, Sample&& sample) {
  std::vector<double> counts(bins), expected(bins);
  double sum = 0;
  const auto edge = [&](int bin) { return double{arc.from} + double{arc.width} * bin / bins; };
  for (int bin = 0; bin < bins; ++bin) {
    sum += expected[static_cast<std::size_t>(bin)] =
        test::integrate([&](double x) { return density(static_cast<float>(x)); }, edge(bin), edge(bin + 1), 20);
  }
  EXPECT_NEAR(sum, 1, 2e-4) << key;  // densities have corners between points
  for (const double past : {0.001, 0.3, 0.999}) {
    const double gap = 2 * pi - double{arc.width};
    if (!(gap > 0.01)) break;
    EXPECT_EQ(density(static_cast<float>(edge(bins) + past * gap)), 0);
  }
  RandomStream random(test::seed(31), key);
  for (int i = 0; i < draws; ++i) {
    const float x = sample(random);
    EXPECT_GT(density(x), 0);
    double past = std::fmod(double{x} - double{arc.from}, 2 * pi);
    if (past < -1e-6) past += 2 * pi;
    counts[static_cast<std::size_t>(std::clamp(past / double{arc.width} * bins, 0.0, bins - 1.0))] += 1;
  }
  for (double& e : expected) e *= draws / sum;
  EXPECT_GT(test::chi_square(counts, expected).p_value, test::sidak_level(1e-4, tests_in_file)) << key;
}

TEST(Restricted, MixturesHaveNoMassOutsideAndDrawWhatIsInside) {
  Mixture mixture;
  mixture.component_count = 4;
  mixture.components[0] = {{0.1f, 0.05f, 0.4f}, 0.5f};
  mixture.components[1] = {{3.1f, 0.3f, 0.02f}, 0.2f};
  mixture.components[2] = {{-1.7f, 0.004f, 0.005f}, 0.3f};
  mixture.components[3] = {{1.5f, 0.5f, 0.5f}, 0.1f};
  std::uint64_t key = 0;
  for (const float uniform : {0.0f, 0.2f}) {
    mixture.uniform_weight = uniform;
    for (const Arc& arc : arcs) {
      const RestrictedMixture restricted(mixture, arc);
      EXPECT_NEAR(double{restricted.share_inside()} * double{mixture.energy()},
                  test::integrate([&](double x) { return mixture.density(static_cast<float>(x)); }, arc.from,
                                  double{arc.from} + double{arc.width}, 2000),
                  1e-4);
      EXPECT_FLOAT_EQ(restricted.density(arc.from + 0.01f),
                      mixture.density(arc.from + 0.01f) / restricted.share_inside());
      for (const float u_share : {0.0f, 0.05f}) {
        expect_exact(
            arc, key++, [&](float x) { return restricted.proposal_density(x, u_share); },
            [&](RandomStream& random) { return restricted.sample(random.next(), u_share); });
      }
    }
  }
}

TEST(Restricted, RibbonsHaveNoMassOutsideAndDrawWhatIsInside) {
  std::uint64_t key = 100;
  for (const std::uint64_t seed : {2u, 3u, 4u, 5u, 6u}) {
    const Ribbon ribbon = random_ribbon(seed);
    for (const Arc& arc : arcs) {
      const RestrictedRibbon restricted(ribbon, arc);
      // The marginal over azimuth, from the ribbon's distribution function; heights are drawn as the ribbon draws them.
      const double inside = double{restricted.share_inside()};
      const auto marginal = [&](float x) {
        const float t = 0.1f;
        if (restricted.density(x, t) == 0 && ribbon.density(x, t) > 0) return 0.0;
        const auto layer = [&](std::span<const RibbonKnot> knots) {
          const float at = wrap_angle(x);
          for (std::size_t k = 0; k < knots.size(); ++k) {
            const RibbonKnot &a = knots[k], &b = knots[(k + 1) % knots.size()];
            const float width = wrap_angle(b.azimuth - a.azimuth), from = wrap_angle(at - a.azimuth);
            const float whole = width < 0 ? width + 2 * static_cast<float>(pi) : width;
            const float past = from < 0 ? from + 2 * static_cast<float>(pi) : from;
            if (past <= whole) return double{a.density + past / whole * (b.density - a.density)};
          }
          return 0.0;
        };
        return (layer(ribbon.main()) + layer(ribbon.broad())) / inside;
      };
      EXPECT_NEAR(restricted.density(arc.from + 0.01f, 0.1f), ribbon.density(arc.from + 0.01f, 0.1f) / inside, 1e-5);
      expect_exact(arc, key++, marginal, [&](RandomStream& random) {
        const float u = random.next();
        return restricted.sample(u, random.next()).azimuth;
      });
    }
  }
}

TEST(Restricted, WithoutLightInsideTheyAreUniform) {
  Mixture mixture;
  mixture.component_count = 1;
  mixture.components[0] = {{0, 0.004f, 0.004f}, 0.5f};
  const Arc arc{3, 0.1f};
  const RestrictedMixture restricted(mixture, arc);
  EXPECT_FLOAT_EQ(restricted.proposal_density(3.05f, 0), 10);
  EXPECT_FLOAT_EQ(restricted.density(3.05f), 5);
  EXPECT_TRUE(arc.contains(restricted.sample(0.7f, 0)));
  EXPECT_EQ(RestrictedMixture(Mixture(), arc).density(3.05f), 0);
  const std::vector<RibbonRow::Part> parts{{random_ribbon(2), 0.5f}, {random_ribbon(3), 0.25f}};
  const RestrictedRow row(RibbonRow(parts), arc);
  EXPECT_EQ(row.parts(), 2u);
  EXPECT_EQ(row.mass(1), 0.25f);
  EXPECT_EQ(row.ribbon(1).density(0, 0), 0);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
