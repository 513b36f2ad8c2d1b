// The generators behind generate_groom(), one file each.
#pragma once

#include "scene/scene.h"

namespace tress::scene {

Groom curly_lock(std::uint32_t strands, std::uint64_t seed, float length_cm, float radius_cm);
Groom straight_groom(std::uint32_t strands, std::uint64_t seed, float length_cm, float radius_cm);

}  // namespace tress::scene
