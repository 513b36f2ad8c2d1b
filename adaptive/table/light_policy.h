// The epsilon of a row by the light that it carries, and the error that rows cause in a picture (ESTIMATOR.md, E8).
#pragma once

#include <algorithm>
#include <cstdint>

#include "table/slice.h"
#include "tress/adaptive/options.h"
#include "tress/adaptive/target.h"

namespace tress::inline v0_2::adaptive {

/// Light in fixed point with steps of 2^-20, so that sums do not depend on their order. One query adds at most 2^12.
inline std::uint64_t fixed_light(float light) {
  return static_cast<std::uint64_t>(std::min(light, 4096.0f) * 1048576.0f);
}

/// `light` of a node is its sum of fixed_light() over all paths so far. Any thread, while no pass ends.
class LightPolicy {
 public:
  explicit LightPolicy(const Options& options)
      : epsilon_(options.epsilon), sampled_epsilon_(options.sampled_epsilon), picture_error_(options.picture_error) {}

  /// Whether each row has its own epsilon.
  bool is_driven() const { return picture_error_ > 0; }

  std::uint64_t paths = 0;    ///< of the picture so far
  std::uint64_t queried = 0;  ///< nodes ever queried, as of the last publish()

  /// Light per path that a node has carried, >= 0. The sum over all nodes is about the number of hits of a path.
  /// unseen: light to add to what was seen.
  double share(std::uint64_t light, double unseen = 0) const {
    return (static_cast<double>(light) / static_cast<double>(fixed_light(1)) + unseen) /
           static_cast<double>(std::max<std::uint64_t>(paths, 1));
  }
  /// The epsilon that a row must reach. energy: the mass of g, for rows of densities.
  double epsilon_of(const SliceDescription& slice, std::uint64_t light, float energy) const;
  double epsilon_of(const Slice& slice, std::uint32_t node, float energy) const {
    return epsilon_of(slice.description, slice.light_at(node), energy);
  }
  /// The relative error that a row of this objective may cause in the mean radiance. PassReport::bias_bound is their
  /// sum.
  double bias_of(const SliceDescription& slice, std::uint64_t light, float energy, double objective) const;

 private:
  double epsilon_, sampled_epsilon_, picture_error_;
};

}  // namespace tress::inline v0_2::adaptive
