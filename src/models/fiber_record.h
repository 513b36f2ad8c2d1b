// What the elliptical model keeps per fiber: little but references to what fibers share.
#pragma once

#include <array>
#include <memory>

#include "fiber/energy_table.h"
#include "models/colored_rows.h"
#include "tress/fiber/parameters.h"

namespace tress::fiber {

/// Plain data and shared parts; written between passes only.
struct FiberRecord {
  FiberParameters parameters;
  std::array<float, 3> sigma{};         ///< blur of TT, TRT, TRRT, radians
  std::array<bool, 3> proposes_only{};  ///< their rows are of smallest_grid_sigma and answer nothing
  int vertex_rays = 256;
  std::shared_ptr<const EnergyTable> energies;
  std::array<std::shared_ptr<const ColoredRows>, 3> rows;  ///< TT, TRT, TRRT; null without a service
};

}  // namespace tress::fiber
