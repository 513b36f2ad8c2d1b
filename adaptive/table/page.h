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

/// A node. 16 bytes.
struct Slot {
  static constexpr std::uint32_t no_row = ~0u;
  std::atomic<std::uint32_t> touches{0};          ///< look-ups over all passes (modulo 2^32)
  std::uint32_t row = no_row;                     ///< index into the table's rows; changes between passes
  std::atomic<const TracedNodes*> memo{nullptr};  ///< trace of an unborn node, owned, for this pass
};

struct Page {
  explicit Page(const PageDescription& d)
      : description(d), slots(std::make_unique<Slot[]>(d.node_count())), touches_before(d.node_count(), 0) {}
  ~Page() {
    for (std::uint32_t n = 0; n < description.node_count(); ++n) delete slots[n].memo.load(std::memory_order_relaxed);
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
