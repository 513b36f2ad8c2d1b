#include "scene/model/groom_taper.h"

#include <algorithm>
#include <glm/geometric.hpp>

namespace tress::scene {
namespace {

constexpr float thinnest_cm = 1e-4f;

}  // namespace

void apply_taper(const Taper& taper, Groom* groom) {
  if (taper.root == 1 && taper.tip == 1) return;
  for (std::uint32_t s = 0; s < groom->strand_count(); ++s) {
    const std::size_t begin = groom->first_point[s], end = groom->first_point[s + 1];
    double whole = 0, along = 0;
    for (std::size_t i = begin + 1; i < end; ++i) whole += glm::distance(groom->points[i - 1], groom->points[i]);
    for (std::size_t i = begin; i < end; ++i) {
      if (i > begin) along += glm::distance(groom->points[i - 1], groom->points[i]);
      const double factor = whole > 0 ? taper.root + (taper.tip - taper.root) * along / whole : taper.root;
      float& radius = groom->radius_cm[i];
      radius = std::max(static_cast<float>(factor * radius), std::min(thinnest_cm, radius));
    }
  }
}

}  // namespace tress::scene
