// The data of a fiber of the elliptical model, mostly references to data that fibers share.
#pragma once

#include <array>
#include <memory>

#include "fiber/energy_table.h"
#include "fiber/lobe_widths.h"
#include "models/elliptical/colored_rows.h"
#include "tress/fiber/lobes.h"
#include "tress/fiber/parameters.h"

namespace tress::inline v0_2::fiber {

/// The lobes that have rows, in the order of arrays over them. GLINT has rows only if the fiber splits it off; the rows
/// of TRT are then those of its rest.
constexpr std::array<Lobe, 4> row_lobes{Lobe::tt, Lobe::trt, Lobe::trrt, Lobe::glint};
/// Their orders p, which determine longitudinal lobe and tilt.
constexpr std::array<int, 4> row_orders{1, 2, 3, 2};

/// Plain data and shared parts, written between passes only.
struct EllipticalFiber {
  FiberParameters parameters;
  LobeWidths widths;
  std::array<float, 4> sigma{};         ///< blur of each of row_lobes, radians
  std::array<bool, 4> proposes_only{};  ///< their rows have smallest_grid_sigma and serve only as proposals
  /// Whether converged rows alone can answer: there is a service, and no lobe only proposes.
  bool answers_by_rows = false;
  int vertex_rays = 256;
  std::shared_ptr<const EnergyTable> energies;
  std::array<std::shared_ptr<const ColoredRows>, 4> rows;  ///< rows of each of row_lobes; null without a service
};

}  // namespace tress::inline v0_2::fiber
