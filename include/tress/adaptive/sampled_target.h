// What the service learns where nobody can evaluate it: densities over a cylinder that the host can only draw from.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tress/adaptive/target.h"

namespace tress::adaptive {

/// One exit of a drawn path: `weight` of what enters at the node leaves at (azimuth, height) as of `part`.
struct SampledExit {
  float azimuth;       ///< radians, any turn
  float height;        ///< place along the axis of the cylinder, any finite number (hair: asinh tan theta_i, shifted)
  std::uint32_t part;  ///< which of the densities of the node, < SampledTarget::parts()
  float weight;        ///< of unit flux, >= 0, finite
  float attribute;     ///< as TracedRay::attribute, >= 0
};

/// A target known by samples only. Each node has parts() densities over (azimuth, height), each of a mass of its own:
/// the mean over paths of the sum of the weights of its exits. What it draws is checked: a node whose draws have a
/// weight that is negative or not finite, a place that is not finite, a part that is not there, or no mass at all,
/// becomes a refused row.
class SampledTarget {
 public:
  static constexpr std::uint32_t most_parts = 4;

  virtual ~SampledTarget() = default;

  /// 1 to most_parts, the same for all nodes of a slice.
  virtual std::uint32_t parts(const SliceDescription& slice) const = 0;

  /// Appends the exits of paths [first, first + count) of a stream: a path may leave at several places, with a part of
  /// its weight each. Streams are independent of one another; the paths of one stream may be stratified against each
  /// other in any way that keeps every prefix of 2^k paths unbiased. Pure: the same arguments give the same exits for
  /// ever. Any thread.
  virtual void draw(const SliceDescription& slice, float a, float b, std::uint64_t stream, std::uint32_t first,
                    std::uint32_t count, std::vector<SampledExit>& out) const = 0;

  /// draw() of the four streams from `stream` on, for a target that draws them cheaper at once: appends the exits of
  /// stream + s to out[s].
  virtual void draw_sets(const SliceDescription& slice, float a, float b, std::uint64_t stream, std::uint32_t first,
                         std::uint32_t count, std::array<std::vector<SampledExit>, 4>& out) const {
    for (std::size_t s = 0; s < out.size(); ++s) draw(slice, a, b, stream + s, first, count, out[s]);
  }

  /// The same as Target::model_name().
  virtual std::string model_name() const = 0;
};

}  // namespace tress::adaptive
