// The traced rays of one row, laid out for evaluation: g of an open row.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "tress/adaptive/target.h"

namespace tress::adaptive {

/// Immutable after construction; any thread may read.
class TracedNodes {
 public:
  /// Keeps rays of positive weight, sorted by azimuth wrapped into [-pi, pi).
  TracedNodes(std::span<const TracedRay> rays, float blur_rad);

  std::size_t size() const { return azimuth_.size(); }
  std::span<const float> azimuth() const { return azimuth_; }
  std::span<const float> weight() const { return weight_; }
  std::span<const float> attribute() const { return attribute_; }
  float blur_rad() const { return blur_rad_; }
  /// Mass of g: the sum of the weights.
  float energy() const { return energy_; }
  /// max(integral (g - mean)^2 dx, 1e-3 / 2 pi): what the objective is relative to. 1/rad.
  float variation() const { return variation_; }
  std::size_t bytes() const { return sizeof(*this) + 3 * sizeof(float) * azimuth_.capacity(); }

  /// g(x), 1/rad. x in radians, any turn. Never negative, never NaN.
  float density(float x) const;

 private:
  std::vector<float> azimuth_, weight_, attribute_;
  float blur_rad_ = 0, energy_ = 0, variation_ = 0;
};

/// Wrapped Gaussian of standard deviation sigma at x (radians, any turn), 1/rad.
float wrapped_gaussian(float x, float sigma);

}  // namespace tress::adaptive
