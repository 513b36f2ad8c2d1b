#include "scene/read/principled_reader.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "scene/read/source_reader.h"
#include "tress/fiber/principled_hair.h"

namespace tress::scene {
namespace {

constexpr double most_variation = 0.9;

/// Half range of the factor on the absorption, if melanin has that half range of a factor.
double color_variation(double melanin, double half_range) {
  const double m = std::clamp(melanin, 1e-4, 1 - 1e-4);
  return std::min(half_range * m / ((1 - m) * -std::log(1 - m)), most_variation);
}

/// The same for the widths, which grow faster than the roughness from which they follow.
double width_variation(double roughness, double half_range) {
  const double b = roughness;
  return std::min(half_range * (0.726 + 1.624 * b) / (0.726 + 0.812 * b), most_variation);
}

void read_absorption(const JsonReader& json, float radial_roughness, fiber::PrincipledHair* hair, Material* material) {
  const AbsorptionOf absorption(material->spectral);
  const auto take = [&](Source source, const Absorption& sigma_a) {
    if (const auto x = take_pigment(std::move(source), sigma_a, material)) hair->sigma_a = sigma_a(*x, {});
  };
  const Absorption of_color =
      absorption.of_color([radial_roughness](const glm::vec3& value, const fiber::FiberParameters&) {
        return fiber::sigma_a_of_principled_color(value, radial_roughness);
      });
  if (json.has("sigma_a")) take(read_source(json, "sigma_a", read_triple()), absorption.of_given());
  if (json.has("color")) take(read_color_source(json), of_color);
  for (const char* key : {"redness", "tint", "random_color"})
    if (json.has(key) && !json.has("melanin")) json.fail(key, "this key beside \"melanin\" only", "it without it");
  if (!json.has("melanin")) return;
  const auto redness = static_cast<float>(json.number("redness").value_or(1));
  std::optional<Source> dye;
  if (json.has("tint")) dye = read_source(json, "tint", read_triple());
  const glm::vec3 unit(1, 0, 0);
  const Source melanin = read_source(json, "melanin", read_number(unit), unit);
  const auto of_melanin = [redness, absorption](const glm::vec3& value, const fiber::FiberParameters&) {
    return absorption.principled_melanin(value.x, redness);
  };
  if (const auto x = take_dyed({melanin, of_melanin, std::move(dye), of_color}, {}, material)) hair->sigma_a = *x;
  if (const auto x = json.number("random_color"))
    material->variation.color = static_cast<float>(color_variation(double{middle_of(melanin)}, *x));
}

}  // namespace

bool is_alone(const JsonReader& material_json, const char* node) {
  for (const char* key : {"eta", "eccentricity", "roughness", "tilt_deg", "color", "hair", "melanin", "dye", "sigma_a",
                          "azimuthal_sigma_deg", "longitudinal_lambda_deg", "longitudinal_shape", "variation"})
    if (!material_json.at_most_one({node, key})) return false;
  return material_json.at_most_one({"principled", "chiang_hair_bsdf", "marschner"});
}

void read_chiang_hair_bsdf(const JsonReader& material_json, Material* material) {
  if (!is_alone(material_json, "chiang_hair_bsdf") || !material_json.at_most_one({"chiang_hair_bsdf", "tint"})) return;
  const auto json = material_json.child("chiang_hair_bsdf");
  const std::vector<std::string> lobes{"R", "TT", "TRT"};
  if (!json.object()) return;
  fiber::ChiangHair hair;
  hair.eta = static_cast<float>(json.number("ior").value_or(hair.eta));
  hair.cuticle_angle = static_cast<float>(json.number("cuticle_angle").value_or(hair.cuticle_angle));
  hair.sigma_a = AbsorptionOf(material->spectral).given(json.triple("absorption_coefficient").value_or(hair.sigma_a));
  for (std::size_t p = 0; p < lobes.size(); ++p) {
    hair.tint[p] = json.triple("tint_" + lobes[p]).value_or(hair.tint[p]);
    if (!json.has("roughness_" + lobes[p])) continue;
    const auto roughness = json.child("roughness_" + lobes[p]);
    if (!roughness.object()) return;
    const auto take = [&](const char* key, float* x) { *x = static_cast<float>(roughness.number(key).value_or(*x)); };
    take("longitudinal", &hair.longitudinal_variance[p]);
    take("azimuthal", &hair.azimuthal_scale[p]);
  }
  material->fiber = fiber::fiber_of(hair);
  material->has_node_widths = true;
}

void read_principled(const JsonReader& material_json, Material* material) {
  if (!is_alone(material_json, "principled")) return;
  const auto json = material_json.child("principled");
  if (!json.object() || !json.exactly_one({"melanin", "color", "sigma_a"}) ||
      !json.at_most_one({"aspect_ratio", "radial_roughness"}) || !json.at_most_one({"aspect_ratio", "coat"}) ||
      !json.at_most_one({"aspect_ratio", "widths"}))
    return;
  fiber::PrincipledHair hair;
  const auto take = [&](const char* key, float* x) { *x = static_cast<float>(json.number(key).value_or(*x)); };
  take("roughness", &hair.roughness);
  take("radial_roughness", &hair.radial_roughness);
  take("coat", &hair.coat);
  take("eta", &hair.eta);
  if (const auto x = json.number("offset_deg")) hair.offset = static_cast<float>(*x * std::numbers::pi / 180);
  if (const auto widths = json.choice("widths"))
    hair.widths = *widths == "fitted" ? fiber::PrincipledWidths::fitted : fiber::PrincipledWidths::published;
  if (const auto x = json.number("aspect_ratio")) hair.aspect_ratio = static_cast<float>(*x);
  read_absorption(json, hair.aspect_ratio ? hair.roughness : hair.radial_roughness, &hair, material);
  if (const auto x = json.number("random_roughness"))
    material->variation.width = static_cast<float>(width_variation(double{hair.roughness}, *x));
  material->fiber = fiber::fiber_of(hair);
  material->has_node_widths = !hair.aspect_ratio;
}

}  // namespace tress::scene
