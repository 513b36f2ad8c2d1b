// The epsilon of a row by the light that it carries, and the bound on the error that rows cause in a picture
// (ESTIMATOR.md, E8).
#include <algorithm>
#include <cmath>
#include <numbers>

#include "table/table.h"

namespace tress::adaptive {
namespace {

/// The part of a row's L2 error that the light of a picture sees, v of E8: the value in the bound, and the value in the
/// share of picture_error that a row may take. Measured (E8): at most 0.17 for fitted rows, 0.4 under a small bright
/// window.
constexpr double bound_sees = 1, share_sees = 0.1;
constexpr double least_epsilon = 1e-3;  // below it rows begin to be refused
/// Limits for rows of samples, in chi^2. Below the first, a row would need more paths than rows get; every first fit is
/// within the second.
constexpr double least_sampled_epsilon = 0.005, largest_sampled_epsilon = 0.5;

/// An upper bound of the factor from a row's objective to the square of its error relative to the light. For a density
/// the factor is 2 pi L/E^2, the relative squared distance of g from its mean. A blurred density varies no more than
/// the blur itself, integral G^2 = 1/(2 blur sqrt pi), and L is never below 1e-3/2pi. For a row of samples the factor
/// is 1: |integral (f - S) light| <= sqrt(chi^2) sd_f(light).
double relative_variation(const SliceDescription& slice, float energy) {
  if (slice.kind == SliceKind::samples) return 1;
  const double e = std::max(static_cast<double>(energy), 1e-6);
  return std::max(1 / (std::numbers::inv_sqrtpi_v<double> * static_cast<double>(slice.blur_rad)), 1e-3 / (e * e));
}

}  // namespace

double Service::Table::light_share(SliceId slice, std::uint32_t node, double unseen) const {
  const std::uint64_t light = slices_[slice]->light[node].load(std::memory_order_relaxed);
  return (static_cast<double>(light) / static_cast<double>(fixed_light(1)) + unseen) /
         static_cast<double>(std::max<std::uint64_t>(paths_, 1));
}

double Service::Table::epsilon_of(SliceId slice, std::uint32_t node, float energy) const {
  const Slice& of = *slices_[slice];
  if (!is_light_driven()) return epsilon_without_light(slice);
  // Counts the light of one path more than was seen, because few paths do not show that a row carries no light.
  const double share = light_share(slice, node, 1);
  const double variation = relative_variation(of.description, energy);
  const double rows = static_cast<double>(std::max<std::uint64_t>(queried_, 1));
  const double error = options_.picture_error / (share_sees * rows * share);
  const double epsilon = error * error / variation;
  return of.is_sampled() ? std::clamp(epsilon, least_sampled_epsilon, largest_sampled_epsilon)
                         : std::clamp(epsilon, least_epsilon, 1.0);
}

double Service::Table::bias_bound() const {
  if (paths_ == 0) return 0;
  double sum = 0;
  for (const Row& row : rows_) {
    const bool answers = slot_of(row).has_answer();
    if (!answers) continue;
    const double objective = objective_of(row);
    const double variation = relative_variation(slices_[row.slice]->description, row.energy);
    sum += light_share(row.slice, row.node, 0) * std::sqrt(variation * objective);
  }
  return bound_sees * sum;
}

}  // namespace tress::adaptive
