// Which fiber each strand is of, and the rounding that keeps fibers few and their mean.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>

#include "scene/model/scene.h"
#include "tress/base/error.h"

namespace tress::scene {

/// More distinct fibers than this are refused.
constexpr std::size_t most_fibers = 1024;

/// Fills scene->fibers with the distinct fibers that the materials give to the strands of the grooms, and every
/// groom's `fiber`; says in scene->notes how many they are where they vary. Materials must be in range.
///
/// A strand's variation is a hash of the seed of the variation, the name of the material and the index of the strand:
/// it depends neither on the order of grooms nor on where the strand is. What varies is rounded once, to either
/// neighbour at random so that the mean is kept (design section 5): the eccentricity to .01; the roughness and the
/// azimuthal sigmas to 1 degree, with sigmas that follow the roughness following the rounded one, and all widths of a
/// node's fiber (Material::has_node_widths) by one factor of whole steps of .05; the absorption to powers of
/// color_ratio. The rounded values are the strand's fiber. What does not vary is as the material says. Errors name
/// /materials/N: a variation that leaves the range of what it varies, too many distinct fibers.
std::optional<Error> assign_fibers(Scene* scene);

/// Absorptions that vary are powers of this, or 0: 9 % standard deviation at most, none in the mean.
constexpr double color_ratio = 1.2;

// Rounding that keeps the mean: E over u, uniform in [0, 1), of the rounded value is the value.

/// floor(x + u), u uniform in [0, 1): the whole number below or above, of mean x. Within [low, high] where x is, for
/// whole low and high.
inline std::int64_t round_stochastically(double x, double u) { return static_cast<std::int64_t>(std::floor(x + u)); }

/// k with ratio^k the power below or above x > 0, ratio > 1, of mean ratio^k = x. The standard deviation is at most
/// (ratio - 1)/(2 sqrt(ratio)) of x.
inline std::int64_t round_to_power(double x, double ratio, double u) {
  const double k = std::floor(std::log(x) / std::log(ratio));
  const double below = std::pow(ratio, k);
  return static_cast<std::int64_t>(k) + (u * (below * ratio - below) < x - below ? 1 : 0);
}

}  // namespace tress::scene
