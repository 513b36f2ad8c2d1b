#include "cli/fiber_options.h"

#include "cli/option_types.h"

namespace tress::cli {

void add_fiber_shape(CLI::App* app, scene::Overrides& overrides) {
  add_number(
      app, "--eccentricity", {0.5, 1}, [&overrides](double x) { overrides.eccentricity = float(x); },
      "minor over major semi-axis of the cross-section, .5 to 1");
  add_number(
      app, "--roughness", {0.01, 1}, [&overrides](double x) { overrides.roughness = float(x); },
      "Beckmann roughness of the fiber surface, .01 to 1");
}

}  // namespace tress::cli
