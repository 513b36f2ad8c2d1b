// Rows of samples whose true error is about epsilon: how often a later stage declares them converged.
#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "adaptive/listed_samples.h"
#include "fiber/rough_rows.h"
#include "fit/learn_stage.h"
#include "support/seed.h"
#include "tress/base/random.h"

namespace tress {
namespace {

using adaptive::SampledTarget;
using adaptive::StagedRow;

struct Node {
  const SampledTarget* target;
  adaptive::SliceDescription slice;
  float a, b;
};

Node rough_node(const SampledTarget& target, std::size_t i) {
  RandomStream random(test::seed(53), i, 0);
  fiber::FiberParameters fiber;
  fiber.eccentricity = 0.5f + 0.5f * random.next();
  fiber.roughness = 0.04f * std::pow(10.0f, random.next());
  const float theta = 1.4f * (2 * random.next() - 1);
  return {&target, fiber::rough_slice(fiber), theta, 0.5f * std::numbers::pi_v<float> * random.next()};
}

// Seeds 52 and 53: 600 rows, 60 of each hostile family and 180 of rough fibers, fitted at a stage, their true T by
// 131,072 paths, and epsilon such that T is 0.9 to 1.5 of it. The next stage tests each and fits to all paths, as a row
// of a service does; those that pass have their true T by 2^21 paths. A row at epsilon passes with a probability of
// 0.001, of 0.0066 where the stated deviation is 0.8 of the true one, and half of that or less above it: of 500 rows
// above epsilon more than 8 pass with a probability below 1e-4. What is published is the fit to all paths, which may be
// another optimum: 1 of 3,000 rows was so above 1.5 (seeds 0 to 4 of TRESS_TEST_SEED, none at 0), so more than 3 of 600
// have a probability below 1e-4.
TEST(EdgeOfConvergence, IsSeldomPassedByLaterStages) {
  constexpr std::array<std::uint32_t, 4> stages{512, 2048, 8192, 16384};
  constexpr std::size_t of_family = 60, rough = 180;
  constexpr std::uint32_t true_paths = 1u << 17, paths_of_passed = 1u << 21;
  std::vector<std::unique_ptr<const testing::ListedSamples>> hostile;
  std::vector<Node> nodes;
  for (const std::string family : {"wide", "rare", "spike", "comb", "ring", "double", "heavy"}) {
    hostile.push_back(
        std::make_unique<const testing::ListedSamples>(testing::sampled_stress(family, of_family, test::seed(52))));
    for (std::size_t i = 0; i < of_family; ++i)
      nodes.push_back({hostile.back().get(), testing::ListedSamples::slice(i), 0, 0});
  }
  const std::unique_ptr<const SampledTarget> fibers = fiber::make_rough_target();
  for (std::size_t i = 0; i < rough; ++i) nodes.push_back(rough_node(*fibers, i));

  struct Seen {
    double true_share = 0;       ///< of the row that was tested, T over epsilon
    double published_share = 0;  ///< of the row that is fitted then
    bool passed = false;
  };
  std::vector<Seen> seen(nodes.size());
  tbb::parallel_for(std::size_t{0}, nodes.size(), [&](std::size_t i) {
    const Node& node = nodes[i];
    const std::uint32_t before = stages[i % 3], after = stages[i % 3 + 1];
    const auto staged = [&](std::uint32_t paths, std::uint32_t had, const adaptive::RibbonRow* row) {
      return adaptive::learn_stage(*node.target, node.slice, node.a, node.b, paths, had, row, nullptr);
    };
    const auto truth = [&](const adaptive::RibbonRow& row, std::uint32_t paths) {
      return adaptive::test_samples(*node.target, node.slice, node.a, node.b, row, 1, paths).chi2;
    };
    const StagedRow first = staged(before, 0, nullptr);
    if (!first.usable) return;
    Seen& one = seen[i];
    one.true_share = 0.9 + 0.6 * static_cast<double>(RandomStream(test::seed(52), i, 3).next());
    const double epsilon = truth(first.row, true_paths) / one.true_share;
    const StagedRow next = staged(after, before, &first.row);
    one.passed = adaptive::may_converge(after) && next.test.bound() <= epsilon;
    if (!one.passed) return;
    one.true_share = truth(first.row, paths_of_passed) / epsilon;
    one.published_share = truth(next.row, paths_of_passed) / epsilon;
  });
  int tested = 0, near = 0, near_passed = 0, beyond_passed = 0, far = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const Seen& one = seen[i];
    tested += one.true_share > 0 ? 1 : 0;
    const bool is_near = one.true_share > 0 && one.true_share < 1.1;
    near += is_near ? 1 : 0;
    near_passed += is_near && one.passed ? 1 : 0;
    beyond_passed += one.true_share > 1 && one.passed ? 1 : 0;
    far += one.passed && one.published_share > 1.5 ? 1 : 0;
  }
  RecordProperty("passed", std::to_string(near_passed) + " of " + std::to_string(near) + " within 0.9 and 1.1, " +
                               std::to_string(beyond_passed) + " above 1, " + std::to_string(far) +
                               " published above 1.5");
  EXPECT_EQ(tested, 600);
  EXPECT_LE(beyond_passed, 8);
  EXPECT_LE(far, 3);
}

}  // namespace
}  // namespace tress
