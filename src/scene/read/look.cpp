#include "scene/read/look.h"

#include <fmt/format.h>

#include <numbers>

#include "scene/model/hair_colors.h"
#include "scene/model/parameters.h"
#include "scene/model/strand_fibers.h"
#include "tress/fiber/lock_color.h"

namespace tress::scene {
namespace {

void style(const Overrides& overrides, Material* material) {
  fiber::FiberParameters& fiber = material->fiber;
  const bool pigment = overrides.melanin || overrides.sigma_a || overrides.hair;
  if (overrides.color || pigment) material->color_from_file = false;
  if (overrides.eccentricity) fiber.eccentricity = *overrides.eccentricity;
  if (overrides.roughness) fiber.roughness = *overrides.roughness;
  if (overrides.tilt_deg) fiber.tilt = static_cast<float>(*overrides.tilt_deg * std::numbers::pi / 180);
  if (pigment) material->color.reset();
  if (overrides.color) material->color = overrides.color;
  if (material->color) fiber.sigma_a = fiber::sigma_a_of_lock(*material->color, fiber);
  if (overrides.melanin)
    fiber.sigma_a = fiber::sigma_a_from_melanin(overrides.melanin->first, overrides.melanin->second);
  if (overrides.sigma_a) fiber.sigma_a = *overrides.sigma_a;
  if (overrides.hair) fiber.sigma_a = sigma_a_of_hair(*overrides.hair).value_or(fiber.sigma_a);
}

}  // namespace

std::optional<Error> fault_of(const Overrides& o) {
  std::optional<Error> error;
  const auto check = [&](const char* option, const auto& value) {
    const Parameter& parameter = option_parameter(option);
    const auto one = [&](const auto x) {
      Range range = parameter.range;  // its ends as the type of the value has them
      range.least = static_cast<double>(static_cast<decltype(x)>(range.least));
      range.most = static_cast<double>(static_cast<decltype(x)>(range.most));
      if (!error && !range.contains(x))
        error = Error{"", option, words(parameter), fmt::format("{:g}", static_cast<double>(x))};
    };
    if constexpr (requires { value->length(); }) {
      for (int c = 0; value && c < 3; ++c) one((*value)[c]);
    } else if constexpr (requires { value->second; }) {
      if (value) one(value->first), one(value->second);
    } else if (value) {
      one(*value);
    }
  };
  check("--rotate", o.environment_rotate_deg);
  check("--color", o.color);
  check("--melanin", o.melanin);
  check("--sigma-a", o.sigma_a);
  check("--eccentricity", o.eccentricity);
  check("--roughness", o.roughness);
  check("--cuticle-tilt", o.tilt_deg);
  check("--light-scale", o.light_scale);
  check("--cm-per-unit", o.cm_per_unit);
  check("--resolution", o.width);
  check("--resolution", o.height);
  check("--spp", o.samples);
  check("--frame", o.frame);
  check("--turn", o.turn_deg);
  check("--shutter", o.shutter);
  check("--motion-samples", o.motion_samples);
  check("--fps", o.frames_per_second);
  check("--exposure", o.exposure_stops);
  return error;
}

std::optional<Error> apply_look(const Overrides& overrides, Scene* scene) {
  for (Material& material : scene->materials) style(overrides, &material);
  if (overrides.light_scale && *overrides.light_scale != 1) {
    const auto factor = static_cast<float>(*overrides.light_scale);
    for (Light& light : scene->lights) light.radiance *= factor;
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
