#include "scene/read/look.h"

#include <numbers>

#include "scene/model/absorption.h"
#include "scene/model/strand_fibers.h"
#include "scene/read/source_reader.h"

namespace tress::scene {
namespace {

void style(const Overrides& overrides, Material* material) {
  fiber::FiberParameters& fiber = material->fiber;
  const AbsorptionOf absorption(material->spectral);
  const bool pigment = overrides.melanin || overrides.sigma_a || overrides.hair;
  if (overrides.color || overrides.color_source || pigment) material->pigment.reset();
  const auto fix = [&](FiberNumber number) { material->numbers[static_cast<std::size_t>(number)].reset(); };
  if (overrides.eccentricity) {
    fiber.eccentricity = *overrides.eccentricity;
    fix(FiberNumber::eccentricity);
  }
  if (overrides.roughness) {
    fiber.roughness = *overrides.roughness;
    material->roughness.reset();
  }
  if (overrides.tilt_deg) {
    fiber.tilt = static_cast<float>(*overrides.tilt_deg * std::numbers::pi / 180);
    fix(FiberNumber::tilt);
  }
  if (pigment) material->color.reset();
  if (overrides.color) material->color = overrides.color;
  if (overrides.color_source)
    material->color = take_pigment(*parse_color(*overrides.color_source), absorption.of_lock(), material);
  if (material->color) fiber.sigma_a = absorption.of_lock()(*material->color, fiber);
  if (overrides.melanin) fiber.sigma_a = absorption.melanin(overrides.melanin->first, overrides.melanin->second);
  if (overrides.sigma_a) fiber.sigma_a = absorption.given(*overrides.sigma_a);
  if (overrides.hair) fiber.sigma_a = absorption.hair(*overrides.hair).value_or(fiber.sigma_a);
}

}  // namespace

std::optional<Error> apply_look(const Overrides& overrides, Scene* scene) {
  for (Material& material : scene->materials) style(overrides, &material);
  if (overrides.light_scale && *overrides.light_scale != 1) {
    const auto factor = static_cast<float>(*overrides.light_scale);
    for (Light& light : scene->lights) {
      light.radiance *= factor;
      for (LightShape& moment : light.later) moment.radiance *= factor;
    }
    scene->environment = scene->environment.scaled(factor);
  }
  return assign_fibers(scene);
}

std::optional<Error> restyle(const Unstyled& unstyled, const Overrides& overrides, Scene* scene) {
  if (auto error = fault_of(overrides)) return error;
  scene->materials = unstyled.materials;
  scene->lights = unstyled.lights;
  scene->environment = unstyled.environment;
  return apply_look(overrides, scene);
}

}  // namespace tress::scene
