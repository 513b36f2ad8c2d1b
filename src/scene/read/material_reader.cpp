#include "scene/read/material_reader.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "base/pi.h"
#include "scene/model/hair_colors.h"
#include "scene/read/marschner_reader.h"
#include "scene/read/principled_reader.h"
#include "scene/read/source_reader.h"
#include "tress/fiber/parameters.h"

namespace tress::scene {
namespace {

/// Reads angles in degrees by lobe name.
template <std::size_t n>
void read_lobe_angles(const JsonReader& json, const std::string& key, const std::vector<std::string>& lobes,
                      std::array<std::optional<float>, n>* angles) {
  if (!json.has(key)) return;
  const auto by_lobe = json.child(key);
  if (!by_lobe.object(lobes)) return;
  for (std::size_t i = 0; i < n; ++i)
    if (const auto x = by_lobe.number(lobes[i])) (*angles)[i] = static_cast<float>(*x * degree);
}

/// Reads the color after the shape of the fiber, on which the absorption for a color depends.
void read_color(const JsonReader& json, Material* material) {
  fiber::FiberParameters* fiber = &material->fiber;
  if (!json.at_most_one({"color", "hair", "melanin", "sigma_a"})) return;
  const AbsorptionOf absorption(material->spectral);
  std::optional<Source> dye;
  if (json.has("dye")) dye = read_source(json, "dye", read_triple());
  const auto take = [&](Source source, Absorption sigma_a) {
    Pigment pigment{std::move(source), std::move(sigma_a), dye, absorption.of_lock()};
    if (const auto x = take_dyed(std::move(pigment), *fiber, material)) fiber->sigma_a = *x;
  };
  if (json.has("sigma_a")) take(read_source(json, "sigma_a", read_triple()), absorption.of_given());
  if (json.has("hair")) {
    const auto read = [&](const JsonReader& at, const std::string& key) -> std::optional<glm::vec3> {
      const auto name = at.choice(key, hair_color_names());
      return name ? absorption.hair(*name) : std::nullopt;
    };
    take(read_source(json, "hair", read), [](const glm::vec3& value, const fiber::FiberParameters&) { return value; });
  }
  if (json.has("color")) {
    material->color = take_pigment(read_color_source(json), absorption.of_lock(), material);
    if (material->color) fiber->sigma_a = absorption.of_lock()(*material->color, *fiber);
  }
  if (!json.has("melanin")) return;
  const auto melanin = json.child("melanin");
  if (!melanin.object()) return;
  Source both{.kind = Source::Kind::sum};
  const auto add = [&](const char* key, const glm::vec3& unit) {
    if (melanin.has(key)) both.parts.push_back(read_source(melanin, key, read_number(unit), unit));
  };
  add("eumelanin", {1, 0, 0});
  add("pheomelanin", {0, 1, 0});
  take(simplified(std::move(both)), [absorption](const glm::vec3& value, const fiber::FiberParameters&) {
    return absorption.melanin(value.x, value.y);
  });
}

/// Reads a number of the fiber or its source, if the key exists. unit: of the key, in the fiber's. Returns the number,
/// or the source's middle.
std::optional<float> read_number_of(const JsonReader& json, const std::string& key, std::optional<Source>* varied,
                                    double unit = 1) {
  if (!json.has(key)) return std::nullopt;
  const auto read = [unit](const JsonReader& at, const std::string& place) -> std::optional<glm::vec3> {
    const auto x = at.number(place);
    return x ? std::optional(glm::vec3(static_cast<float>(*x * unit))) : std::nullopt;
  };
  Source source = read_source(json, key, read, glm::vec3(static_cast<float>(unit)));
  const float middle = middle_of(source);
  if (source.kind != Source::Kind::constant) *varied = std::move(source);
  return middle;
}

std::optional<Source>* number_of(Material* material, FiberNumber number) {
  return &material->numbers[static_cast<std::size_t>(number)];
}

/// Reads numbers of a part of the fiber, by key; those that are not there are 0.
void read_part(const JsonReader& json, Material* material,
               const std::vector<std::tuple<const char*, FiberNumber, float fiber::FiberParameters::*>>& numbers) {
  if (!json.object() || !json.need({std::get<0>(numbers[0])})) return;
  for (const auto& [key, number, member] : numbers)
    material->fiber.*member = read_number_of(json, key, number_of(material, number)).value_or(0);
}

void read_material_number(const JsonReader& json, const MaterialNumber& number, Material* material) {
  if (!json.has(number.key)) return;
  if (const auto* plain = std::get_if<std::optional<double> Material::*>(&number.member)) {
    if (const auto x = json.number(number.key)) material->** plain = *x * number.unit;
    return;
  }
  const glm::vec3 unit(static_cast<float>(number.unit));
  material->*std::get<std::optional<Source> Material::*>(number.member) =
      read_source(json, number.key, read_number(unit), unit);
}

StrandVariation read_variation(const JsonReader& json) {
  StrandVariation variation;
  if (!json.object()) return variation;
  variation.eccentricity = static_cast<float>(json.number("eccentricity").value_or(0));
  variation.width = static_cast<float>(json.number("width").value_or(0));
  variation.color = static_cast<float>(json.number("color").value_or(0));
  variation.seed = static_cast<std::uint64_t>(json.integer("seed").value_or(0));
  return variation;
}

/// Reads the lobes. A scene that names GLINT splits it off TRT. If it is not named it has the gain and tint of TRT, so
/// that "glint": true changes layers only.
void read_lobes(const JsonReader& json, Material* material) {
  fiber::FiberParameters* fiber = &material->fiber;
  if (const auto shape = json.choice_number("longitudinal_shape"))
    fiber->longitudinal_shape = static_cast<fiber::LongitudinalShape>(*shape);
  if (const auto fresnel = json.choice_number("fresnel"))
    fiber->reflection_fresnel = static_cast<fiber::ReflectionFresnel>(*fresnel);
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
      if (!by_lobe.has(lobe)) continue;
      Source source = read_source(by_lobe, lobe, key == tint ? read_triple() : read_number(glm::vec3(1.0f)));
      if (source.kind == Source::Kind::constant)
        fiber->gain[p] *= source.value;
      else
        (key == tint ? material->tint : material->gain)[p] = std::move(source);
    }
    if (by_lobe.has(lobes[glint])) fiber->split_glint = true;
  }
  if (json.has("glint")) {
    if (!json.boolean("glint").value_or(true)) json.fail("glint", "true", "false");
    fiber->split_glint = true;
  }
}

}  // namespace

