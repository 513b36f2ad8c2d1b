// The target of the service where it cannot be evaluated: densities over a cylinder from which the host can only draw.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tress/adaptive/target.h"

namespace tress::inline v0_2::adaptive {

/// One exit of a drawn path: `weight` of the light that enters at the node leaves at (azimuth, height) as `part`.
struct SampledExit {
  float azimuth;       ///< radians, any turn
  float height;        ///< place along the axis of the cylinder, any finite number (hair: asinh tan theta_i, shifted)
  std::uint32_t part;  ///< index of one of the node's densities, < SampledTarget::parts()
  float weight;        ///< share of unit flux, 0 to largest_weight
  float attribute;     ///< the same as TracedRay::attribute, >= 0
};

/// A target known by samples only. Each node has parts() densities over (azimuth, height), each with its own mass: the
/// mean over paths of the sum of the weights of its exits. Draws are checked. A node becomes a refused row if its draws
/// have a weight that is negative, not a number or above largest_weight, a place that is not finite, a part that does
/// not exist, or no mass at all.
class SampledTarget {
 public:
  static constexpr std::uint32_t most_parts = 4;

  virtual ~SampledTarget() = default;

  /// The number of parts, 1 to most_parts, the same for all nodes of a slice.
  virtual std::uint32_t parts(const SliceDescription& slice) const = 0;

  /// Appends the exits of paths [first, first + count) of a stream. A path may leave at several places, with a part of
  /// its weight at each. Streams are independent of one another; the paths of one stream may be stratified against each
  /// other in any way that keeps every prefix of 2^k paths unbiased. Pure: the same arguments always give the same
  /// exits. Any thread.
  virtual void draw(const SliceDescription& slice, float a, float b, std::uint64_t stream, std::uint32_t first,
                    std::uint32_t count, std::vector<SampledExit>& out) const = 0;

  /// Does draw() for the four streams that begin at `stream`, for a target that draws them together at less cost:
  /// appends the exits of stream + s to out[s].
  virtual void draw_sets(const SliceDescription& slice, float a, float b, std::uint64_t stream, std::uint32_t first,
                         std::uint32_t count, std::array<std::vector<SampledExit>, 4>& out) const {
    for (std::size_t s = 0; s < out.size(); ++s) draw(slice, a, b, stream + s, first, count, out[s]);
  }

  /// Does the same as Target::model_name().
  virtual std::string model_name() const = 0;
};

}  // namespace tress::inline v0_2::adaptive
