// The rows of a slice, and their forms for one color.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "fiber/row_axes.h"
#include "models/elliptical/absorbed_row.h"
#include "tress/adaptive/service.h"

namespace tress::inline v0_2::fiber {

/// If the rays of a node have less mass, its light is uniform over the azimuth, without a row.
constexpr float smallest_row_energy = 1e-3f;

/// One slice, shared by all fibers and colors that use it. Immutable.
struct SliceRows {
  /// Traces every node once, in some milliseconds. The service must have no other host for this key.
  SliceRows(adaptive::Service& service, const adaptive::SliceDescription& description);

  adaptive::SliceId slice;
  RowGrid grid;
  std::uint32_t width;  ///< nodes of axis_b
  std::uint32_t node_count;
  std::vector<bool> uniform;  ///< by node: whether the mass of its rays is below smallest_row_energy
};

/// The rows of a slice under one absorption; the table makes and keeps them. Reading: any thread, during a pass.
class ColoredRows {
 public:
  ColoredRows(adaptive::Service& service, std::shared_ptr<const SliceRows> slice, const glm::vec3& sigma_a);

  const SliceRows& slice() const { return *slice_; }
  /// Its answers are AbsorbedRow.
  const adaptive::FormedRows& formed() const { return *formed_; }

  /// Mass per channel of a node's rays: a pure function of the node, whatever the state of its row. It is computed
  /// once.
  glm::vec3 absorbed_mass(std::uint32_t node, const adaptive::TracedNodes& nodes) const;

  /// The memory that the service does not count.
  std::size_t bytes() const { return sizeof(*this) + slice_->node_count * 3 * sizeof(float); }

 private:
  std::shared_ptr<const SliceRows> slice_;
  glm::vec3 sigma_a_;
  const adaptive::FormedRows* formed_;
  std::unique_ptr<std::atomic<float>[]> mass_memo_;  ///< 3 per node, negative while unknown
};

/// Runs for every node in |theta_d|: one whose rows have density 0 and are not in the service, and one without answers.
adaptive::RowRun zero_density_rows();
adaptive::RowRun unanswered_rows();

}  // namespace tress::inline v0_2::fiber
