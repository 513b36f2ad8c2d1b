// The fibers of a model and what they share. Memory and start-up grow with distinct values, not with fibers.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include "models/elliptical/fiber_record.h"
#include "models/fiber_ids.h"
#include "tress/adaptive/service.h"
#include "tress/fiber/fiber_model.h"

namespace tress::fiber {

/// Shared: clear energies by their key, colored ones by that and (sigma_a, gain, Fresnel of R), the rows of a page by
/// its key, and tinted by (page, sigma_a). Thread-safety: operator[] and pool(): any thread, during a pass; the rest:
/// one thread, between passes.
class FiberStore {
 public:
  /// service null: fibers have no rows.
  explicit FiberStore(adaptive::Service* service) : service_(service) {}

  /// Equal parameters give the same id.
  FiberId add(const FiberParameters& parameters);
  const FiberRecord& operator[](FiberId id) const { return fibers_[id]; }

  /// Takes over Service::last_changes() in O(changes). Only where a row that was converged is so no more are the
  /// colors of its page visited; that page's rows are then all asked of the service again.
  void rows_changed();

  TintedRowPool& pool() const { return pool_; }
  /// Of energies, rows and fibers, without the service's own.
  std::size_t bytes() const;

 private:
  struct PageEntry {
    std::shared_ptr<PageRows> page;
    std::vector<std::shared_ptr<ColoredRows>> colors;
  };
  using Color = std::array<float, 3>;
  using EnergyTableKey = std::tuple<EnergyKey, Color, std::array<float, 3 * lobe_count>, ReflectionFresnel>;

  std::shared_ptr<const EnergyTable> energies_of(const FiberParameters& parameters);
  std::shared_ptr<const ColoredRows> rows_of(int page_lobe, float sigma_rad, const FiberParameters& parameters);

  adaptive::Service* service_;
  FiberIds ids_;
  std::vector<FiberRecord> fibers_;  ///< by id
  SharedEnergies clear_;
  std::map<EnergyTableKey, std::shared_ptr<const EnergyTable>> colored_energies_;
  std::map<adaptive::PageId, PageEntry> pages_;
  std::map<std::tuple<int, float, float, float>, adaptive::PageId> page_of_key_;  ///< page lobe, eta, e, sigma
  std::map<std::pair<adaptive::PageId, Color>, std::shared_ptr<const ColoredRows>> colored_rows_;
  mutable TintedRowPool pool_;
};

}  // namespace tress::fiber
