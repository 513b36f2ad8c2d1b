// What a look-up returns: the answer of one row, and by whom it is counted, taught and credited.
#pragma once

#include <cstdint>
#include <memory>

#include "tress/adaptive/cache.h"
#include "tress/adaptive/knot_density.h"
#include "tress/adaptive/mixture.h"
#include "tress/adaptive/ribbon.h"
#include "tress/adaptive/traced_nodes.h"

namespace tress::adaptive {

using SliceId = std::uint32_t;

/// What a reader sees of a row during one pass. Cheap to copy; valid until publish().
struct RowView {
  RowState state = RowState::absent;
  /// The published fit: for converged rows the answer, for open rows the proposal; null before the first fit, for
  /// converged rows that are answered by knots, and for rows that were asked in a form (row_form.h). Converts to
  /// Mixture.
  const PackedMixture* fit = nullptr;
  /// The answer of a converged row that is a knot table; null for all others. A converged row has one of the two,
  /// whatever the learner of this session: a cache may bring both kinds.
  const KnotDensity* knots = nullptr;
  /// In a slice of samples the answer of a row, whether it is open or has converged, or, where `state` is absent, of
  /// coarser rows around the node; null for all others.
  const RibbonRow* ribbons = nullptr;
  std::uint32_t paths = 0;  ///< that taught `ribbons`; of coarser rows around the node the fewest
  /// g, for every state but converged; null in a slice of samples, where the host draws from its target itself. Null
  /// for converged rows. Owned by the service, or by `kept` past the ceiling.
  const TracedNodes* nodes = nullptr;
  /// Which row: Service::observe(), score() and credit() read these. no_row: it is absent.
  SliceId slice = 0;
  std::uint32_t node = 0;  ///< a * axis_b.size() + b
  std::uint32_t row = no_row;
  /// The pass that it was asked in, by number of publish().
  std::uint32_t pass = 0;
  /// How far the fit is known to be from g, relative squared L2: the bound of the row's last test, once converged the
  /// stored bound; 1 before the first test and for absent rows. Finite, >= 0; above 1 where a fit is worse than none.
  float objective = 1;
  /// Holds nodes or ribbons that the table had no room for.
  std::shared_ptr<const void> kept;

  static constexpr std::uint32_t no_row = ~0u;

  /// What is published, of either kind: the answer of a converged row, the proposal of an open one; uniform if there is
  /// nothing yet. As Mixture::density() and so on.
  float density(float x) const { return knots ? knots->density(x) : fit ? fit->density(x) : 0; }
  float proposal_density(float x, float u_share) const {
    if (knots) return knots->proposal_density(x, u_share);
    return fit ? fit->proposal_density(x, u_share) : Mixture{}.proposal_density(x, u_share);
  }
  float sample(float u, float u_share) const {
    if (knots) return knots->sample(u, u_share);
    return fit ? fit->sample(u, u_share) : Mixture{}.sample(u, u_share);
  }
};

}  // namespace tress::adaptive
