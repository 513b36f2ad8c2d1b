// The target of the service: a circular density that the host can trace exactly at the nodes of a grid.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::adaptive {

/// Names a slice: its lobe, and the parameters on which the target at its nodes depends. The host defines their
/// meaning; the service compares, orders (by value) and stores them. Finite values only; -0 is 0.
struct SliceKey {
  /// The number of parameters of a slice of densities.
  static constexpr std::size_t density_parameters = 3;
  /// The number of parameters of most slices of samples; a cache holds the others only if one of them is not 0.
  static constexpr std::size_t usual_parameters = 8;
  std::uint32_t lobe = 0;
  /// Slices of densities use the first density_parameters; their others are 0.
  std::array<float, 16> parameters{};

  /// The parameters without trailing zeros, but at least so many of them.
  std::span<const float> used_parameters(std::size_t least = density_parameters) const {
    std::size_t count = parameters.size();
    while (count > least && parameters[count - 1] == 0) --count;
    return {parameters.data(), count};
  }
  /// The former name of used_parameters(); it works until version 0.3.
  std::span<const float> told_parameters(std::size_t least = density_parameters) const {
    return used_parameters(least);
  }

  friend bool operator==(const SliceKey&, const SliceKey&) = default;
  friend auto operator<=>(const SliceKey& a, const SliceKey& b) = default;
};

/// The kind of target from which the rows of a slice are learned.
enum class SliceKind : std::uint8_t {
  density = 0,  ///< Target::trace(): circular densities that can be evaluated
  samples = 1,  ///< SampledTarget::draw(): densities over a cylinder that can only be drawn from
};

/// A coarse grid of a slice: the nodes (a[i], b[j]), as ascending indices into the axes, which include the first and
/// the last of either axis.
struct CoarseAxes {
  std::vector<std::uint32_t> a, b;

  friend bool operator==(const CoarseAxes&, const CoarseAxes&) = default;
};

/// A slice is a grid of rows, one row per node (a, b).
struct SliceDescription {
  SliceKey key;
  std::vector<float> axis_a;  ///< node coordinates, ascending, at least one
  std::vector<float> axis_b;
  float blur_rad = 0.2f;  ///< standard deviation of the wrapped Gaussian kernel, radians, > 0
  /// D: the largest number of components of a fit in this slice; Options::max_components is a limit too. Not saved.
  std::uint32_t max_components = Mixture::max_components;
  SliceKind kind = SliceKind::density;  ///< blur and components apply to densities only
  /// In a slice of samples: coarser grids, of which the first is used. Rows at its nodes answer for nodes that have no
  /// row yet; without one, these nodes are not answered. Not saved.
  std::vector<CoarseAxes> coarse = {};
  /// In a slice of samples: the key of a slice with the same axes, coarse grids and parts that was added before, if its
  /// target differs by less than the error of coarse rows. This slice then has no coarse rows: the other's answer for
  /// it, and both slices' events refine them. Not saved.
  std::optional<SliceKey> coarse_rows_of = {};

  std::uint32_t node_count() const { return static_cast<std::uint32_t>(axis_a.size() * axis_b.size()); }
};

/// Whether a target may have the name, so that a cache can be saved: 1 to 256 printable ASCII characters.
bool is_model_name(std::string_view name);

/// The largest weight of a ray or exit, so that sums of them are finite.
constexpr float largest_weight = 1e30f;

/// One ray of a traced node: `weight` of the target's mass leaves at `azimuth`.
struct TracedRay {
  float azimuth;    ///< radians, any turn
  float weight;     ///< mass, 0 to largest_weight
  float attribute;  ///< a value to be averaged for each component, >= 0 (hair: internal path length)
};

/// The target g of the row at node (a, b) of a slice is
///  g(x) = sum_j weight_j G(x - azimuth_j),  G the wrapped Gaussian of the slice's blur,
/// over the rays that trace() gives. x in radians, g in 1/rad; the mass of g is the sum of the weights.
class Target {
 public:
  virtual ~Target() = default;

  /// Appends the rays of a node. Pure: the same node always gives the same rays. Any thread.
  virtual void trace(const SliceDescription& slice, float a, float b, std::vector<TracedRay>& out) const = 0;

  /// The name of what trace() computes and of the axes, e.g. "elliptical-1". Caches of other models are refused. See
  /// is_model_name().
  virtual std::string model_name() const = 0;
};

}  // namespace tress::inline v0_2::adaptive
