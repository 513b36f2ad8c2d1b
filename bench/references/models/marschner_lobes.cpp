#include "references/models/marschner_lobes.h"

#include "base/color.h"
#include "fiber/energy_table.h"
#include "tress/fiber/parameters.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr float share_of_all = 0.02f;

}  // namespace

glm::vec3 sigma_a_per_radius(const FiberParameters& fiber) {
  return fiber.sigma_a * static_cast<float>(1 / major_semi_axis(1, static_cast<double>(fiber.eccentricity)));
}

MarschnerEnergies marschner_energies(const MarschnerTable& table, const FiberParameters& fiber) {
  MarschnerEnergies energies;
  for (std::size_t l = 0; l < marschner_lobes; ++l) {
    energies[l] = table.energies(static_cast<MarschnerLobe>(l), sigma_a_per_radius(fiber));
    for (glm::vec3& energy : energies[l]) energy *= gain_of(fiber, l);
  }
  return energies;
}

void begin_lobes(const FiberParameters& fiber, const MarschnerTable& table, const MarschnerEnergies& energies,
                 float folded_phi_r, FiberEvent& event) {
  std::array<float, marschner_lobes> bright{};
  float all = 0, sum = 0;
  for (std::size_t l = 0; l < marschner_lobes; ++l) {
    const MarschnerTable::Place place = table.place(static_cast<MarschnerLobe>(l), folded_phi_r, event.wr.theta);
    glm::vec3 energy(0.0f);
    for (std::size_t k = 0; k < 4; ++k) energy += place.share[k] * energies[l][place.node[k]];
    all += bright[l] = luminance(energy);
    event.energy[static_cast<std::size_t>(layer_of(fiber, l))] += energy;
  }
  for (std::size_t l = 0; l < marschner_lobes; ++l) {
    if (!(luminance(gain_of(fiber, l)) > 0) || !(all > 0)) continue;
    sum += event.selection[static_cast<std::size_t>(own_lobes[l])] = bright[l] + share_of_all * all;
  }
  if (!(sum > 0)) event.selection[0] = sum = 1;
  for (float& probability : event.selection) probability /= sum;
}

std::size_t draw_lobe(const FiberEvent& event, float u) {
  std::size_t drawn = 0;
  float below = 0;
  for (std::size_t l = 0; l < marschner_lobes; ++l) {
    const float probability = selection_of(event, l);
    if (!(probability > 0)) continue;
    drawn = l;
    if (u < below + probability) break;
    below += probability;
  }
  return drawn;
}

}  // namespace tress::inline v0_2::fiber
