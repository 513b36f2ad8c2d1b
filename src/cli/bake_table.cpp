#include "cli/bake_table.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <vector>

#include "tress/base/random.h"

namespace tress::cli {
namespace {

using adaptive::RowState;
using adaptive::RowView;
using adaptive::Service;
using Clock = std::chrono::steady_clock;

constexpr std::uint64_t baking_stream = 0x70726562616b65ull;
constexpr std::size_t nodes_at_once = 8192;  // open rows take 10 to 30 KB each
constexpr int most_passes = 4096;            // over one group; a row is refused long before

struct Node {
  adaptive::SliceId slice;
  std::uint32_t a, b;
};

RowView look(const Service& service, const Node& node) { return service.peek(node.slice, node.a, node.b); }

/// Whether baking cannot improve the row: one of samples is learned to its end at its first query.
bool is_decided(const RowView& row) {
  return row.state == RowState::converged || row.state == RowState::refused ||
         (row.ribbons != nullptr && row.row != RowView::no_row);
}

void ask(const Service& service, const Node& node, std::uint64_t pass) {
  const adaptive::Options& options = service.options();
  const float share = options.uniform_share_open;
  RandomStream random(options.seed ^ baking_stream,
                      std::uint64_t{node.slice} << 40 ^ std::uint64_t{node.a} << 20 ^ std::uint64_t{node.b}, pass);
  for (std::uint32_t i = 0; i < options.scores_per_test(); ++i) {
    const RowView row = service.look_up(node.slice, node.a, node.b);
    if (row.state != RowState::open || row.fit == nullptr) return;
    const float x = row.fit->sample(random.next(), share);
    service.score(row, x, row.nodes->density(x), row.fit->proposal_density(x, share));
  }
}

/// Takes the nodes of slices from `first` on, as many slices as make nodes_at_once; returns the slice after them.
adaptive::SliceId take_slices(const Service& service, adaptive::SliceId first, std::vector<Node>& nodes) {
  adaptive::SliceId slice = first;
  for (; slice < service.slice_count() && (nodes.empty() || nodes.size() < nodes_at_once); ++slice) {
    const adaptive::SliceDescription& description = service.slice(slice);
    for (std::uint32_t a = 0; a < description.axis_a.size(); ++a) {
      for (std::uint32_t b = 0; b < description.axis_b.size(); ++b) nodes.push_back({slice, a, b});
    }
  }
  return slice;
}

}  // namespace

adaptive::Options baking(adaptive::Options options) {
  options.queries_before_creation = 1;
  options.learns_to_epsilon = true;
  return options;
}

BakeProgress bake_table(Service& service, const std::function<bool(const BakeProgress&)>& on_pass) {
  BakeProgress progress;
  for (adaptive::SliceId p = 0; p < service.slice_count(); ++p) progress.nodes += service.slice(p).node_count();
  std::vector<Node> open;
  for (adaptive::SliceId slice = 0; slice < service.slice_count();) {
    open.clear();
    slice = take_slices(service, slice, open);
    std::size_t asked = open.size();  // the first of them: with little memory, tracing more absent nodes is wasted
    for (std::uint64_t pass = 0; pass < most_passes && !open.empty(); ++pass) {
      const Clock::time_point start = Clock::now();
      tbb::parallel_for(std::size_t{0}, std::min(asked, open.size()),
                        [&](std::size_t i) { ask(service, open[i], pass); });
      progress.last = service.publish();
      ++progress.passes;
      progress.g_evaluations += progress.last.g_evaluations;
      std::erase_if(open, [&](const Node& node) { return is_decided(look(service, node)); });
      progress.converged = progress.last.rows_converged;
      progress.refused = progress.last.rows_refused;
      progress.seconds = std::chrono::duration<double>(Clock::now() - start).count();
      if (!on_pass(progress)) return progress;
      asked = progress.last.at_ceiling ? std::size_t(progress.last.rows_open) + 64 : 2 * asked;
      // Every row that had room is decided; the others will find no room.
      if (progress.last.at_ceiling && progress.last.rows_open == 0 && progress.last.creations == 0) break;
    }
  }
  return progress;
}

}  // namespace tress::cli
