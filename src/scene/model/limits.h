// Ranges that several keys of the scene file share.
#pragma once

namespace tress::scene {

constexpr double world_cm = 1e6;          ///< no coordinate is further from the origin
constexpr double most_radiance = 1e9;     ///< of a light; its sums and products stay finite in 32 bits
constexpr double most_environment = 1e6;  ///< radiance of a constant environment or a sky

}  // namespace tress::scene
