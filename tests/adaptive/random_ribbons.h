// Ribbons for tests: of any shape that a ribbon may have.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "tress/adaptive/ribbon.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {

/// Knots at random azimuths, of random heights and widths; with `rough`, at the bounds of everything now and then.
inline Ribbon random_ribbon(std::uint64_t seed, bool rough = false) {
  RandomStream random(seed, 77);
  constexpr float pi = std::numbers::pi_v<float>;
  const auto knot = [&](float azimuth) {
    RibbonKnot k;
    k.azimuth = azimuth;
    k.density = random.next() * random.next();
    k.mode = 2 * random.next() - 1;
    k.scale_below = 0.02f + 0.4f * random.next();
    k.scale_above = 0.02f + 0.4f * random.next();
    const float attribute = 4 * random.next(), spread = 0.01f + random.next();
    for (std::size_t i = 0; i < 2; ++i) {
      const float scale = spread * attribute;
      k.decays[i] = std::exp(-attribute / scale * std::log1p(Ribbon::decay_rates[i] * scale));
    }
    if (!rough) return k;
    const float u = random.next();
    if (u < 0.2f) k.density = 0;
    if (u > 0.9f) k.mode = random.next() < 0.5f ? -Ribbon::largest_mode : Ribbon::largest_mode;
    if (random.next() < 0.2f) k.scale_below = Ribbon::least_scale;
    if (random.next() < 0.2f) k.scale_above = Ribbon::largest_scale;
    if (random.next() < 0.2f) k.decays = {random.next(), 0};
    return k;
  };
  std::array<float, Ribbon::main_knots> azimuths;
  for (float& x : azimuths) x = pi * (2 * random.next() - 1);
  if (rough) std::fill(azimuths.begin() + 4, azimuths.begin() + 12, azimuths[3]);
  std::sort(azimuths.begin(), azimuths.end());
  std::array<RibbonKnot, Ribbon::main_knots> main;
  std::array<RibbonKnot, Ribbon::broad_knots> broad;
  for (std::size_t k = 0; k < main.size(); ++k) main[k] = knot(azimuths[k]);
  for (std::size_t k = 0; k < broad.size(); ++k) {
    broad[k] = knot(-pi + 2 * pi * static_cast<float>(k) / static_cast<float>(broad.size()));
    broad[k].density *= 0.3f;
  }
  return Ribbon(main, seed % 2 == 0 ? HeightLaw::normal : HeightLaw::logistic, broad);
}

}  // namespace tress::inline v0_2::adaptive
