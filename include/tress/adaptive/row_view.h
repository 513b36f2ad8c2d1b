// The result of a look-up: the answer of one row, and its identity for calls that observe, score or credit it.
#pragma once

#include <cstdint>
#include <memory>

#include "tress/adaptive/cache.h"
#include "tress/adaptive/mixture.h"
#include "tress/adaptive/ribbon.h"
#include "tress/adaptive/traced_nodes.h"

namespace tress::inline v0_2::adaptive {

using SliceId = std::uint32_t;

/// What a reader sees of a row during one pass. Cheap to copy; valid until publish().
struct RowView {
  RowState state = RowState::absent;
  /// The published fit: the answer of a converged row, the proposal of an open one. Null before the first fit and for
  /// rows that were looked up in a form (row_form.h). Converts to Mixture.
  const PackedMixture* fit = nullptr;
  /// In a slice of samples, the answer of a row, open or converged, or, if `state` is absent, of coarser rows around
  /// the node. Null for all others.
  const RibbonRow* ribbons = nullptr;
  std::uint32_t paths = 0;  ///< number of paths of `ribbons`; for coarser rows around the node, the smallest
  /// g, for every state except converged. Null for converged rows, and in a slice of samples, where the host draws from
  /// its target itself. Owned by the service, or by `kept` beyond the memory limit.
  const TracedNodes* nodes = nullptr;
  /// The row's identity, which Service::observe(), score() and credit() read. no_row: it is absent.
  SliceId slice = 0;
  std::uint32_t node = 0;  ///< a * axis_b.size() + b; no_node: there is no such slice or node
  std::uint32_t row = no_row;
  /// The pass in which it was looked up, by number of publish().
  std::uint32_t pass = 0;
  /// The known error of the fit against g, relative squared L2: the bound of the row's last test, or, once converged,
  /// the stored bound; 1 before the first test and for absent rows. Finite, >= 0; above 1 if a fit is worse than a
  /// uniform one.
  float objective = 1;
  /// Owns nodes or ribbons that the table had no room for.
  std::shared_ptr<const void> kept;

  static constexpr std::uint32_t no_row = ~0u, no_node = ~0u;

  /// The functions of Mixture for the published fit. Uniform if nothing is published yet.
  float density(float x) const { return fit ? fit->density(x) : 0; }
  float proposal_density(float x, float u_share) const {
    return fit ? fit->proposal_density(x, u_share) : Mixture{}.proposal_density(x, u_share);
  }
  float sample(float u, float u_share) const { return fit ? fit->sample(u, u_share) : Mixture{}.sample(u, u_share); }
};

}  // namespace tress::inline v0_2::adaptive
