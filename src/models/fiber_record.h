// What the elliptical model keeps per fiber: energies, pages and tinted rows. Written between passes only.
#pragma once

#include <array>
#include <atomic>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "fiber/energy_table.h"
#include "fiber/row_axes.h"
#include "models/ray_shape.h"
#include "models/tinted_rows.h"
#include "tress/adaptive/service.h"
#include "tress/fiber/parameters.h"

namespace tress::fiber {

/// A node's energy below this is spread uniformly over the azimuth, without a row.
constexpr float smallest_row_energy = 1e-3f;
/// One lobe's page as one fiber reads it.
struct LobePage {
  LobePage(adaptive::Service& service, const adaptive::PageDescription& description, const EnergyTable& energies,
           const glm::vec3& sigma_a);

  adaptive::PageId page;
  RowGrid grid;
  std::uint32_t width = 1;    ///< nodes of axis_b
  std::vector<bool> uniform;  ///< by node: energy below smallest_row_energy
  TintedRows rows;

  std::uint32_t node(std::uint32_t a, std::uint32_t b) const { return a * width + b; }
  /// Tints the changed rows of this page.
  void take_over(const adaptive::Service& service, const std::vector<adaptive::Service::RowChange>& changes,
                 const glm::vec3& sigma_a);
  void take_over(const adaptive::Service& service, std::uint32_t a, std::uint32_t b, const glm::vec3& sigma_a);
  /// Masses of a node's rays under the fiber's color: a pure function of the node, remembered.
  glm::vec3 tinted_mass(std::uint32_t node, const adaptive::TracedNodes& nodes, const glm::vec3& sigma_a) const;

  std::unique_ptr<std::atomic<float>[]> mass_memo;  ///< 3 per node, negative while unknown
};

struct FiberRecord {
  /// clear: of energy_key(parameters). service null: no pages.
  FiberRecord(const FiberParameters& parameters, std::shared_ptr<const ClearEnergies> clear,
              adaptive::Service* service);

  FiberParameters parameters;
  std::array<float, 3> sigma{};         ///< blur of TT, TRT, TRRT, radians
  std::array<bool, 3> proposes_only{};  ///< their rows are of smallest_grid_sigma and answer nothing
  int vertex_rays = 256;
  EnergyTable energies;
  std::vector<LobePage> pages;  ///< TT, TRT, TRRT; empty without a service
};

}  // namespace tress::fiber
