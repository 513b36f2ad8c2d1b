// The fibers of a model and what they share. Memory and start-up grow with distinct values, not with fibers.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include "fiber/fiber_ids.h"
#include "models/elliptical/fiber_record.h"
#include "tress/adaptive/service.h"
#include "tress/fiber/fiber_model.h"

namespace tress::fiber {

/// Shared: clear energies by their key, colored ones by that and (sigma_a, gain, Fresnel of R), the rows of a slice by
/// its key, and absorbed by (slice, sigma_a). Thread-safety: operator[]: any thread, during a pass; the rest: one
/// thread, between passes.
class FiberStore {
 public:
  /// service null: fibers have no rows.
  explicit FiberStore(adaptive::Service* service) : service_(service) {}

  /// Equal parameters give the same id.
  FiberId add(const FiberParameters& parameters);
  const FiberRecord& operator[](FiberId id) const { return fibers_[id]; }

  /// Of energies and fibers, without the service's own.
  std::size_t bytes() const;

 private:
  using Color = std::array<float, 3>;
  using EnergyTableKey = std::tuple<EnergyKey, Color, std::array<float, 3 * lobe_count>, ReflectionFresnel>;

  std::shared_ptr<const EnergyTable> energies_of(const FiberParameters& parameters);
  std::shared_ptr<const ColoredRows> rows_of(int slice_lobe, float sigma_rad, const FiberParameters& parameters);

  adaptive::Service* service_;
  FiberIds ids_;
  std::vector<FiberRecord> fibers_;  ///< by id
  SharedEnergies clear_;
  std::map<EnergyTableKey, std::shared_ptr<const EnergyTable>> colored_energies_;
  std::map<std::tuple<int, float, float, float>, std::shared_ptr<const SliceRows>>
      slices_;  ///< slice lobe, eta, e, sigma
  std::map<std::pair<adaptive::SliceId, Color>, std::shared_ptr<const ColoredRows>> colored_rows_;
};

}  // namespace tress::fiber
