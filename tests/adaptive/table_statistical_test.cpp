// What "converged" is worth: the true error of converged rows on a family of moving peaks.
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <string>
#include <vector>

#include "adaptive/drive_service.h"
#include "adaptive/toy_target.h"
#include "tress/adaptive/service.h"

namespace tress::inline v0_2::adaptive {
namespace {

// Relative squared L2 error by a midpoint sum of 1024 points (spacing 0.006, a thirtieth of the narrowest blur).
double true_objective(const Mixture& fit, const TracedNodes& nodes) {
  constexpr int points = 1024;
  double sum = 0;
  for (int i = 0; i < points; ++i) {
    const auto x = static_cast<float>(2 * std::numbers::pi * (i + 0.5) / points - std::numbers::pi);
    const double r = static_cast<double>(fit.density(x)) - nodes.density(x);
    sum += r * r;
  }
  return sum * 2 * std::numbers::pi / points / nodes.variation();
}

struct Case {
  double epsilon;
  std::uint64_t passes;
  double converged_share;  // asked for
  double false_share;      // tolerated
};

class ConvergedRows : public ::testing::TestWithParam<Case> {};

// Fixed seed 77: the result is a number, not a draw. The design's prototypes converge falsely in 0.1 % (epsilon 0.01)
// and 0.3 % (0.001) of rows; of 1200 rows that is 1.2 and 3.6 expected, and more than 8 or 12 by chance less than once
// in 10^4 (Poisson: 3e-5 and 2e-4).
TEST_P(ConvergedRows, AreBelowEpsilonButForAFew) {
  const auto [epsilon, passes, converged_share, false_share] = GetParam();
  const testing::MovingPeaks target;
  Options options;
  options.epsilon = epsilon;
  Service service(options, target);
  const std::vector<float> blurs = {0.1f, 0.2f, 0.35f};
  for (std::uint32_t p = 0; p < 3; ++p) service.add_slice(testing::toy_slice(p, 20, blurs[p]));
  for (std::uint64_t pass = 0; pass < passes; ++pass) {
    testing::run_pass(service, 3, pass, 20000, 2);
    service.publish();
  }
  std::vector<double> errors;
  std::size_t created = 0;
  for (std::uint32_t p = 0; p < 3; ++p) {
    const SliceDescription& slice = service.slice(p);
    for (std::uint32_t node = 0; node < slice.node_count(); ++node) {
      const RowView row = service.peek(p, node / 20, node % 20);
      created += row.state != RowState::absent ? 1 : 0;
      if (row.state != RowState::converged) continue;
      std::vector<TracedRay> rays;
      target.trace(slice, slice.axis_a[node / 20], slice.axis_b[node % 20], rays);
      errors.push_back(true_objective(*row.fit, TracedNodes(rays, slice.blur_rad)));
    }
  }
  std::ranges::sort(errors);
  ASSERT_EQ(created, 1200u);
  ASSERT_FALSE(errors.empty());
  const double share = static_cast<double>(errors.size()) / static_cast<double>(created);
  const auto wrong = static_cast<double>(std::ranges::count_if(errors, [&](double e) { return e > epsilon; }));
  RecordProperty("converged_share", std::to_string(share));
  RecordProperty("false", std::to_string(wrong));
  RecordProperty("median_error", std::to_string(errors[errors.size() / 2]));
  RecordProperty("p99_error", std::to_string(errors[errors.size() * 99 / 100]));
  RecordProperty("worst_error", std::to_string(errors.back()));
  EXPECT_GE(share, converged_share);
  EXPECT_LE(wrong / static_cast<double>(errors.size()), false_share) << "worst " << errors.back();
  EXPECT_LE(errors.back(), 3 * epsilon);
}

INSTANTIATE_TEST_SUITE_P(Epsilons, ConvergedRows,
                         ::testing::Values(Case{0.01, 20, 0.99, 8.0 / 1200}, Case{0.001, 24, 0.9, 12.0 / 1200}));

}  // namespace
}  // namespace tress::inline v0_2::adaptive
