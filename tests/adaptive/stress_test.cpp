// Learning where it fails: a method whose fits are wrong, rows with what samples do not see, pairs that are too few.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "fit/fit_mixture.h"
#include "fit/problem.h"
#include "fit/row_learner.h"
#include "fit/sketch_learner.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr double pi = std::numbers::pi;

/// Of one slice, with what begin() of a learner needs.
struct Bench {
  explicit Bench(std::vector<TracedRay> rays, float blur_rad)
      : nodes(rays, blur_rad), sketch(Sketch::bin_count(blur_rad)) {}

  FitContext context() {
    return {.options = options,
            .nodes = nodes,
            .sketch = sketch,
            .stop = stop,
            .random = RandomStream(7),
            .components = 8,
            .fit = fit,
            .has_fit = has_fit,
            .count = count};
  }

  Options options;
  TracedNodes nodes;
  Sketch sketch;
  StopTest stop;
  Mixture fit;
  bool has_fit = false;
  std::uint64_t count = 0;
};

Mixture one_component(float weight, float mu, float left, float right) {
  Mixture fit;
  fit.component_count = 1;
  fit.components[0] = {{mu, left, right}, weight};
  return fit;
}

std::vector<Mixture> bad_fits() {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  std::vector<Mixture> bad;
  for (const float weight : {nan, infinity, -1.0f, 0.5f, 2.0f}) bad.push_back(one_component(weight, 0, 0.1f, 0.1f));
  for (const float mu : {nan, infinity, 4.0f}) bad.push_back(one_component(1, mu, 0.1f, 0.1f));
  for (const float s : {nan, infinity, 0.0f, 0.003f, 0.51f}) {
    bad.push_back(one_component(1, 0, s, 0.1f));
    bad.push_back(one_component(1, 0, 0.1f, s));
  }
  bad.push_back(one_component(1.5f, 0, 0.1f, 0.1f));
  bad.back().uniform_weight = -0.5f;  // of the right mass, and negative far from the mode
  bad.push_back(one_component(1, 0, 0.1f, 0.1f));
  bad.back().component_count = Mixture::max_components + 1;
  return bad;
}

TEST(BadFit, IsReplacedByTheLastGoodOneAndCounted) {
  Bench bench({{0.5f, 1.0f, 1.0f}}, 0.2f);
  const Mixture good = one_component(1, 0.5f, 0.1f, 0.12f);
  for (const Mixture& bad : bad_fits()) {
    bench.fit = good;
    bench.has_fit = true;
    FitContext context = bench.context();
    context.publish(bad);
    EXPECT_EQ(context.bad_fits, 1u);
    EXPECT_EQ(bench.fit.components[0].shape.mu, good.components[0].shape.mu);
    EXPECT_EQ(bench.fit.density(1), good.density(1));
    context.publish(good);
    EXPECT_EQ(context.bad_fits, 1u);
  }
}

TEST(BadFit, IsReplacedByTheUniformOneWhereThereIsNoOther) {
  Bench bench({{0.5f, 0.7f, 1.0f}}, 0.2f);
  for (const Mixture& bad : bad_fits()) {
    bench.has_fit = false;
    FitContext context = bench.context();
    context.publish(bad);
    EXPECT_EQ(context.bad_fits, 1u);
    EXPECT_TRUE(bench.has_fit);
    EXPECT_EQ(bench.fit.component_count, 0u);
    EXPECT_FLOAT_EQ(bench.fit.energy(), 0.7f);
  }
}

