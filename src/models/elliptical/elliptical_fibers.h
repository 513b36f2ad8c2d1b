// The fibers of the elliptical model and the rows that they share.
#pragma once

#include <array>
#include <cstddef>
#include <glm/vec3.hpp>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "models/elliptical/elliptical_fiber.h"
#include "models/lobes/fiber_store.h"
#include "tress/adaptive/service.h"
#include "tress/fiber/fiber_model.h"

namespace tress::inline v0_2::fiber {

/// The slices of a fiber by row lobe; empty for GLINT if it is not split off.
std::array<std::optional<adaptive::SliceDescription>, 4> elliptical_slices(const FiberParameters& fiber);

/// Shares energies as FiberStore does, the rows of a slice by its key, and their forms by (slice, sigma_a).
/// Thread-safety: operator[]: any thread, during a pass; the rest: one thread, between passes.
class EllipticalFibers {
 public:
  /// service null: fibers have no rows.
  explicit EllipticalFibers(adaptive::Service* service) : service_(service) {}

  /// Equal parameters give the same id; no_fiber if the service refuses a slice.
  FiberId add(const FiberParameters& parameters);
  const EllipticalFiber& operator[](FiberId id) const { return fibers_[id]; }

  /// The memory of energies and fibers, without that of the service.
  std::size_t bytes() const;

 private:
  using Color = std::array<float, 3>;

  std::shared_ptr<const ColoredRows> rows_of(const adaptive::SliceDescription& slice, const glm::vec3& sigma_a);

  adaptive::Service* service_;
  FiberStore store_;
  std::vector<EllipticalFiber> fibers_;  ///< by id
  std::map<adaptive::SliceKey, std::shared_ptr<const SliceRows>> slices_;
  std::map<std::pair<adaptive::SliceId, Color>, std::shared_ptr<const ColoredRows>> colored_rows_;
};

}  // namespace tress::inline v0_2::fiber
