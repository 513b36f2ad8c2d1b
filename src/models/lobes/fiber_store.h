// The fibers of a model and the energies of their lobes. Memory and start-up time grow with the number of distinct
// values, not with fibers.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include "fiber/energy_table.h"
#include "fiber/fiber_ids.h"
#include "tress/fiber/fiber_model.h"
#include "tress/fiber/parameters.h"

namespace tress::inline v0_2::fiber {

/// A fiber as it was given, and the energies of its lobes.
struct FiberRecord {
  FiberParameters parameters;
  std::shared_ptr<const EnergyTable> energies;
};

/// Shares clear energies by their key, and colored ones by that and (sigma_a, gain, Fresnel of R). Thread-safety:
/// operator[]: any thread, during a pass; the rest: one thread, between passes.
class FiberStore {
 public:
  /// Equal parameters give the same id; the id of a new fiber is the previous size().
  FiberId add(const FiberParameters& parameters);
  const FiberRecord& operator[](FiberId id) const { return fibers_[id]; }
  std::size_t size() const { return fibers_.size(); }
  std::size_t bytes() const;

 private:
  using Color = std::array<float, 3>;
  using EnergyTableKey = std::tuple<EnergyKey, Color, std::array<float, 3 * lobe_count>, ReflectionFresnel>;

  std::shared_ptr<const EnergyTable> energies_of(const FiberParameters& parameters);

  FiberIds ids_;
  std::vector<FiberRecord> fibers_;  ///< by id
  SharedEnergies clear_;
  std::map<EnergyTableKey, std::shared_ptr<const EnergyTable>> colored_energies_;
};

}  // namespace tress::inline v0_2::fiber
