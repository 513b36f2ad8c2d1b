// What the documented rules say of a service (README.md of adaptive/, ESTIMATOR.md E3 and E8, CACHE_FORMAT.md), in the
// plainest form: what is known of each node, what a pass may make of it, and what a cache must then hold. What depends
// on drawn numbers, which fit, which bound, in which pass, is not predicted but held to what the rules allow.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "tress/adaptive/service.h"

namespace tress::inline v0_2::adaptive {

/// For services without a memory ceiling in reach, learner `sketch`. Every method that has the service at hand asserts
/// (RC_ASSERT) that it is as it must be.
class ServiceModel {
 public:
  enum class Ask : std::uint8_t { score, observe, look };  ///< from the row's proposal; from elsewhere; no g given

  ServiceModel(const Options& options, const Target& target) : options_(options), target_(target) {}

  /// In the order of their SliceId.
  void add_slice(const SliceDescription& slice);
  void load(const TableSnapshot& image);
  void set_learning(bool on) { learns_ = on; }
  /// A query; what follows of it.
  void ask(std::size_t slice, std::uint32_t node, Ask how);

  /// After load() or add_slice(): what came from a cache, before anything was asked.
  void check_loaded(const Service& service);
  void check_pass(const Service& service, const PassReport& report);
  /// Of a session that may have loaded.
  void check_saved(const Service& service);

 private:
  /// What answers for a row, or proposes.
  struct Answer {
    RowState state = RowState::absent;
    std::optional<Mixture> fit;
    float objective = 1;
  };
  struct Node {
    std::uint32_t queries = 0;           ///< over all passes
    std::uint32_t asked = 0, given = 0;  ///< in this pass; g given while it was open and learning
    Answer answer;                       ///< as of the last publish() or load()
    std::optional<CachedRow> cached;     ///< what a cache brought
    bool open_in_cache = false;          ///< it came open, or coarser than epsilon
    std::uint32_t tests_since_open = 0;  ///< the most that it can have had
    std::uint32_t tests = 0;             ///< likewise, in this session
    std::uint64_t reopened = 0;          ///< by audits
  };
  struct Slice {
    SliceDescription description;
    std::vector<Node> nodes;
  };

  static Answer answer_of(const Service& service, std::size_t slice, std::uint32_t node);
  static bool same(const Answer& a, const Answer& b);
  void take(std::size_t slice);
  bool answers(const CachedRow& row) const {
    return row.state == RowState::converged && row.objective <= options_.epsilon;
  }
  TracedNodes trace(std::size_t slice, std::uint32_t node) const;
  void check_change(Node& node, const Answer& now);
  void check_row(const Slice& slice, std::size_t index, const CachedRow& row);

  Options options_;
  const Target& target_;
  std::vector<Slice> slices_;
  std::map<SliceKey, CachedSlice> cached_;  ///< of slices that are not added yet
  bool learns_ = true, has_loaded_ = false;
  std::uint64_t g_evaluations_ = 0;  ///< counted by all reports
  std::uint64_t traces_of_loading_ = 0;
  std::uint64_t last_reopened_ = 0;
};

}  // namespace tress::inline v0_2::adaptive
