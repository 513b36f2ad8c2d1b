// Assigns a fiber to each strand, with a rounding that keeps fibers few and their mean unchanged.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>

#include "scene/model/scene.h"
#include "tress/base/error.h"

namespace tress::scene {

/// A scene with more distinct fibers is refused.
constexpr std::size_t most_fibers = 1024;

/// Fills scene->fibers with the distinct fibers that the materials give to hits on the grooms, and every groom's
/// choices and `presence`. If the fibers vary, their number is added to scene->notes. Materials must be in range.
///
/// A strand's variation is a hash of the seed of the variation, the name of the material and the index of the strand;
/// it depends neither on the order of grooms nor on the strand's place. A value that varies is rounded at every hit, to
/// either neighbour at random, so that its mean is kept: rounded once for a strand, it would be seen. Only the
/// eccentricity, which is the strand's shape too, is rounded once, to 0.01. The tilt is rounded to 0.5 degrees and the
/// roughness to 1 degree; given widths follow the rounded one. The medulla's radius and all asymmetries are rounded to
/// 0.05, the wetness to 0.25, coefficients, gains and the absorption to powers of color_ratio. All widths of a node's
/// fiber (Material::has_node_widths) get one factor in whole steps of 0.05. Values that do not vary are the material's.
/// Errors name /materials/N: a variation that leaves the range of its value, an eccentricity that varies along strands,
/// or too many distinct fibers.
std::optional<Error> assign_fibers(Scene* scene);

/// Multiplies the radii of a groom's points, at all moments, by its material's thickness.
void apply_thickness(const Material& material, Groom* groom);

/// Returns the share of a strand's length, in [0, 1], before a place given in segments from its root.
/// Lengths are those of the polygon of its points, as ramps of sources have them. The strand has a segment.
float length_share(const Groom& groom, std::uint32_t strand, float place);

/// Absorptions that vary are powers of this, or 0. The standard deviation over hits is at most 9 %, and the mean is
/// unchanged.
constexpr double color_ratio = 1.2;

// Rounding that keeps the mean: the expectation over u, uniform in [0, 1), of the rounded value is the value.

/// floor(x + u), u uniform in [0, 1): the whole number below or above, with mean x. It is within [low, high] if x is,
/// for whole low and high.
inline std::int64_t round_stochastically(double x, double u) { return static_cast<std::int64_t>(std::floor(x + u)); }

/// Returns k such that ratio^k is the power below or above x > 0, ratio > 1, and the mean of ratio^k is x. The standard
/// deviation is at most (ratio - 1)/(2 sqrt(ratio)) of x.
inline std::int64_t round_to_power(double x, double ratio, double u) {
  const double k = std::floor(std::log(x) / std::log(ratio));
  const double below = std::pow(ratio, k);
  return static_cast<std::int64_t>(k) + (u * (below * ratio - below) < x - below ? 1 : 0);
}

}  // namespace tress::scene
