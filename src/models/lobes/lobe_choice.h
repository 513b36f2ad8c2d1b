// The lobes of an event: their selection, and the storage of their values. Inlined into the models.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "base/color.h"
#include "base/float4.h"
#include "tress/fiber/fiber_model.h"
#include "tress/fiber/lobes.h"

namespace tress::inline v0_2::fiber {

/// Largest luminance of all lobes at which a fiber counts as black. A smaller value may be denormal, and its inverse
/// infinite.
constexpr float darkest_energy = 1e-30f;
constexpr float smallest_pdf = 1e-30f;  ///< pdf if every lobe has underflowed; S is nearly 0 there

/// The result of selecting lobes.
struct LobeShares {
  float inverse_luminance;  ///< 1 over the luminance of all lobes; 1 for a black fiber
  bool is_black;
};

/// Sets the selections of an event to the lobes' shares of the luminance. A black fiber selects R, and has no energy.
inline LobeShares select_lobes(FiberEvent& event) {
  float sum = 0;
  for (std::size_t p = 0; p < lobe_count; ++p) sum += event.selection[p] = luminance(event.energy[p]);
  const bool is_black = !(sum > darkest_energy);
  if (is_black) {
    event.energy = {};
    event.selection = {};
    event.selection[0] = sum = 1;
  }
  const float inverse_sum = 1 / sum;
  for (float& probability : event.selection) probability *= inverse_sum;
  return {inverse_sum, is_black};
}

/// The lobe that u in [0, 1) chooses: the first whose cumulative selection is above u, without branches.
inline std::size_t choose_lobe(const FiberEvent& event, float u) {
  std::size_t p = 0;
  float below = 0;
  for (const float probability : event.selection) {
    below += probability;
    p += u < below ? 0 : 1;
  }
  if (p == lobe_count) [[unlikely]] {  // u is beyond the sum of all, by rounding: take the last lobe that can be drawn
    do --p;
    while (p > 0 && !(event.selection[p] > 0));
  }
  return p;
}

/// The position of u within the share of the lobe that it chose, in [0, 1).
inline float spare_of_choice(const FiberEvent& event, std::size_t p, float u) {
  float below = 0;
  for (std::size_t lobe = 0; lobe < p; ++lobe) below += event.selection[lobe];
  return std::clamp((u - below) / event.selection[p], 0.0f, 0.99999994f);
}

/// Shares of the channels in the luminance of a lobe's energy. The lobe must be selected.
inline glm::vec3 channel_weights(const FiberEvent& event, std::size_t lobe) {
  const glm::vec3 terms = luminance_terms(event.energy[lobe]);
  return terms * (1 / (terms.x + terms.y + terms.z));
}

/// Loads a lobe's colors; the fourth lane is the number after them in the object.
inline Float4 load_energy(const FiberEvent& event, Lobe lobe) {
  return load4(event, offsetof(FiberEvent, energy) / sizeof(float) + 3 * static_cast<std::size_t>(lobe));
}

/// Stores S by lobe, with colors in lanes 0 to 2, and the pdf, as whole vectors, so that a later load finds each number
/// in one store. It also overwrites what follows the pdf, which must be set afterwards.
inline void put_value(FiberValue& value, const std::array<Float4, lobe_count>& s, float pdf) {
  static_assert(offsetof(FiberValue, s) == 0 && offsetof(FiberValue, pdf) == 18 * sizeof(float));
  store4(value, 0, Float4{s[0][0], s[0][1], s[0][2], s[1][0]});
  store4(value, 4, Float4{s[1][1], s[1][2], s[2][0], s[2][1]});
  store4(value, 8, Float4{s[2][2], s[3][0], s[3][1], s[3][2]});
  store4(value, 12, Float4{s[4][0], s[4][1], s[4][2], s[5][0]});
  store4(value, 16, Float4{s[5][1], s[5][2], pdf, 0});
}

}  // namespace tress::inline v0_2::fiber
