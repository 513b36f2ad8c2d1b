// The rows of a slice, and what every color that reads them keeps of them.
#pragma once

#include <atomic>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "fiber/row_axes.h"
#include "models/elliptical/absorbed_row.h"
#include "tress/adaptive/service.h"

namespace tress::fiber {

/// Where the rays of a node have less mass, its light is spread uniformly over the azimuth, without a row.
constexpr float smallest_row_energy = 1e-3f;

/// One slice, for all fibers and colors that have it. Written between passes only.
struct SliceRows {
  /// Traces every node once: some milliseconds.
  SliceRows(adaptive::Service& service, const adaptive::SliceDescription& description);

  adaptive::SliceId slice;
  RowGrid grid;
  std::uint32_t width;  ///< nodes of axis_b
  std::uint32_t node_count;
  std::vector<bool> uniform;    ///< by node: mass of its rays below smallest_row_energy
  std::vector<bool> converged;  ///< by node, as of the last change that was told
};

/// The rows of a slice under one absorption. A row is absorbed when first read after it converged, so that memory and
/// time go to the rows that fibers of this color meet. Reading: any thread, during a pass; forget(): between passes.
class ColoredRows {
 public:
  ColoredRows(std::shared_ptr<const SliceRows> slice, const glm::vec3& sigma_a);

  const SliceRows& slice() const { return *slice_; }
  const glm::vec3& sigma_a() const { return sigma_a_; }

  /// The converged row at a node, or the node without a row; null where neither has been put here.
  using Slot = std::atomic<const AbsorbedRow*>;
  const AbsorbedRow* find(std::uint32_t node) const { return rows_[node].load(std::memory_order_acquire); }
  /// The slots of `node` and those behind it.
  const Slot* slots(std::uint32_t node) const { return rows_.get() + node; }
  /// Takes over a converged row. A pure function of its arguments: whichever thread comes first, the same values.
  const AbsorbedRow* put(std::uint32_t node, const adaptive::RowView& view, AbsorbedRowPool& pool) const;
  /// Takes over a node without a row.
  const AbsorbedRow* put_uniform(std::uint32_t node) const;
  /// All rows are to be asked of the service again.
  void forget();

  /// Mass per channel of a node's rays: a pure function of the node, remembered.
  glm::vec3 absorbed_mass(std::uint32_t node, const adaptive::TracedNodes& nodes) const;

  std::size_t bytes() const { return sizeof(*this) + slice_->node_count * (sizeof(rows_[0]) + 3 * sizeof(float)); }

 private:
  std::shared_ptr<const SliceRows> slice_;
  glm::vec3 sigma_a_;
  std::unique_ptr<Slot[]> rows_;
  std::unique_ptr<std::atomic<float>[]> mass_memo_;  ///< 3 per node, negative while unknown
};

/// Slots for every node in |theta_d|: of a row of density 0 that is none of the service's, and empty ones.
const ColoredRows::Slot* rows_of_nothing();
const ColoredRows::Slot* no_rows();

}  // namespace tress::fiber
