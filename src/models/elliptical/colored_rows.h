// The rows of a slice, and the same as one color sees them.
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

namespace tress::fiber {

/// Where the rays of a node have less mass, its light is spread uniformly over the azimuth, without a row.
constexpr float smallest_row_energy = 1e-3f;

/// One slice, for all fibers and colors that have it. Immutable.
struct SliceRows {
  /// Traces every node once: some milliseconds. The service has no other host of the key.
  SliceRows(adaptive::Service& service, const adaptive::SliceDescription& description);

  adaptive::SliceId slice;
  RowGrid grid;
  std::uint32_t width;  ///< nodes of axis_b
  std::uint32_t node_count;
  std::vector<bool> uniform;  ///< by node: mass of its rays below smallest_row_energy
};

/// The rows of a slice under one absorption: the table makes and keeps them. Reading: any thread, during a pass.
class ColoredRows {
 public:
  ColoredRows(adaptive::Service& service, std::shared_ptr<const SliceRows> slice, const glm::vec3& sigma_a);

  const SliceRows& slice() const { return *slice_; }
  /// Answers are AbsorbedRow.
  const adaptive::FormedRows& formed() const { return *formed_; }

  /// Mass per channel of a node's rays: a pure function of the node, whatever its row has become, remembered.
  glm::vec3 absorbed_mass(std::uint32_t node, const adaptive::TracedNodes& nodes) const;

  /// Without what the service counts.
  std::size_t bytes() const { return sizeof(*this) + slice_->node_count * 3 * sizeof(float); }

 private:
  std::shared_ptr<const SliceRows> slice_;
  glm::vec3 sigma_a_;
  const adaptive::FormedRows* formed_;
  std::unique_ptr<std::atomic<float>[]> mass_memo_;  ///< 3 per node, negative while unknown
};

/// Runs for every node in |theta_d|: of a row of density 0 that the service does not have, and without answers.
adaptive::RowRun zero_density_rows();
adaptive::RowRun unanswered_rows();

}  // namespace tress::fiber
