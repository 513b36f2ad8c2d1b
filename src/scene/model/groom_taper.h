// Strands that thin towards the tip.
#pragma once

#include "scene/model/scene.h"

namespace tress::scene {

/// Factors of the radius, linear in between along the normalised length of the strand's points.
struct Taper {
  double root = 1, tip = 1;
};

/// No radius becomes less than 1e-4 cm, unless it was.
void apply_taper(const Taper& taper, Groom* groom);

}  // namespace tress::scene