Material usual_material(bool spectral) {
  Material material;
  material.spectral = spectral;
  const float eumelanin = material.fiber.sigma_a.g / fiber::sigma_a_from_melanin(1, 0).g;  // the usual pigment
  if (spectral) material.fiber.sigma_a = AbsorptionOf(spectral).melanin(eumelanin, 0);
  return material;
}

Material read_material(const JsonReader& json, std::size_t index, bool spectral) {
  Material material = usual_material(spectral);
  if (!json.object()) return material;
  auto& fiber = material.fiber;
  material.name = json.text("name").value_or(fmt::format("material {}", index));
  if (json.has("principled")) read_principled(json, &material);
  if (json.has("chiang_hair_bsdf")) read_chiang_hair_bsdf(json, &material);
  if (json.has("marschner")) read_marschner(json, &material);
  if (const auto x = json.number("eta")) fiber.eta = static_cast<float>(*x);
  if (const auto x = read_number_of(json, "eccentricity", number_of(&material, FiberNumber::eccentricity)))
    fiber.eccentricity = *x;
  if (const auto x = read_number_of(json, "roughness", &material.roughness)) fiber.roughness = *x;
  for (const MaterialNumber& number : material_numbers) read_material_number(json, number, &material);
  if (const auto x = read_number_of(json, "tilt_deg", number_of(&material, FiberNumber::tilt), degree)) fiber.tilt = *x;
  if (const auto x = read_number_of(json, "wetness", number_of(&material, FiberNumber::wetness))) fiber.wetness = *x;
  using Fiber = fiber::FiberParameters;
  if (json.has("medulla"))
    read_part(json.child("medulla"), &material,
              {{"radius", FiberNumber::medulla_radius, &Fiber::medulla_radius},
               {"scattering", FiberNumber::medulla_scattering, &Fiber::medulla_scattering},
               {"asymmetry", FiberNumber::medulla_asymmetry, &Fiber::medulla_asymmetry},
               {"absorption", FiberNumber::medulla_absorption, &Fiber::medulla_absorption}});
  if (json.has("cortex"))
    read_part(json.child("cortex"), &material,
              {{"scattering", FiberNumber::cortex_scattering, &Fiber::cortex_scattering},
               {"asymmetry", FiberNumber::cortex_asymmetry, &Fiber::cortex_asymmetry}});
  if (json.has("dye") && !json.has("melanin") && !json.has("hair"))
    json.fail("dye", "this key beside \"melanin\" or \"hair\" only", "it without");
  if (!json.has("principled") && !json.has("chiang_hair_bsdf") && !json.has("marschner")) read_color(json, &material);
  if (json.has("variation")) material.variation = read_variation(json.child("variation"));
  read_lobe_angles(json, "azimuthal_sigma_deg", {"TT", "TRT", "TRRT"}, &fiber.azimuthal_sigma);
  read_lobe_angles(json, "longitudinal_lambda_deg", {"R", "TT", "TRT", "TRRT"}, &fiber.longitudinal_lambda);
  read_lobes(json, &material);
  material.twist = json.boolean("twist").value_or(true);
  if (const auto names = attributes_of(material); names.size() > 1)
    json.fail("", "one attribute of the file in a material", fmt::format("{}", fmt::join(names, ", ")));
  return material;
}

}  // namespace tress::scene
