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
/// its key, and absorbed by (slice, sigma_a). Thread-safety: operator[] and pool(): any thread, during a pass; the
/// rest: one thread, between passes.
class FiberStore {
 public:
  /// service null: fibers have no rows.
  explicit FiberStore(adaptive::Service* service) : service_(service) {}

  /// Equal parameters give the same id.
  FiberId add(const FiberParameters& parameters);
  const FiberRecord& operator[](FiberId id) const { return fibers_[id]; }

  /// Takes over Service::last_changes() in O(changes). Only where a row that was converged is so no more are the
  /// colors of its slice visited; that slice's rows are then all asked of the service again.
  void rows_changed();

  AbsorbedRowPool& pool() const { return pool_; }
  /// Of energies, rows and fibers, without the service's own.
  std::size_t bytes() const;

 private:
  struct SliceEntry {
    std::shared_ptr<SliceRows> slice;
    std::vector<std::shared_ptr<ColoredRows>> colors;
  };
  using Color = std::array<float, 3>;
  using EnergyTableKey = std::tuple<EnergyKey, Color, std::array<float, 3 * lobe_count>, ReflectionFresnel>;

  std::shared_ptr<const EnergyTable> energies_of(const FiberParameters& parameters);
  std::shared_ptr<const ColoredRows> rows_of(int slice_lobe, float sigma_rad, const FiberParameters& parameters);

  adaptive::Service* service_;
  FiberIds ids_;
  std::vector<FiberRecord> fibers_;  ///< by id
  SharedEnergies clear_;
  std::map<EnergyTableKey, std::shared_ptr<const EnergyTable>> colored_energies_;
  std::map<adaptive::SliceId, SliceEntry> slices_;
  std::map<std::tuple<int, float, float, float>, adaptive::SliceId> slice_of_key_;  ///< slice lobe, eta, e, sigma
  std::map<std::pair<adaptive::SliceId, Color>, std::shared_ptr<const ColoredRows>> colored_rows_;
  mutable AbsorbedRowPool pool_;
};

}  // namespace tress::fiber
