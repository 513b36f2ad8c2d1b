#include "models/default_model.h"

#include <algorithm>
#include <optional>

namespace tress::inline v0_2::fiber {

bool shapes_lobes(const FiberParameters& fiber) {
  const auto is_set = [](const std::optional<float>& width) { return width.has_value(); };
  return std::ranges::any_of(fiber.azimuthal_sigma, is_set) || std::ranges::any_of(fiber.longitudinal_lambda, is_set) ||
         fiber.longitudinal_shape != LongitudinalShape::logistic ||
         fiber.reflection_fresnel != ReflectionFresnel::exact;
}

bool have_published_lobes(std::span<const FiberParameters> fibers) {
  return !fibers.empty() && std::ranges::all_of(fibers, [](const FiberParameters& fiber) {
    return fiber.published_widths && !fiber.split_glint && fiber.reflection_fresnel == ReflectionFresnel::exact;
  });
}

ChosenModel default_model(std::span<const FiberParameters> materials, std::span<const FiberParameters> fibers) {
  if (have_published_lobes(fibers)) return {&chiang2016_info, "its hair is given by the lobes of that"};
  if (std::ranges::any_of(materials, shapes_lobes)) return {&elliptical_info, "a material shapes its lobes"};
  return {&rough_info, ""};
}

std::vector<const ModelInfo*> default_models() { return {&rough_info, &elliptical_info, &chiang2016_info}; }

}  // namespace tress::inline v0_2::fiber
