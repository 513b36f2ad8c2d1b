// The fibers of the rough model and what they share.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "fiber/rough_rows.h"
#include "models/lobes/fiber_store.h"
#include "models/rough/traced_path.h"
#include "tress/adaptive/service.h"
#include "tress/fiber/fiber_model.h"

namespace tress::fiber {

/// The rows of a fiber under its color. Answers are RoughRow.
struct RoughRows {
  std::shared_ptr<const RoughGrid> grid;
  const adaptive::FormedRows* formed = nullptr;  ///< null without a service
  bool keeps_sum = false;                        ///< no gains: the sum over lobes is held to RoughRow::whole_energy
};

/// Shared: energies as FiberStore does, a slice and its grid by its key, forms by (slice, sigma_a). Thread-safety:
/// add(): one thread, between passes; the rest: any thread, during a pass.
class RoughFibers {
 public:
  /// service null: fibers have no rows.
  explicit RoughFibers(adaptive::Service* service) : service_(service) {}

  /// Equal parameters give the same id.
  FiberId add(const FiberParameters& parameters);
  const FiberRecord& record(FiberId id) const { return store_[id]; }
  const RoughRows& rows(FiberId id) const { return rows_[id]; }
  const TracedFibers& traced() const { return traced_; }
  std::size_t bytes() const { return store_.bytes() + traced_.bytes() + rows_.capacity() * sizeof(RoughRows); }

 private:
  using Color = std::array<float, 3>;

  RoughRows rows_of(const FiberParameters& parameters, const std::shared_ptr<const EnergyTable>& energies);

  adaptive::Service* service_;
  FiberStore store_;
  TracedFibers traced_;
  std::vector<RoughRows> rows_;  ///< by id
  std::map<adaptive::SliceId, std::shared_ptr<const RoughGrid>> grids_;
  std::map<std::pair<adaptive::SliceId, Color>, const adaptive::FormedRows*> formed_;
};

}  // namespace tress::fiber
