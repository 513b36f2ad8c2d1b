#include "scene/strand_fibers.h"

namespace tress::scene {

void assign_fibers(Scene* scene) {
  scene->fibers.clear();
  for (const Material& material : scene->materials) scene->fibers.push_back(material.fiber);
  for (Groom& groom : scene->grooms) groom.fiber.assign(groom.strand_count(), groom.material);
}

}  // namespace tress::scene
