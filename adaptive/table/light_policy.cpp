#include "table/light_policy.h"

#include <cmath>
#include <numbers>

namespace tress::inline v0_2::adaptive {
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

double LightPolicy::epsilon_of(const SliceDescription& slice, std::uint64_t light, float energy) const {
  const bool samples = slice.kind == SliceKind::samples;
  if (!is_driven()) return samples ? sampled_epsilon_ : epsilon_;
  const double rows = static_cast<double>(std::max<std::uint64_t>(queried, 1));
  // Counts the light of one path more than was seen, because few paths do not show that a row carries no light.
  const double error = picture_error_ / (share_sees * rows * share(light, 1));
  const double epsilon = error * error / relative_variation(slice, energy);
  return samples ? std::clamp(epsilon, least_sampled_epsilon, largest_sampled_epsilon)
                 : std::clamp(epsilon, least_epsilon, 1.0);
}

double LightPolicy::bias_of(const SliceDescription& slice, std::uint64_t light, float energy, double objective) const {
  return bound_sees * (share(light) * std::sqrt(relative_variation(slice, energy) * objective));
}

}  // namespace tress::inline v0_2::adaptive
