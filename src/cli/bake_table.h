// Learns a whole table without rendering: every node of every slice is queried until its row is decided.
#pragma once

#include <cstdint>
#include <functional>

#include "tress/adaptive/service.h"

namespace tress::cli {

struct BakeProgress {
  std::uint64_t nodes = 0;      ///< number of nodes of all slices
  std::uint64_t converged = 0;  ///< rows of these nodes
  std::uint64_t refused = 0;
  std::uint64_t passes = 0;
  std::uint64_t g_evaluations = 0;  ///< by the learners, by queries here, and by the tests
  adaptive::PassReport last;
  double seconds = 0;  ///< wall time of the last pass

  std::uint64_t decided() const { return converged + refused; }
};

/// The options for baking a table: rows are created at the first query.
adaptive::Options baking(adaptive::Options options);

/// Queries every node, a few slices at a time, so that few rows are open at once. A pass brings an open row as many
/// draws from its own proposal as a test needs. Parallel inside (oneTBB), with the same table for any number of
/// threads. It ends when every row has converged or is refused, when memory allows no more rows, or after 4096 passes
/// over one group of slices. It also ends when `on_pass`, which is called after each pass, returns false.
BakeProgress bake_table(adaptive::Service& service, const std::function<bool(const BakeProgress&)>& on_pass);

}  // namespace tress::cli
