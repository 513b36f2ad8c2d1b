// The flat index of a slice: one slot per node, found by arithmetic without a hash.
#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "observations/heard_exits.h"
#include "table/coarse_grid.h"
#include "tress/adaptive/cache.h"
#include "tress/adaptive/mixture.h"
#include "tress/adaptive/target.h"
#include "tress/adaptive/traced_nodes.h"

namespace tress::inline v0_2::adaptive {

struct Learning;

/// The answer of a row of a slice of samples, or of a node that coarser rows answer for.
struct alignas(16) RibbonAnswer {
  RibbonRow row;
  float objective;      ///< bound of its last test, as RowView::objective; if interpolated, the largest of its parents
  std::uint32_t paths;  ///< number from which it was learned; if interpolated, the smallest of its parents
  bool has_converged;   ///< whether it has passed its test
};

/// One node and its answer.
struct alignas(16) Slot {
  static constexpr std::uint32_t no_row = ~0u;
  /// What the word points to. It is in the lowest two bits of the word or, if both are set, in the lowest four.
  enum class Kind : std::uintptr_t {
    traced = 0,         ///< TracedNodes of an absent node, of this pass, owned; or null
    learning = 1,       ///< Learning of an open or refused row
    mixture = 2,        ///< PackedMixture of a converged row
    ribbons = 7,        ///< RibbonAnswer of a row of samples, owned
    refusal = 11,       ///< null: a row of samples whose target drew exits that SampledTarget does not allow
    interpolated = 15,  ///< RibbonAnswer of a node without a row, made by readers of coarser rows, owned
  };

  std::atomic<std::uint32_t> queries{0};  ///< look-ups over all passes (modulo 2^32)
  std::uint32_t row = no_row;             ///< index into the table's rows; changes between passes
  std::atomic<std::uintptr_t> word{0};

  static Kind kind_of(std::uintptr_t word) {
    const std::uintptr_t low = word & 3;
    return static_cast<Kind>(low != 3 ? low : word & 15);
  }
  /// The bits of the word that hold the kind of a T.
  template <class T>
  static constexpr std::uintptr_t kind_bits = alignof(T) >= 16 ? 15 : 3;
  template <class T>
  static const T* target_of(std::uintptr_t word) {
    return reinterpret_cast<const T*>(word & ~kind_bits<T>);
  }
  template <class T>
  static std::uintptr_t word_of(const T* target, Kind kind) {
    return reinterpret_cast<std::uintptr_t>(target) | static_cast<std::uintptr_t>(kind);
  }

  /// Returns null if the word is of another kind. Call it between passes.
  template <class T>
  const T* get(Kind kind) const {
    const std::uintptr_t now = word.load(std::memory_order_relaxed);
    return kind_of(now) == kind ? target_of<T>(now) : nullptr;
  }
  const PackedMixture* mixture() const { return get<PackedMixture>(Kind::mixture); }
  const RibbonAnswer* ribbons() const { return get<RibbonAnswer>(Kind::ribbons); }
  bool is_refused() const { return kind_of(word.load(std::memory_order_relaxed)) == Kind::refusal; }
  const RibbonAnswer* interpolated() const { return get<RibbonAnswer>(Kind::interpolated); }
  /// Whether a row answers without evaluating g.
  bool has_answer() const {
    const Kind kind = kind_of(word.load(std::memory_order_relaxed));
    return kind == Kind::mixture || kind == Kind::ribbons;
  }
  /// Bytes of the answer of a row; 0 for a Learning.
  std::size_t answer_bytes() const {
    if (const PackedMixture* fit = mixture()) return fit->bytes();
    return ribbons() != nullptr ? sizeof(RibbonAnswer) : 0;
  }