// s in [max(0.004, floor), 0.5]: a side is no narrower than a quarter of the way to the second pair on it.
TEST(FitFloor, NoSideIsNarrowerThanThePairsCanShow) {
  for (std::uint64_t seed = 0; seed < 150; ++seed) {
    RandomStream random(41, seed);
    const float blur = 0.0175f + 0.3f * random.next() * random.next();
    std::vector<TracedRay> rays;
    for (int i = 0; i < 6; ++i) rays.push_back({6.28f * random.next(), random.next(), 1.0f});
    const TracedNodes nodes(rays, blur);
    Sketch sketch(Sketch::bin_count(blur));
    const float centre = 6.28f * random.next(), width = random.next() < 0.5f ? 6.28f : 0.2f;
    for (std::uint64_t i = 0; i < seed % 64; ++i) {
      const float x = centre + width * random.next();
      sketch.offer(x, nodes.density(x));
    }
    if (seed % 3 != 0) {
      for (const float x : gap_fill_azimuths(sketch.pairs(), blur)) sketch.offer(x, nodes.density(x));
    }
    const std::vector<ObservedPair> pairs = sketch.pairs();
    Mixture warm = one_component(nodes.energy(), 3, 0.004f, 0.004f);
    const Fit fit = fit_mixture(pairs, nodes.energy(), nodes.variation(), seed % 2 == 0 ? &warm : nullptr, {1e-4, 8});
    const Problem problem(pairs, nodes.energy());
    for (const Component& part : fit.mixture.parts()) {
      const auto [left, right] = problem.scale_floors(part.shape.mu);
      EXPECT_GE(part.shape.s_left, 0.9999 * left) << seed;
      EXPECT_GE(part.shape.s_right, 0.9999 * right) << seed;
    }
    EXPECT_TRUE(is_legal(fit.mixture, 8, nodes.energy())) << seed;
  }
}

// A thousandth to a tenth of the light in one direction, the rest from everywhere: own draws hardly ever meet it, and
// their scores alone let 41 % of such rows converge with errors up to 0.15.
TEST(StopTestStress, SeesASpikeThatNoScoreMet) {
  std::vector<TracedRay> rays{{0.4f, 0.01f, 1.0f}};
  for (int i = 0; i < 720; ++i) rays.push_back({static_cast<float>(2 * pi * (i / 720.0 - 0.5)), 0.99f / 720, 1.0f});
  Bench bench(std::move(rays), 0.0175f);
  bench.fit.uniform_weight = 1;
  bench.has_fit = true;
  FitContext context = bench.context();
  for (int test = 0; test < 4; ++test) {
    for (int i = 0; i < 16; ++i) bench.stop.add(0, 1, bench.nodes.variation());  // away from it nothing is wrong
    EXPECT_TRUE(context.test());
    EXPECT_EQ(bench.stop.verdict(), StopTest::Verdict::undecided);
  }
  EXPECT_TRUE(bench.stop.overruled());
  EXPECT_GT(bench.stop.bound(), 0.5f);  // the spike is all of the variation
}

/// f of the row is uniform and no score is off: whether the row converges is up to what else is asked.
void score_nothing(Bench& bench, FitContext& context) {
  for (int test = 0; test < 4 && bench.stop.verdict() == StopTest::Verdict::undecided; ++test) {
    for (std::uint32_t i = 0; i < bench.options.scores_per_test(); ++i) bench.stop.add(0, 1, bench.nodes.variation());
    EXPECT_TRUE(context.test());
  }
}

double squared_error(const Mixture& fit, const TracedNodes& nodes) {
  constexpr int points = 40000;  // 1/25 of the narrowest scale apart, 1/60 of the narrowest blur
  double sum = 0;
  for (int i = 0; i < points; ++i) {
    const auto x = static_cast<float>(2 * pi * i / points - pi);
    const double off = static_cast<double>(nodes.density(x)) - static_cast<double>(fit.density(x));
    sum += off * off;
  }
  return sum * 2 * pi / points / static_cast<double>(nodes.variation());
}

// Each bump is midway between two of the points that fill an empty sketch: 59 % of its square was seen.
TEST(StopTestStress, SeesBumpsInPhaseWithTheGapFill) {
  const float blur = 0.0105f;
  const std::vector<float> points = gap_fill_azimuths({}, blur);
  std::vector<TracedRay> rays;
  for (int i = 0; i < 1440; ++i) rays.push_back({static_cast<float>(2 * pi * (i / 1440.0 - 0.5)), 1.0f / 1440, 1.0f});
  // Twenty squares of mass^2/(2 sqrt(pi) blur) are 1.5 epsilon of the least variation.
  const auto mass =
      static_cast<float>(std::sqrt(0.015 / 20 * 1e-3 / (2 * pi) * 2 * std::sqrt(pi) * static_cast<double>(blur)));
  for (std::size_t i = 0; i < 20; ++i) rays.push_back({(points[7 * i] + points[7 * i + 1]) / 2, mass, 1.0f});
  Bench bench(std::move(rays), blur);
  bench.fit.uniform_weight = bench.nodes.energy();
  bench.has_fit = true;
  ASSERT_GT(squared_error(bench.fit, bench.nodes), 1.3 * bench.options.epsilon);
  FitContext context = bench.context();
  score_nothing(bench, context);
  EXPECT_EQ(bench.stop.verdict(), StopTest::Verdict::undecided);
  EXPECT_GT(bench.stop.bound(), 1.3 * bench.options.epsilon);
}

