#include "scene/generate/groom_kinds.h"

namespace tress::scene {

Groom single_fiber(const GroomShape& shape) {
  constexpr float apart_cm = 0.1f;
  const float length_cm = shape["length_cm"];
  Groom groom;
  groom.first_point.push_back(0);
  for (std::uint32_t s = 0; s < shape.strands; ++s) {
    const float x = apart_cm * (static_cast<float>(s) - 0.5f * static_cast<float>(shape.strands - 1));
    for (std::uint32_t i = 0; i < shape.points; ++i) {
      groom.points.emplace_back(x, 0.0f, -length_cm * static_cast<float>(i) / static_cast<float>(shape.points - 1));
      groom.radius_cm.push_back(shape.radius_cm);
    }
    groom.first_point.push_back(static_cast<std::uint32_t>(groom.points.size()));
  }
  return groom;
}

}  // namespace tress::scene
