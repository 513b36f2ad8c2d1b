// The traced rays of one row, laid out for evaluation: g of an open row.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tress/adaptive/target.h"

namespace tress::inline v0_2::adaptive {

/// The rays of one row. Immutable after construction; any thread may read.
class TracedNodes {
 public:
  /// Keeps rays of positive, finite weight, sorted by azimuth wrapped into [-pi, pi). blur_rad is clamped to
  /// [1e-5, 10], weights to 1e12.
  TracedNodes(std::span<const TracedRay> rays, float blur_rad);

  std::size_t size() const { return attribute_.size(); }
  std::span<const float> azimuth() const { return {azimuth_.data(), size()}; }
  std::span<const float> weight() const { return {weight_.data(), size()}; }
  std::span<const float> attribute() const { return attribute_; }
  float blur_rad() const { return blur_rad_; }
  /// Mass of g: the sum of the weights.
  float energy() const { return energy_; }
  /// max(integral (g - mean)^2 dx, 1e-3 / 2 pi), the denominator of the objective. 1/rad.
  float variation() const { return variation_; }
  /// g at 6.5/blur or more equal steps from -pi on, from which variation() was computed. 1/rad.
  std::span<const float> grid() const { return grid_; }
  /// The memory by sizes, not capacities, so that it is the same on every machine of one word size.
  std::size_t bytes() const;

  /// g(x), 1/rad. x in radians, any turn. Never negative, never NaN.
  float density(float x) const;

 private:
  std::uint32_t bucket_of(float azimuth) const;

  std::vector<float> azimuth_, weight_, attribute_;  ///< the first two are padded with rays of weight 0
  std::vector<float> grid_;
  std::vector<std::uint32_t> starts_;  ///< the first ray of each bucket, which is about a blur wide; then size()
  float blur_rad_ = 0, energy_ = 0, variation_ = 0;
  float buckets_per_rad_ = 0, precision_ = 0, peak_ = 0;  ///< precision 1/(2 blur^2), peak of the Gaussian
};

/// Wrapped Gaussian of standard deviation sigma at x (radians, any turn), 1/rad.
float wrapped_gaussian(float x, float sigma);

}  // namespace tress::inline v0_2::adaptive
