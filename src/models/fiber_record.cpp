#include "models/fiber_record.h"

#include <algorithm>
#include <utility>

#include "models/vertex_trace.h"
#include "tress/fiber/elliptical_model.h"

namespace tress::fiber {

LobePage::LobePage(adaptive::Service& service, const adaptive::PageDescription& description,
                   const EnergyTable& energies, const glm::vec3& sigma_a)
    : page(service.add_page(description)),
      grid(description),
      width(static_cast<std::uint32_t>(description.axis_b.size())),
      uniform(description.node_count()),
      rows(description.node_count()),
      mass_memo(std::make_unique<std::atomic<float>[]>(std::size_t{3} * description.node_count())) {
  for (std::size_t k = 0; k < std::size_t{3} * description.node_count(); ++k) {
    mass_memo[k].store(-1, std::memory_order_relaxed);
  }
  for (std::uint32_t a = 0; a < description.axis_a.size(); ++a) {
    for (std::uint32_t b = 0; b < width; ++b) {
      const LobeEnergies energy = energies.interpolated(description.axis_a[a], description.axis_b[b]);
      uniform[node(a, b)] = energy.clear[description.key.lobe] < smallest_row_energy;
      take_over(service, a, b, sigma_a);
    }
  }
}

void LobePage::take_over(const adaptive::Service& service, const std::vector<adaptive::Service::RowChange>& changes,
                         const glm::vec3& sigma_a) {
  for (const adaptive::Service::RowChange& change : changes) {
    if (change.page == page) take_over(service, change.node / width, change.node % width, sigma_a);
  }
}

void LobePage::take_over(const adaptive::Service& service, std::uint32_t a, std::uint32_t b, const glm::vec3& sigma_a) {
  const adaptive::RowView view = service.peek(page, a, b);
  if (view.state == adaptive::RowState::converged && view.fit != nullptr) {
    rows.set(node(a, b), *view.fit, sigma_a);
  } else {
    rows.clear(node(a, b));
  }
}

glm::vec3 LobePage::tinted_mass(std::uint32_t node, const adaptive::TracedNodes& nodes,
                                const glm::vec3& sigma_a) const {
  std::atomic<float>* memo = mass_memo.get() + std::size_t{3} * node;
  glm::vec3 mass;
  for (int c = 0; c < 3; ++c) mass[c] = memo[c].load(std::memory_order_relaxed);
  if (mass.x >= 0 && mass.y >= 0 && mass.z >= 0) return mass;
  mass = ray_mass(shape_of(nodes), sigma_a).tinted;
  for (int c = 0; c < 3; ++c) memo[c].store(mass[c], std::memory_order_relaxed);
  return mass;
}

FiberRecord::FiberRecord(const FiberParameters& given, std::shared_ptr<const ClearEnergies> clear,
                         adaptive::Service* service)
    : parameters(given), sigma(azimuthal_sigmas(given)), energies(std::move(clear), given) {
  for (const float blur : sigma) vertex_rays = std::max(vertex_rays, vertex_ray_count(blur));
  for (std::size_t i = 0; i < 3; ++i) {
    // Four degrees turned into radians may round below the limit and are still on the grid.
    proposes_only[i] = sigma[i] < smallest_grid_sigma * (1 - 1e-5f);
    if (service == nullptr) continue;
    const adaptive::PageDescription description = elliptical_page(
        static_cast<int>(i) + 1, given.eta, given.eccentricity, std::max(sigma[i], smallest_grid_sigma));
    pages.emplace_back(*service, description, energies, given.sigma_a);
  }
}

}  // namespace tress::fiber
