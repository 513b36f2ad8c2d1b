#include "fit/ribbon_layer.h"

namespace tress::adaptive {

void scale_to_one(MainLayer& main, BroadLayer& broad) {
  double mass = 0;
  for (std::size_t k = 0; k < Ribbon::main_knots; ++k) mass += main.density[k] * main.hat(k);
  for (std::size_t k = 0; k < Ribbon::broad_knots; ++k) mass += broad.density[k] * broad.hat(k);
  if (!(mass > 0)) return;
  for (double& density : main.density) density /= mass;
  for (double& density : broad.density) density /= mass;
}

}  // namespace tress::adaptive