// What the fit has where it was never held against g: a part narrower than any gap.
TEST(StopTestStress, SeesAPartOfTheFitBetweenTwoPairs) {
  const float blur = 0.09f;
  const std::vector<float> points = gap_fill_azimuths({}, blur);
  std::vector<TracedRay> rays;
  for (int i = 0; i < 360; ++i) rays.push_back({static_cast<float>(2 * pi * (i / 360.0 - 0.5)), 1.0f / 360, 1.0f});
  Bench bench(std::move(rays), blur);
  bench.fit = one_component(0.001f, 0.75f * points[5] + 0.25f * points[6], 0.004f, 0.004f);
  bench.fit.uniform_weight = 0.999f;
  bench.has_fit = true;
  ASSERT_GT(squared_error(bench.fit, bench.nodes), bench.options.epsilon);
  FitContext context = bench.context();
  score_nothing(bench, context);
  EXPECT_EQ(bench.stop.verdict(), StopTest::Verdict::undecided);
}

/// The shipped method, with draws of its own in place of a render's, until its row has a verdict.
void learn_to_the_end(FitContext& context) {
  SketchLearner learner;
  learner.begin(context);
  const float share = context.options.uniform_share_open;
  while (context.stop.verdict() == StopTest::Verdict::undecided) {
    std::vector<ObservedPair> drawn;
    while (context.stop.scores() < context.options.scores_per_test()) {
      const float x = context.fit.sample(context.random.next(), share);
      drawn.push_back({x, context.g(x)});
      context.stop.add(static_cast<double>(drawn.back().g) - context.fit.density(x),
                       context.fit.proposal_density(x, share), context.nodes.variation());
    }
    context.test();
    if (context.stop.verdict() != StopTest::Verdict::undecided) return;
    for (const ObservedPair& pair : drawn) context.sketch.offer(pair.azimuth, pair.g);
    context.fill_gaps();
    learner.learn(context);
  }
}

// Hosts that fooled a test on pairs and draws: of each kind rows passed with up to 4 epsilon. What is asked now is a
// bound, so that none may, whatever the seed.
TEST(StopTestStress, NoRowWithASpikeConvergesFalsely) {
  constexpr float blur = 0.0175f;
  int converged = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    RandomStream random(43, seed);
    const auto up_to = [&](float low, float high) { return std::pow(10.0f, low + (high - low) * random.next()); };
    const float lit = up_to(-3, -1), at = 6.28f * random.next();
    std::vector<TracedRay> rays{{at, lit, 1.0f}};
    if (seed % 3 == 1) rays.push_back({6.28f * random.next(), lit * up_to(-1, 1), 1.0f});
    if (seed % 3 == 2) rays.push_back({at + blur * (2 + 8 * random.next()), lit * up_to(-2, -0.5f), 1.0f});
    for (int i = 0; i < 720; ++i) {
      rays.push_back({static_cast<float>(2 * pi * (i / 720.0 - 0.5)), (1 - lit) / 720, 1.0f});
    }
    Bench bench(std::move(rays), blur);
    bench.options.epsilon = 0.001;
    FitContext context = bench.context();
    context.random = RandomStream(44, seed);
    learn_to_the_end(context);
    if (bench.stop.verdict() != StopTest::Verdict::converged) continue;
    ++converged;
    EXPECT_LE(squared_error(bench.fit, bench.nodes), 1.001 * bench.options.epsilon) << seed;
    EXPECT_LE(bench.stop.bound(), bench.options.epsilon) << seed;
  }
  EXPECT_GT(converged, 150);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
