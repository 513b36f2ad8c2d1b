// Random rows, learned through the public service as a render asks it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "random_rows.h"
#include "tress/adaptive/service.h"
#include "tress/base/random.h"

namespace tress::bench {

/// Rows of one service, each on a slice of its own, asked some vertices a pass until they converge. One thread.
class LearnedRows {
 public:
  struct Row {
    adaptive::SliceId slice = 0;
    std::uint64_t own = 0, vertices = 0;  ///< samples scored and look-ups made before it converged
    adaptive::RowState state = adaptive::RowState::absent;
  };

  /// `target` must outlive it; no two descriptions have one key.
  LearnedRows(const adaptive::Options& options, const adaptive::Target& target,
              const std::vector<adaptive::SliceDescription>& slices)
      : service_(options, target) {
    for (const auto& slice : slices) rows_.push_back({*service_.add_slice(slice), 0, 0, adaptive::RowState::absent});
  }

  /// `vertices` look-ups of each row that has not converged, each with one azimuth drawn from the row's own proposal;
  /// then publish().
  adaptive::PassReport pass(int vertices) {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      RandomStream random(service_.options().seed, i, ++passes_);
      if (rows_[i].state != adaptive::RowState::converged) ask(rows_[i], vertices, random);
    }
    const adaptive::PassReport report = service_.publish();
    for (Row& row : rows_) row.state = service_.peek(row.slice, 0, 0).state;
    return report;
  }

  const std::vector<Row>& rows() const { return rows_; }
  /// The published fit of a row, if it has one.
  adaptive::RowView view(std::size_t i) const { return service_.peek(rows_[i].slice, 0, 0); }
  const adaptive::Service& service() const { return service_; }

 private:
  void ask(Row& row, int vertices, RandomStream& random) {
    const float share = service_.options().uniform_share_open;
    for (int i = 0; i < vertices; ++i) {
      const adaptive::RowView view = service_.look_up(row.slice, 0, 0);
      ++row.vertices;
      if (view.state != adaptive::RowState::open || view.fit == nullptr) continue;
      const float x = view.fit->sample(random.next(), share);
      service_.score(view, x, view.nodes->density(x), view.fit->proposal_density(x, share));
      ++row.own;
    }
  }

  adaptive::Service service_;
  std::vector<Row> rows_;
  std::uint64_t passes_ = 0;
};

}  // namespace tress::bench
