#include "scene/model/absorption.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "base/bands.h"
#include "scene/model/hair_colors.h"
#include "tress/fiber/lock_color.h"
#include "tress/fiber/principled_hair.h"

namespace tress::scene {
namespace {

constexpr double green_nm = 550, eumelanin_power = -3.33, pheomelanin_power = -4.75;

glm::vec3 in_bands(float at_green, double power) {
  glm::vec3 bands;
  for (int c = 0; c < 3; ++c) {
    const double ratio = std::pow(band_wavelengths_nm[static_cast<std::size_t>(c)] / green_nm, power);
    bands[c] = static_cast<float>(double{at_green} * ratio);
  }
  return bands;
}

}  // namespace

glm::vec3 AbsorptionOf::melanin(float eumelanin, float pheomelanin) const {
  if (!spectral_) return fiber::sigma_a_from_melanin(eumelanin, pheomelanin);
  return in_bands(fiber::sigma_a_from_melanin(eumelanin, 0).g, eumelanin_power) +
         in_bands(fiber::sigma_a_from_melanin(0, pheomelanin).g, pheomelanin_power);
}

glm::vec3 AbsorptionOf::principled_melanin(float melanin, float redness) const {
  if (!spectral_) return fiber::sigma_a_of_principled_melanin(melanin, redness);
  redness = std::clamp(redness, 0.0f, 1.0f);
  return in_bands((1 - redness) * fiber::sigma_a_of_principled_melanin(melanin, 0).g, eumelanin_power) +
         in_bands(redness * fiber::sigma_a_of_principled_melanin(melanin, 1).g, pheomelanin_power);
}

glm::vec3 AbsorptionOf::given(const glm::vec3& sigma_a) const {
  if (!spectral_) return sigma_a;
  glm::vec3 kept, bands;
  for (int c = 0; c < 3; ++c) kept[c] = std::exp(-sigma_a[c]);
  kept = bands_of_rgb(kept);
  for (int c = 0; c < 3; ++c)
    bands[c] = std::max(0.0f, -std::log(std::max(kept[c], std::numeric_limits<float>::min())));
  return bands;
}

std::optional<glm::vec3> AbsorptionOf::hair(std::string_view name) const {
  for (const HairColor& color : hair_colors)
    if (color.name == name) return melanin(color.eumelanin, color.pheomelanin) + given(color.other);
  return std::nullopt;
}

Absorption AbsorptionOf::of_given() const {
  return [of = *this](const glm::vec3& value, const fiber::FiberParameters&) { return of.given(value); };
}

Absorption AbsorptionOf::of_color(Absorption by_channel) const {
  if (!spectral_) return by_channel;
  return [by_channel = std::move(by_channel)](const glm::vec3& color, const fiber::FiberParameters& fiber) {
    return by_channel(bands_of_rgb(color), fiber);
  };
}

Absorption AbsorptionOf::of_lock() const { return of_color(fiber::sigma_a_of_lock); }

}  // namespace tress::scene
