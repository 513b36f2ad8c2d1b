// What Highway compiles for several instruction sets gives the same within rounding on each that this machine has.
#include <gtest/gtest.h>
#include <hwy/highway.h>
#include <hwy/targets.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <vector>

#include "fit/fit_mixture.h"
#include "models/learned_model.h"
#include "tress/base/random.h"

namespace tress {
namespace {

/// The libraries use this one alone while it lives.
class OneInstructionSet {
 public:
  explicit OneInstructionSet(std::int64_t target) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
  ~OneInstructionSet() {
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
};

/// Those that this machine has and that are compiled, the best first.
std::vector<std::int64_t> instruction_sets() { return hwy::SupportedAndGeneratedTargets(); }

fiber::FiberParameters brown() {
  fiber::FiberParameters parameters;
  parameters.roughness = 0.25f;
  return parameters;
}

/// Values and densities of a converged model at 400 pairs of directions.
std::vector<float> vertex_values() {
  const fiber::FiberDirection known{0.3f, 0.7f};
  const auto model = test::model_in(test::Rows::converged, brown(), known);
  const fiber::FiberEvent event = model->begin(known);
  std::vector<float> values;
  RandomStream random(1);
  for (int i = 0; i < 400; ++i) {
    const fiber::FiberDirection wi{2.6f * (random.next() - 0.5f), 6.28f * (random.next() - 0.5f)};
    const fiber::FiberValue value = model->model().evaluate(event, wi);
    for (const glm::vec3& lobe : value.s) values.insert(values.end(), {lobe.x, lobe.y, lobe.z});
    values.push_back(value.pdf);
  }
  return values;
}

// Rows are taught and fitted anew under each set, so that the rounding of 24 passes of fits is in it. Fits are in
// double, and end after the same steps unless rounding falls on their last bit; what is left is single precision at the
// vertex: some 20 roundings of 2^-24. Found: 1.6e-7.
constexpr double rounding = 20 * 0x1p-24;

TEST(InstructionSets, GiveOneVertexWithinRounding) {
  const std::vector<std::int64_t> sets = instruction_sets();
  ASSERT_FALSE(sets.empty());
  std::vector<float> first;
  for (const std::int64_t set : sets) {
    const OneInstructionSet chosen(set);
    const std::vector<float> values = vertex_values();
    if (first.empty()) first = values;
    double difference = 0, power = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double d = static_cast<double>(values[i]) - static_cast<double>(first[i]);
      difference += d * d;
      power += static_cast<double>(first[i]) * static_cast<double>(first[i]);
    }
    std::printf("%s: relative difference %.2g\n", hwy::TargetName(set), std::sqrt(difference / power));
    EXPECT_LE(std::sqrt(difference / power), rounding) << hwy::TargetName(set);
  }
}

// One fit of the same pairs: double precision, some 40 steps of sums over 64 pairs. Where the fits stop at the same
// step they differ by rounding times the condition of the normal equations (1e-16 x 1e5 and less).
TEST(InstructionSets, GiveOneFitWithinRounding) {
  std::vector<adaptive::ObservedPair> pairs;
  const adaptive::SkewLogistic one{0.4f, 0.1f, 0.3f}, other{-1.5f, 0.4f, 0.2f};
  constexpr int count = 64;
  for (int i = 0; i < count; ++i) {
    const float x = static_cast<float>((i + 0.5) * 2 * std::numbers::pi / count - std::numbers::pi);
    pairs.push_back({x, 0.5f * one.density(x) + 0.3f * other.density(x) + 0.01f});
  }
  const double energy = 0.5 + 0.3 + 0.01 * 2 * std::numbers::pi, mean = energy / (2 * std::numbers::pi);
  double variation = 0;
  for (const adaptive::ObservedPair& pair : pairs) {
    variation +=
        (static_cast<double>(pair.g) - mean) * (static_cast<double>(pair.g) - mean) * 2 * std::numbers::pi / count;
  }
  adaptive::Mixture first;
  for (const std::int64_t set : instruction_sets()) {
    const OneInstructionSet chosen(set);
    const adaptive::Mixture fit = adaptive::fit_mixture(pairs, energy, variation, nullptr, {}).mixture;
    if (first.component_count == 0) first = fit;
    ASSERT_EQ(fit.component_count, first.component_count) << hwy::TargetName(set);
    for (int i = 0; i < 100; ++i) {
      const float x = static_cast<float>(i * 0.0628 - 3.14);
      EXPECT_NEAR(fit.density(x), first.density(x), static_cast<float>(rounding) * (1 + first.density(x)))
          << hwy::TargetName(set);
    }
  }
}

}  // namespace
}  // namespace tress
