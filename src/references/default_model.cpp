#include "references/default_model.h"

#include <algorithm>
#include <optional>
#include <system_error>

#include "references/registry.h"
#include "tress/adaptive/cache.h"

namespace tress::references {

bool shapes_lobes(const fiber::FiberParameters& fiber) {
  const auto is_set = [](const std::optional<float>& width) { return width.has_value(); };
  return std::ranges::any_of(fiber.azimuthal_sigma, is_set) || std::ranges::any_of(fiber.longitudinal_lambda, is_set) ||
         fiber.longitudinal_shape != fiber::LongitudinalShape::logistic ||
         fiber.reflection_fresnel != fiber::ReflectionFresnel::exact;
}

bool have_published_lobes(std::span<const fiber::FiberParameters> fibers) {
  return !fibers.empty() && std::ranges::all_of(fibers, [](const fiber::FiberParameters& fiber) {
    return fiber.published_widths && !fiber.split_glint && fiber.reflection_fresnel == fiber::ReflectionFresnel::exact;
  });
}

const fiber::ModelInfo* model_of_rows(adaptive::RowSource& rows) {
  bool has_slices = false, has_samples = false;
  rows.rewind();
  while (!has_samples) {
    const adaptive::SliceDescription* slice = rows.next_slice();
    if (slice == nullptr) break;
    has_slices = true;
    has_samples = slice->kind == adaptive::SliceKind::samples;
  }
  const fiber::ModelInfo* found = nullptr;
  for (const fiber::ModelInfo& info : models()) {
    if (!has_slices || !info.has_rows() || info.make_target()->model_name() != rows.model()) continue;
    if (found == nullptr || (has_samples && info.learns_samples())) found = &info;
  }
  return found;
}

ChosenModel choose_model(const ModelHints& hints) {
  const std::string elliptical = fiber::elliptical_info.name;
  if (!hints.option.empty()) return {elliptical, hints.option + " is of its rows"};
  if (hints.has_published_lobes && !hints.needs_rows) return {"chiang2016", "its hair is given by the lobes of that"};
  if (hints.shapes_lobes) return {elliptical, "a material shapes its lobes"};
  std::error_code error;
  if (!hints.warm_cache.empty() && std::filesystem::is_regular_file(hints.warm_cache, error)) {
    const auto cache = adaptive::CacheFile::open(hints.warm_cache, "");
    const fiber::ModelInfo* info = cache ? model_of_rows(**cache) : nullptr;
    if (info != nullptr && info->name != default_model)
      return {info->name, hints.warm_cache.string() + " has its rows"};
  }
  return {std::string(default_model), ""};
}

}  // namespace tress::references
