#include "scene/read/lobe_reader.h"

#include <cstddef>
#include <iterator>

namespace tress::scene {
namespace {

/// In the order of the enumerators.
const std::vector<std::string> shapes{"logistic", "gaussian", "cauchy"};
const std::vector<std::string> fresnels{"exact", "longitudinal", "bravais", "none"};

std::size_t place_of(const std::string& name, const std::vector<std::string>& names) {
  std::size_t place = 0;
  while (place + 1 < names.size() && names[place] != name) ++place;
  return place;
}

}  // namespace

const std::vector<std::string>& lobe_keys() {
  static const std::vector<std::string> keys{"longitudinal_shape", "fresnel", "gain", "tint", "glint"};
  return keys;
}

void read_lobes(const JsonReader& json, fiber::FiberParameters* fiber) {
  if (const auto shape = json.choice("longitudinal_shape", shapes))
    fiber->longitudinal_shape = static_cast<fiber::LongitudinalShape>(place_of(*shape, shapes));
  if (const auto fresnel = json.choice("fresnel", fresnels))
    fiber->reflection_fresnel = static_cast<fiber::ReflectionFresnel>(place_of(*fresnel, fresnels));
  const std::vector<std::string> lobes(std::begin(fiber::lobe_names), std::end(fiber::lobe_names));
  constexpr auto trt = static_cast<std::size_t>(fiber::Lobe::trt);
  constexpr auto glint = static_cast<std::size_t>(fiber::Lobe::glint);
  const std::string gain = "gain", tint = "tint";
  for (const std::string& key : {gain, tint}) {
    if (!json.has(key)) continue;
    const auto by_lobe = json.child(key);
    if (!by_lobe.object(lobes)) return;
    for (std::size_t p = 0; p < lobes.size(); ++p) {
      // GLINT was part of TRT: unless it is named, splitting it off changes no picture.
      const std::string& lobe = p == glint && !by_lobe.has(lobes[p]) ? lobes[trt] : lobes[p];
      if (key == tint) fiber->gain[p] *= by_lobe.triple(lobe).value_or(glm::vec3(1.0f));
      if (key == gain) fiber->gain[p] *= static_cast<float>(by_lobe.number(lobe).value_or(1));
    }
    if (by_lobe.has(lobes[glint])) fiber->split_glint = true;
  }
  if (json.has("glint")) {
    if (!json.boolean("glint").value_or(true)) json.fail("glint", "true", "false");
    fiber->split_glint = true;
  }
}

}  // namespace tress::scene
