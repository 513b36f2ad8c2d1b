#include "scene/read/marschner_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/pi.h"
#include "scene/read/principled_reader.h"
#include "scene/read/source_reader.h"
#include "tress/fiber/parameter_ranges.h"
#include "tress/fiber/principled_hair.h"

namespace tress::scene {
namespace {

constexpr double logistic_deviation = std::numbers::pi / std::numbers::sqrt3;  ///< of a logistic of scale 1
/// lambda of a lobe over its standard deviation, R, TT, TRT, TRRT; |cos(d/2)| narrows R by pi/4 in the mean.
constexpr std::array<double, 4> lambda_per_deviation{4 / std::numbers::pi / logistic_deviation, 1 / logistic_deviation,
                                                     1 / logistic_deviation, 1 / logistic_deviation};

float radians_within(const fiber::ParameterRange& degrees, double x) {
  return static_cast<float>(std::clamp(x, degrees.least, degrees.most) * degree);
}

/// A key without counterpart in a fiber, and whether it is set to something that would show.
struct Lost {
  const char* key;
  bool shows;
};

void report_lost(const std::string& node, const std::vector<Lost>& keys, Material* material) {
  for (const auto& [key, shows] : keys)
    if (shows) material->left_out.push_back(node + key);
}

bool is_set(const JsonReader& json, const char* key) {
  return json.triple(key).value_or(glm::vec3(0.0f)) != glm::vec3(0.0f);
}

Source constant(float x) { return {.value = glm::vec3(x)}; }

Source sum(Source a, Source b) {
  return simplified({.kind = Source::Kind::sum, .parts = {std::move(a), std::move(b)}});
}

Source random(Source a, Source b, std::uint64_t seed, std::optional<float> chance = {}) {
  if (chance == 0.0f) return a;
  return simplified(
      {.kind = Source::Kind::random, .parts = {std::move(a), std::move(b)}, .chance = chance, .seed = seed});
}

/// Reads PxrHairColor.
void read_hair_color(const JsonReader& json, Material* material) {
  if (!json.object()) return;
  const auto number = [&](const char* key, double usual) {
    return static_cast<float>(json.number(key).value_or(usual));
  };
  const bool is_artistic = json.integer("mode").value_or(0) == 1;
  const float stray = number("strayDensity", 0.1), dark = number("darkenRoots", 0),
              end = number("darkenEndPosition", 0.5);
  const float varied = number("randomMelanin", 0.05), stray_varied = number("strayRandomMelanin", 0);
  const Source stray_melanin = constant(number("strayMelanin", 0.05));
  const Source stray_color{.value = json.triple("strayColor").value_or(glm::vec3(0.05f))};
  std::optional<Source> dye;
  if (json.has("dye")) dye = read_source(json, "dye", read_triple());
  const float dye_hue = number("randomDyeHue", 0), dye_saturation = number("randomDyeSaturation", 0);
  if (dye && (dye_hue > 0 || dye_saturation > 0))
    dye = {.kind = Source::Kind::hsv,
           .parts = {std::move(*dye), random(constant(-dye_hue / 2), constant(dye_hue / 2), 3),
                     random(constant(1 - dye_saturation), constant(1 + dye_saturation), 4), constant(1)}};
  const Source melanin =
      json.has("melanin") ? read_source(json, "melanin", read_number(glm::vec3(1.0f))) : constant(0.2f);
  const Source color =
      json.has("color") ? read_source(json, "color", read_triple()) : Source{.value = glm::vec3(0, 0.3f, 0.1f)};
  report_lost("hair_color/",
              {{"darkenSlope", number("darkenSlope", 1) != 1 && dark > 0},
               {"darkenRoots", is_artistic && dark > 0},
               {"randomColor", is_set(json, "randomColor") && is_artistic},
               {"strayRandomColor", is_set(json, "strayRandomColor") && is_artistic}},
              material);

  const AbsorptionOf absorption(material->spectral);
  const auto take = [&](Source source, const Absorption& sigma_a) {
    const Absorption of_dye = absorption.of_color([](const glm::vec3& color, const fiber::FiberParameters&) {
      return fiber::sigma_a_of_principled_color(color, 0.3f);
    });
    if (const auto x = take_dyed({std::move(source), sigma_a, dye, of_dye}, material->fiber, material))
      material->fiber.sigma_a = *x;
  };
  if (is_artistic) return take(random(color, stray_color, 1, stray), absorption.of_lock());
  const auto spread = [](Source source, float half, std::uint64_t seed) {
    return sum(std::move(source), random(constant(-half), constant(half), seed));
  };
  Source all = random(spread(melanin, varied, 0), spread(stray_melanin, stray_varied, 2), 1, stray);
  if (dark > 0 && end > 0)
    all = sum(std::move(all), {.kind = Source::Kind::ramp, .parts = {constant(dark), constant(0)}, .places = {0, end}});
  take(std::move(all), [absorption](const glm::vec3& x, const fiber::FiberParameters&) {
    return absorption.principled_melanin(std::clamp(x.x, 0.0f, 1.0f), 0);
  });
}

}  // namespace

void read_marschner(const JsonReader& material_json, Material* material) {
  if (!is_alone(material_json, "marschner")) return;
  const auto json = material_json.child("marschner");
  if (!json.object()) return;
  const auto number = [&](const char* key, double usual) { return json.number(key).value_or(usual); };
  const auto color = [&](const char* key, float usual) { return json.triple(key).value_or(glm::vec3(usual)); };
  fiber::FiberParameters& fiber = material->fiber;
  fiber.eta = static_cast<float>(number("specularIor", 1.55));
  fiber.eccentricity = static_cast<float>(number("specularEccentricity", 1));
  const double offset = number("specularOffset", -3);
  fiber.tilt = radians_within(fiber::tilt_range_deg, -offset);
  const std::array<double, 3> cones{number("specularConeAngleR", 8), number("specularConeAngleTT", 8),
                                    number("specularConeAngleTRT", 8)};
  fiber.roughness = static_cast<float>(
      std::clamp(std::numbers::sqrt2 * cones[0] * degree, fiber::roughness_range.least, fiber::roughness_range.most));
  for (std::size_t p = 0; p < fiber.longitudinal_lambda.size(); ++p)
    fiber.longitudinal_lambda[p] = radians_within(fiber::longitudinal_lambda_range_deg,
                                                  lambda_per_deviation[p] * cones[std::min<std::size_t>(p, 2)]);
  fiber.azimuthal_sigma[1] = radians_within(fiber::azimuthal_sigma_range_deg, number("specularGlintWidth", 10));

  using enum fiber::Lobe;
  const auto set_gain = [&](fiber::Lobe lobe, double gain, const glm::vec3& tint) {
    fiber.gain[static_cast<std::size_t>(lobe)] = static_cast<float>(gain) * tint;
  };
  const bool has_hair_color = json.has("hair_color");
  const auto color_of = [&](const char* key) { return has_hair_color ? glm::vec3(1.0f) : color(key, 0.4f); };
  const double gain_trt = number("specularGainTRT", 1), gain_glint = number("specularGainGLINTS", 1);
  const glm::vec3 color_trt = color_of("specularColorTRT");
  set_gain(r, number("specularGainR", 1), color("specularColorR", 1));
  set_gain(tt, number("specularGainTT", 1), color_of("specularColorTT"));
  set_gain(trt, gain_trt, color_trt);
  set_gain(glint, gain_glint, color_trt);
  set_gain(trrt, 0, glm::vec3(0.0f));
  set_gain(residual, 0, glm::vec3(0.0f));
  fiber.split_glint = gain_glint != gain_trt;
  fiber.sigma_a = glm::vec3(0.0f);
  if (json.has("presence")) material->presence = constant(static_cast<float>(number("presence", 1)));

  // These are only checked, because their gains are reported.
  json.integer("diffuseModelType");
  json.triple("diffuseColor");
  json.triple("glowColor");
  report_lost("",
              {{"specularMixFresnel", number("specularMixFresnel", 1) != 1},
               {"specularOffset", offset > 0 || offset < -fiber::tilt_range_deg.most},
               {"eccentricityDirection", is_set(json, "eccentricityDirection")},
               {"specularEnergyCompensation", number("specularEnergyCompensation", 0) > 0},
               {"diffuseGain", number("diffuseGain", 0) > 0},
               {"glowGain", number("glowGain", 0) > 0},
               {"shadowColor", is_set(json, "shadowColor")},
               {"specularColorTT", has_hair_color && is_set(json, "specularColorTT")},
               {"specularColorTRT", has_hair_color && is_set(json, "specularColorTRT")}},
              material);
  if (has_hair_color) read_hair_color(json.child("hair_color"), material);
}

}  // namespace tress::scene
