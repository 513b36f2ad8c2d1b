// Which fiber each strand is of.
#pragma once

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
/// azimuthal sigmas to 1 degree, with sigmas that follow the roughness following the rounded one; the absorption to
/// powers of color_ratio. The rounded values are the strand's fiber. What does not vary is as the material says.
/// Errors name /materials/N: a variation that leaves the range of what it varies, too many distinct fibers.
std::optional<Error> assign_fibers(Scene* scene);

/// Absorptions that vary are powers of this, or 0: 9 % standard deviation at most, none in the mean.
constexpr double color_ratio = 1.2;

}  // namespace tress::scene