  /// Replaces the answer, and deletes the old one if it was owned. Call it between passes.
  template <class T>
  void set(const T* target, Kind kind) {
    delete ribbons();
    delete interpolated();
    delete get<TracedNodes>(Kind::traced);
    word.store(word_of(target, kind), std::memory_order_relaxed);
  }
  /// Puts what was made into an empty slot, unless another thread was first with the same values. Returns what is there
  /// then, and whether it was this.
  template <class T>
  std::pair<const T*, bool> put_first(std::unique_ptr<const T> made, Kind kind) {
    std::uintptr_t seen = 0;
    if (!word.compare_exchange_strong(seen, word_of(made.get(), kind), std::memory_order_acq_rel,
                                      std::memory_order_acquire))
      return {target_of<T>(seen), false};
    return {made.release(), true};
  }
  /// Hands over the traced nodes that an absent node has kept, or null.
  std::unique_ptr<const TracedNodes> take_memo() {
    std::unique_ptr<const TracedNodes> memo(get<TracedNodes>(Kind::traced));
    if (memo) word.store(0, std::memory_order_relaxed);
    return memo;
  }
};
static_assert(sizeof(Slot) == 16);

struct Slice {
  /// has_index: false if memory has no room for one. The nodes are then traced at every query and never learned.
  /// parts_of_node: SampledTarget::parts() of a slice of samples, else 0.
  Slice(const SliceDescription& d, bool has_index, std::uint32_t parts_of_node)
      : description(d), parts(parts_of_node), grid(d) {
    if (!has_index) return;
    slots = std::make_unique<Slot[]>(d.node_count());
    light = std::make_unique<std::atomic<std::uint64_t>[]>(d.node_count());
    events = std::make_unique<std::atomic<std::uint32_t>[]>(d.node_count());
    formed = std::make_unique<std::atomic<std::uint8_t>[]>(d.node_count());
    queries_before.resize(d.node_count(), 0);
  }
  ~Slice() {
    if (!has_index()) return;
    for (std::uint32_t n = 0; n < description.node_count(); ++n) slots[n].set<TracedNodes>(nullptr, Slot::Kind::traced);
  }
  Slice(const Slice&) = delete;
  Slice& operator=(const Slice&) = delete;

  bool has_index() const { return slots != nullptr; }
  static std::size_t index_bytes(const SliceDescription& d) {
    return d.node_count() * (sizeof(Slot) + sizeof(std::uint64_t) + 2 * sizeof(std::uint32_t) + sizeof(std::uint8_t));
  }

  /// Adds a decay rate of a form. Ignores rates that are not finite or not above 0.
  void add_rate(float rate) {
    if (!std::isfinite(rate) || !(rate > 0)) return;
    const auto at = std::ranges::lower_bound(decay_rates, rate);
    if (at == decay_rates.end() || *at != rate) decay_rates.insert(at, rate);
  }

  /// The coordinates of a node.
  float a_of(std::uint32_t node) const { return description.axis_a[node / description.axis_b.size()]; }
  float b_of(std::uint32_t node) const { return description.axis_b[node % description.axis_b.size()]; }
  /// Light that a node has carried over all passes, as fixed_light(); 0 without an index.
  std::uint64_t light_at(std::uint32_t node) const { return light ? light[node].load(std::memory_order_relaxed) : 0; }
  /// Number of draws from a node of samples over all passes: its credited events or its queries, whichever is more.
  std::uint64_t asked(std::uint32_t node) const {
    return std::max(events[node].load(std::memory_order_relaxed), slots[node].queries.load(std::memory_order_relaxed));
  }

  SliceDescription description;
  std::uint32_t parts;  ///< of each node of samples
  CoarseGrid grid;
  Slice* coarse_rows = nullptr;           ///< the slice whose coarse rows answer for this one; null: it has its own
  std::vector<const Slice*> answers_for;  ///< the slices whose coarse_rows is this one; they have an index
  std::unique_ptr<Slot[]> slots;          ///< null without an index, as are the next three
  /// Light carried by each node over all passes, as fixed_light(). It is apart from the slots because converged rows
  /// still add to it.
  std::unique_ptr<std::atomic<std::uint64_t>[]> light;
  /// Events credited to each node over all passes.
  std::unique_ptr<std::atomic<std::uint32_t>[]> events;
  /// By node: 1 if a form made its answer since the last publish().
  std::unique_ptr<std::atomic<std::uint8_t>[]> formed;
  std::vector<std::uint32_t> interpolated;    ///< nodes whose slots hold an interpolated answer, in order of insertion
  std::vector<std::uint32_t> queries_before;  ///< queries at the last publish()
  std::vector<std::uint32_t> forms;           ///< indices of its forms in the table
  std::vector<float> decay_rates;             ///< rates of its forms, ascending, distinct
  bool audited = false;                       ///< whether a row of a cache was checked
  HeardExits heard;                           ///< paths of the host, for slices of samples
  std::map<std::uint32_t, CachedRow> stored;  ///< cached rows that have no row in the table, by node
};

}  // namespace tress::inline v0_2::adaptive
