// What marschner2003 and pekelis2015 share beside the azimuthal part: R, TT, TRT, GLINT as the lobes of a fiber.
#pragma once

#include <array>
#include <cstddef>
#include <glm/vec3.hpp>
#include <vector>

#include "base/float4.h"
#include "fiber/lobe_widths.h"
#include "models/lobes/lobe_choice.h"
#include "references/models/marschner_table.h"
#include "tress/fiber/fiber_model.h"

namespace tress::inline v0_2::fiber {

/// Where every lobe has underflowed; S is 0 there.

/// By MarschnerLobe: whose gain and place in FiberEvent::selection a lobe has.
constexpr std::array<Lobe, marschner_lobes> own_lobes{Lobe::r, Lobe::tt, Lobe::trt, Lobe::glint};

/// The layer that a lobe is seen in: GLINT is part of TRT unless the fiber splits it off.
inline Lobe layer_of(const FiberParameters& fiber, std::size_t lobe) {
  return lobe == 3 && !fiber.split_glint ? Lobe::trt : own_lobes[lobe];
}
/// The gain of a lobe.
inline const glm::vec3& gain_of(const FiberParameters& fiber, std::size_t lobe) {
  return fiber.gain[static_cast<std::size_t>(own_lobes[lobe])];
}

/// Of LobeWidths lanes (TT, TRT, TRRT, R), by MarschnerLobe: GLINT has the width and tilt of TRT.
inline Float4 by_marschner_lobe(Float4 lanes) { return Float4{lanes[3], lanes[0], lanes[1], lanes[1]}; }

/// sigma_a per radius of the circle that has the mean projected width of the ellipse.
glm::vec3 sigma_a_per_radius(const FiberParameters& fiber);

/// Energies by MarschnerLobe and node of a table, under absorption and gain.
using MarschnerEnergies = std::array<std::vector<glm::vec3>, marschner_lobes>;
MarschnerEnergies marschner_energies(const MarschnerTable& table, const FiberParameters& fiber);

/// Fills event.energy for the known direction, and event.selection: each lobe in proportion to its luminance and a
/// fiftieth of their sum; lobes without gain, never. Sums to 1.
void begin_lobes(const FiberParameters& fiber, const MarschnerTable& table, const MarschnerEnergies& energies,
                 float folded_phi_r, FiberEvent& event);
/// The lobe that u in [0, 1) selects, by MarschnerLobe.
std::size_t draw_lobe(const FiberEvent& event, float u);
inline float selection_of(const FiberEvent& event, std::size_t lobe) {
  return event.selection[static_cast<std::size_t>(own_lobes[lobe])];
}

}  // namespace tress::inline v0_2::fiber
