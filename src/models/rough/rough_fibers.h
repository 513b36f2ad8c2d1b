// The fibers of the rough model and their shared parts.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "base/float4.h"
#include "fiber/rough_rows.h"
#include "models/lobes/fiber_store.h"
#include "models/rough/traced_path.h"
#include "tress/adaptive/service.h"
#include "tress/fiber/fiber_model.h"

namespace tress::inline v0_2::fiber {

/// The rows of a fiber, under its color and under any. Answers of the former are RoughRow.
struct RoughRows {
  std::shared_ptr<const RoughGrid> grid;
  const adaptive::FormedRows* formed = nullptr;     ///< null without a service
  const adaptive::FormedRows* uncolored = nullptr;  ///< UncoloredRow; null without a service
  /// The inverse gains of each lobe, with which energies are compared to RoughRow::whole_energy without gains; 0 if a
  /// gain is 0.
  std::array<Float4, lobe_count> inverse_gain{};
  float balance = 0, near_balance = 0;  ///< TracedFibers::balance(), from anywhere and from a known offset
};

/// Shares energies as FiberStore does, a slice and its grid by its key, and forms by (slice, sigma_a). Thread-safety:
/// add(): one thread, between passes; the rest: any thread, during a pass.
class RoughFibers {
 public:
  /// service null: fibers have no rows.
  explicit RoughFibers(adaptive::Service* service) : service_(service) {}
  /// The place where light enters in events that no row answers.
  Offset offset() const { return service_ != nullptr ? Offset::any : Offset::known; }

  /// Equal parameters give the same id; no_fiber if the service refuses the slice.
  FiberId add(const FiberParameters& parameters);
  const FiberRecord& record(FiberId id) const { return store_[id]; }
  const RoughRows& rows(FiberId id) const { return rows_[id]; }
  /// The balance for any id, of events that no row answers, or of those whose light enters as said.
  float balance(FiberId id) const { return balance(id, offset()); }
  float balance(FiberId id, Offset enters) const {
    if (id >= rows_.size()) return 0;
    return enters == Offset::any ? rows_[id].balance : rows_[id].near_balance;
  }
  const TracedFibers& traced() const { return traced_; }
  std::size_t bytes() const { return store_.bytes() + traced_.bytes() + rows_.capacity() * sizeof(RoughRows); }

 private:
  using Color = std::array<float, 3>;

  RoughRows rows_of(const FiberParameters& parameters, const std::shared_ptr<const EnergyTable>& energies);
  /// rough_slice(), with the coarse rows of the first fiber added that is so similar that they describe both.
  adaptive::SliceDescription slice_of(const FiberParameters& parameters) const;

  adaptive::Service* service_;
  FiberStore store_;
  TracedFibers traced_;
  std::vector<RoughRows> rows_;                       ///< by id
  std::vector<adaptive::SliceKey> with_coarse_rows_;  ///< of slices with coarse rows of their own, in order
  std::map<adaptive::SliceId, std::shared_ptr<const RoughGrid>> grids_;
  std::map<std::pair<adaptive::SliceId, Color>, const adaptive::FormedRows*> formed_;
  std::map<adaptive::SliceId, const adaptive::FormedRows*> uncolored_;
};

}  // namespace tress::inline v0_2::fiber
