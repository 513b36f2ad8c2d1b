// The flat index of a page: one slot per node, found by arithmetic, never by a hash.
#pragma once

#include <atomic>
#include <bit>
#include <compare>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "tress/adaptive/cache.h"
#include "tress/adaptive/target.h"
#include "tress/adaptive/traced_nodes.h"

namespace tress::adaptive {

/// Order of pages by the bits of their keys: total, and the same on every machine.
inline std::strong_ordering compare_keys(const PageKey& a, const PageKey& b) {
  if (const auto order = a.lobe <=> b.lobe; order != 0) return order;
  for (std::size_t i = 0; i < a.parameters.size(); ++i) {
    const auto order = std::bit_cast<std::uint32_t>(a.parameters[i]) <=> std::bit_cast<std::uint32_t>(b.parameters[i]);
    if (order != 0) return order;
  }
  return std::strong_ordering::equal;
}

struct KeyLess {
  bool operator()(const PageKey& a, const PageKey& b) const { return compare_keys(a, b) < 0; }
};

/// A node, and all that a look-up reads: half a cache line. Of a row that is born it repeats what the row publishes.
struct alignas(32) Slot {
  static constexpr std::uint32_t no_row = ~0u;
  std::atomic<std::uint32_t> touches{0};           ///< look-ups over all passes (modulo 2^32)
  std::uint32_t row = no_row;                      ///< index into the table's rows; changes between passes
  std::atomic<const TracedNodes*> nodes{nullptr};  ///< the row's; unborn: this pass's trace, owned
  const void* answer = nullptr;                    ///< the row's Mixture, or KnotTable; null before the first fit
  float objective = 1;
  RowState state = RowState::unborn;
  bool is_knots = false;  ///< what `answer` is

  /// Of an unborn node.
  std::unique_ptr<const TracedNodes> take_memo() {
    return std::unique_ptr<const TracedNodes>(nodes.exchange(nullptr, std::memory_order_relaxed));
  }
};
static_assert(sizeof(Slot) == 32);

struct Page {
  explicit Page(const PageDescription& d)
      : description(d), slots(std::make_unique<Slot[]>(d.node_count())), touches_before(d.node_count(), 0) {}
  ~Page() {
    for (std::uint32_t n = 0; n < description.node_count(); ++n) {
      if (slots[n].row == Slot::no_row) slots[n].take_memo();
    }
  }
  Page(const Page&) = delete;
  Page& operator=(const Page&) = delete;

  PageDescription description;
  std::unique_ptr<Slot[]> slots;
  std::vector<std::uint32_t> touches_before;   ///< touches at the last publish()
  bool audited = false;                        ///< a row of a cache was checked
  std::map<std::uint32_t, CachedRow> dormant;  ///< cached rows that memory had no room for, by node
};

}  // namespace tress::adaptive
