// The life of a row in the plainest words (README.md and ESTIMATOR.md E3 of adaptive/): one thread, maps, no memory
// ceiling, learner `sketch`. What a service is compared with, to the bit. Sketches, fits and traced nodes are the
// library's, with properties of their own; creations, tests, convergence, audits and reopening are written anew.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <tuple>
#include <vector>

#include "observations/sketch.h"
#include "tress/adaptive/cache.h"
#include "tress/adaptive/options.h"
#include "tress/adaptive/target.h"
#include "tress/adaptive/telemetry.h"
#include "tress/adaptive/traced_nodes.h"
#include "tress/base/random.h"

namespace tress::adaptive {

class ServiceModel {
 public:
  enum class Ask : std::uint8_t { score, observe, look };  ///< from the row's proposal; from elsewhere; no g told

  ServiceModel(const Options& options, const Target& target) : options_(options), target_(target) {}

  void add_slice(const SliceDescription& slice);
  void load(const TableSnapshot& image);
  void set_learning(bool on) { learns_ = on; }
  /// A query, its azimuth at u of what it is drawn from.
  void ask(std::size_t slice, std::uint32_t node, Ask how, float u);
  void carry(std::size_t slice, std::uint32_t node, float light);
  /// What it leaves at 0 of a report is not part of the model.
  PassReport publish();
  TableSnapshot snapshot() const;

  /// Slice, node, state of what changed in the last publish() or load().
  using Change = std::tuple<std::size_t, std::uint32_t, RowState>;
  const std::vector<Change>& changes() const { return changes_; }
  RowState state(std::size_t slice, std::uint32_t node) const;
  /// What is published of a row, as a cache would store it; empty before the first fit and of knots.
  std::optional<Mixture> published(std::size_t slice, std::uint32_t node) const;
  /// RowView::objective.
  float objective(std::size_t slice, std::uint32_t node) const;

 private:
  /// Mean and standard error of scores in [0, 4] in steps of 2^-38, as integers.
  struct Scores {
    std::vector<std::uint64_t> fixed;
    void add(double residual, double q, double variation);
    double mean() const;
    double standard_error() const;
  };
  struct Row {
    RowState state = RowState::open;
    std::uint32_t generation = 0, failed = 0;
    std::uint64_t count = 0;
    float energy = 0, objective = -1;
    Mixture fit;
    bool has_fit = false;
    KnotDensity knots;        ///< of a converged row that a cache brought so
    std::uint64_t order = 0;  ///< of creation
    bool audit_due = false, audit_possible = false;
    // While open:
    std::shared_ptr<const TracedNodes> nodes;
    std::shared_ptr<Sketch> sketch;
    Scores scores;
    std::uint32_t passed = 0;
    float largest_passed = 0, bound = -1;
    bool last_failed = false, overruled = false;
    std::uint64_t observed = 0, count_at_fit = 0;
    std::uint32_t bins_at_fit = 0, created_pass = 0, queries_at_creation = 0;
    std::optional<CachedRow> earlier;
  };
  struct Node {
    std::uint32_t queries = 0, queries_before = 0;
    std::uint64_t light = 0;
    std::optional<Row> row;
    bool traced = false;  ///< in this pass
  };
  struct Slice {
    SliceDescription description;
    std::map<std::uint32_t, Node> nodes;  ///< all of them
    bool audited = false;
  };
  struct Place {
    std::size_t slice;
    std::uint32_t node;
  };

  Node& at(Place place) { return slices_[place.slice].nodes.at(place.node); }
  std::vector<Place> rows_by_birth();
  RandomStream stream(Place place, std::uint64_t purpose) const;
  std::shared_ptr<const TracedNodes> trace(Place place) const;
  void open(Place place, Row& row, std::shared_ptr<const TracedNodes> nodes);
  void begin(Row& row, const SliceDescription& slice, PassReport& report);
  void cover(Row& row, PassReport& report);
  bool refit(Row& row, const SliceDescription& slice, PassReport& report);
  void offer(Row& row, float x, float g);
  bool test(Row& row, PassReport& report);
  /// The most that the error of the fit can be, from the steps of the variation and, if need be, from those between.
  double largest_error(Row& row, PassReport& report);
  void refine(Row& row, PassReport& report);
  void ask_g(Row& row, float x, PassReport& report);
  void update(Place place, PassReport& report);
  bool audit(Place place, PassReport& report);
  void reopen(Place place, PassReport& report);
  void take(Place place, const CachedRow& cached);
  void resume(const std::vector<std::pair<Place, CachedRow>>& rows);

  Options options_;
  const Target& target_;
  std::vector<Slice> slices_;
  std::map<SliceKey, CachedSlice> unused_;
  std::vector<Change> changes_;
  PassReport before_;  ///< of what was done between passes
  std::uint32_t pass_ = 0;
  std::uint64_t births_ = 0, reopened_ = 0;
  bool learns_ = true;
};

}  // namespace tress::adaptive
