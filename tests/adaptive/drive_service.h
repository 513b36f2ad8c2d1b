// A host for tests: asks a service a fixed list of queries, from any number of threads, in any order.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <thread>
#include <vector>

#include "support/seed.h"
#include "tress/adaptive/service.h"
#include "tress/base/random.h"

namespace tress::testing {

/// Query `index` of a pass: a pure function of its numbers and of the published table. Nodes near 0 are asked more.
/// Every fourth query of an open row is a foreign one (uniform, observed and not scored). Returns the value seen.
inline float ask(const adaptive::Service& service, std::uint32_t slices, std::uint64_t pass, std::uint64_t index) {
  using namespace adaptive;
  RandomStream random(test::seed(77), pass, index);
  const auto slice = static_cast<SliceId>(random.next() * static_cast<float>(slices));
  const SliceDescription& d = service.slice(slice);
  const float s = random.next(), t = random.next();
  const auto a = static_cast<std::uint32_t>(s * s * static_cast<float>(d.axis_a.size()));
  const auto b = static_cast<std::uint32_t>(t * static_cast<float>(d.axis_b.size()));
  const RowView row = service.look_up(slice, a, b);
  const bool foreign = index % 4 == 3;
  const RowView flat;
  const RowView& proposal = foreign ? flat : row;
  const float u = row.state == RowState::converged ? service.options().uniform_share_converged
                                                   : service.options().uniform_share_open;
  const float x = proposal.sample(random.next(), u);
  if (row.state == RowState::converged) return row.density(x);
  const float g = row.nodes->density(x);
  if (foreign) {
    service.observe(row, x, g);
  } else {
    service.score(row, x, g, proposal.proposal_density(x, u));
  }
  return g;
}

/// One pass of `queries` queries over the first `slices` slices, shuffled and dealt out to `threads` threads.
inline void run_pass(const adaptive::Service& service, std::uint32_t slices, std::uint64_t pass, std::size_t queries,
                     unsigned threads) {
  std::vector<std::uint64_t> order(queries);
  std::iota(order.begin(), order.end(), 0);
  RandomStream random(threads, pass);
  for (std::size_t i = queries; i > 1 && threads > 1; --i) std::swap(order[i - 1], order[random.next_bits() % i]);
  std::vector<std::thread> workers;
  for (unsigned w = 0; w < threads; ++w) {
    workers.emplace_back([&, w] {
      for (std::size_t i = w; i < queries; i += threads) ask(service, slices, pass, order[i]);
    });
  }
  for (std::thread& worker : workers) worker.join();
}

}  // namespace tress::testing
