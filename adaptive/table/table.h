// The state behind Service and the steps of a publish() (README.md, the life of a row).
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "cache/packed_slice.h"
#include "table/density_life.h"
#include "table/discipline.h"
#include "table/error_quantiles.h"
#include "table/form_store.h"
#include "table/guarded_targets.h"
#include "table/light_policy.h"
#include "table/row_outcome.h"
#include "table/rows.h"
#include "table/sample_life.h"
#include "table/striped_counter.h"
#include "tress/adaptive/service.h"

namespace tress::inline v0_2::adaptive {

struct SavedSlice;  // state.cpp

/// Any thread may call the reader methods: look_up, fetch, count_formed, observe, score, credit, hear. All others need
/// one thread and no reader.
class Service::Table {
 public:
  /// Either target may be null; there are then no slices of its kind.
  Table(const Options& options, const Target* target, const SampledTarget* samples)
      : options_(options),
        unusable_(make_usable(options_)),
        target_(guard<GuardedTarget>(target)),
        samples_(guard<GuardedSamples>(samples)),
        learner_bytes_(options_.learner->make()->bytes()),
        light_(options_),
        discipline_(options_.check_passes) {
    for (const Error& option : unusable_) log("Options::" + option.message());
    if (const std::string name = model_name(); !is_model_name(name))
      log("model_name: expected 1 to 256 printable ASCII characters, so that a cache can be saved, found " + name);
  }
  ~Table() { report_memory(0); }
  Table(const Table&) = delete;
  Table& operator=(const Table&) = delete;

  // service.cpp: calls of readers
  RowView look_up(SliceId slice, std::uint32_t a, std::uint32_t b);
  RowView peek(SliceId slice, std::uint32_t a, std::uint32_t b);
  double light(SliceId slice, std::uint32_t a, std::uint32_t b) const;
  std::uint32_t queries(SliceId slice, std::uint32_t a, std::uint32_t b) const;
  void credit(const RowView& view, float light, std::uint32_t events);
  void hear(const RowView& view, const SampledExit& exit);
  void observe(const RowView& view, float x, float g);
  void score(const RowView& view, float x, float g, float q);

  // forms.cpp
  Result<const FormedRows*> add_form(SliceId slice, std::shared_ptr<const RowForm> form,
                                     const std::vector<float>& decay_rates);
  FormedLookup look_up(const FormedRows& rows, std::uint32_t node);
  FormedLookup fetch(const FormedRows& rows, std::uint32_t node);
  /// Counts queries that were answered without look_up() or fetch(). converged: how many of them by converged rows.
  void count_formed(std::uint32_t queries, std::uint32_t converged) {
    answered_queries_.add(queries);
    converged_queries_.add(converged);
  }

  // snapshot.cpp
  Result<SliceId> add_slice(const SliceDescription& description);
  void prepare();
  std::optional<Error> load(RowSource& rows);
  std::unique_ptr<RowSource> rows() const;
  TableSnapshot snapshot() const;

  // state.cpp
  Result<std::string> state() const;
  std::optional<Error> restore(const std::string& state);

  // publish.cpp
  PassReport publish(std::uint64_t paths);
  /// Ends a call between passes for Options::memory_monitor: reports what it has not been asked for.
  void report_memory() { report_memory(bytes_ + formed_bytes_); }
  bool publish_pays(double share) const;

  // heard_test.cpp
  HeardTest test_by_heard();

  const Options& options() const { return options_; }
  std::string model_name() const { return target_ != nullptr ? target_->model_name() : samples_->model_name(); }
  bool has_target(SliceKind kind) const {
    return kind == SliceKind::samples ? samples_ != nullptr : target_ != nullptr;
  }
  const Rows& all() const { return rows_; }
  const std::vector<Error>& refusals() const { return refusals_; }
  void set_learning(bool on) { learns_ = on; }
  void set_listener(std::function<void(const RowReport&)> listener) { listener_ = std::move(listener); }

 private:
  class AllRows;
  /// A row whose published fit or state changed.
  struct RowChange {
    SliceId slice;
    std::uint32_t node;
  };
  static constexpr std::uint32_t no_node = RowView::no_node;
  /// The part of a publish() that rows of densities count as, if there are new ones, for Options::progress.
  static constexpr double share_of_densities = 0.5;

  /// A node that is to get a row, because it was queried often enough or because a cache has one.
  struct Candidate {
    SliceId slice;
    std::uint32_t node;
    std::uint32_t queries;
    std::uint64_t light;
    std::unique_ptr<const TracedNodes> nodes;
  };
  /// The answer of a node of samples. It has an owner only if the table had no room for it.
  using SampledAnswer = std::shared_ptr<const RibbonAnswer>;
  static SampledAnswer without_owner(const RibbonAnswer* answer) { return {std::shared_ptr<void>(), answer}; }

  // creation.cpp
  /// Makes rows of the candidates, in their order, until memory is full. Appends to changes_. True if all had room.
  bool admit(std::vector<Candidate>& candidates, PassReport& report);
  /// Fills a new row from the cache, if that has a row that may answer; otherwise opens it.
  RowOutcome settle(Row& row) const;
  std::size_t bytes_needed(const Candidate& candidate) const;
  bool needs_nodes(const Candidate& candidate) const;
  /// Whether a cached row is used as it is: every converged row of samples, and rows of densities whose error is small
  /// enough for the light of their node.
  bool answers(SliceId slice, const CachedRow& cached) const;

  // sampled_rows.cpp
  /// Brings every row of samples to the stage that its events call for, coarse rows before finer ones.
  /// done: the share of the pass's work before it, for goes_on().
  void grow_samples(PassReport& report, double done);
  /// Lets them grow, while memory lasts. moved: set for every node whose answer has changed.
  void grow_rows(SliceId slice, bool is_coarse, const std::vector<std::uint32_t>& again, std::vector<bool>& moved,
                 PassReport& report);
  /// Tests rows of a cache once their slice is queried, and all of them if one does not fit. Returns, by node, the
  /// paths of those that do not fit and are cleared; empty if all fit.
  std::vector<std::uint32_t> audit_slice(SliceId slice, PassReport& report, std::vector<bool>& moved);

  // interpolation.cpp
  /// The answer of a node by its own row, or else by coarse rows; empty if they have no answer. Thread-safe.
  SampledAnswer answer_of(Slice& slice, std::uint32_t node);
  SampledAnswer keep_interpolated(Slice& slice, std::uint32_t node, std::unique_ptr<const RibbonAnswer> made);
  /// The view that a reader gets of a node of a slice with an index, but for g of an absent node. Thread-safe.
  RowView view_at(SliceId slice, std::uint32_t node);
  /// Frees the forms and interpolated answers of nodes whose row, or any row that answers for them, has changed.
  void forget_interpolated(SliceId slice, std::vector<bool> moved);
  void let_go_interpolated(Slice& slice, std::uint32_t node);
  void let_go_all_interpolated(Slice& slice);

  // publish.cpp
  /// Reports what is done to Options::progress. False, from then on until the end of the pass, if the host ends it.
  bool goes_on(double done);
  /// Counts the bytes of a new row. False, and counts nothing, if the memory limit or Options::memory_monitor is
  /// against it.
  bool takes(std::size_t size);
  /// bytes: those that there are now.
  void report_memory(std::size_t bytes);
  /// Calls task(i) for each i below count, in parallel: by Options::parallel_for, or else by oneTBB.
  void in_parallel(std::size_t count, const std::function<void(std::size_t)>& task);
  void update_rows(PassReport& report);
  /// Starts a row again that failed its audit, if memory has room; otherwise the audit stays due.
  void start_anew(Row& row, std::unique_ptr<const TracedNodes> nodes, PassReport& report);
  /// Adds the work of an outcome to the report, and keeps its error.
  void account(const RowOutcome& outcome, PassReport& report);
  void fill_totals(PassReport& report) const;
  void announce();

  // snapshot.cpp
  /// Why the service cannot have this slice; empty if it can.
  std::optional<Error> unusable(const SliceDescription& slice) const;
  /// False for a row that the slice cannot use: one of the other kind, or with other parts.
  bool may_answer(const Slice& slice, const CachedRow& row) const;
  /// Makes rows of cached rows until memory is full, first of those that answer at once. Keeps the rest as cached rows.
  std::optional<Error> take(RowSource& rows);

  // state.cpp
  struct Saved;
  SavedSlice saved_slice(const Slice& slice) const;
  /// Checks the rows of a slice against their answers, and hands them their earlier fits.
  std::optional<Error> check_rows(Saved& saved, SliceId slice) const;
  void take_over(Saved& saved);
  void take_slice(SavedSlice& saved, Slice& slice, const std::vector<bool>& has_converged);

  // forms.cpp
  /// Makes the answer of a row again, if it has one, without counting a query.
  void make_again(const FormedRows& rows, std::uint32_t node);
  /// If memory is full, drops all forms and interpolated answers, so that rows have room.
  void make_room();

  // service.cpp
  Error no_such_slice(const char* call, SliceId slice) const;
  /// Makes a call of the host's, and notes what it throws. Returns false if it threw. Thread-safe.
  template <class Call>
  bool call_host(const char* what, const Call& call) const {
    return calls_without_throwing(what, [this](Error error) { discipline_.note(std::move(error)); }, call);
  }
  /// Passes a sentence to Options::log, if that is set.
  void log(const std::string& sentence) const {
    if (options_.log) call_host("Options::log", [&] { options_.log(sentence); });
  }
  /// Logs misuse, full memory, unusable draws and reopened rows.
  void log_events(const PassReport& report);
  /// Notes a node that does not exist and a reader inside publish(). True if it noted one.
  bool is_misuse(const char* call, SliceId slice, std::uint32_t node);
  /// Does the same for a view, which must not be of an earlier pass. False unless passes are checked.
  bool is_stale(const char* call, const RowView& row);
  /// The number of node (a, b), or no_node.
  std::uint32_t node_of(SliceId slice, std::uint32_t a, std::uint32_t b) const;
  RowView bare_view(RowState state, SliceId slice, std::uint32_t node) const {
    RowView view;
    view.state = state;
    view.slice = slice;
    view.node = node;
    view.pass = pass_;
    return view;
  }
  PassReport end_pass(std::uint64_t paths);
  /// Traces a node, as GuardedTarget::trace().
  std::unique_ptr<const TracedNodes> trace(SliceId slice, std::uint32_t node) const {
    const Slice& of = rows_.slice(slice);
    return target_->trace(of.description, of.a_of(node), of.b_of(node));
  }
  /// Null for no target.
  template <class Guarded, class AnyTarget>
  std::unique_ptr<const Guarded> guard(const AnyTarget* target) {
    if (target == nullptr) return nullptr;
    return std::make_unique<const Guarded>(*target, [this](Error error) { discipline_.note(std::move(error)); });
  }
  /// Gives the view of an absent node of a density its g: traced once a pass, while memory lasts, or 0 if it may not be
  /// traced. Of samples there is no g. Thread-safe.
  void add_g(RowView& view, bool may_trace);
  /// The slice of a view whose node exists; null without an index.
  Slice* indexed_slice(const RowView& view) const;
  /// Updates the slot of the row, which readers use from now on. One row at a time.
  void show(Row& row, RowOutcome& outcome);

  Options options_;
  std::vector<Error> unusable_;  ///< options that were replaced
  std::unique_ptr<const GuardedTarget> target_;
  std::unique_ptr<const GuardedSamples> samples_;
  std::size_t learner_bytes_;  ///< bytes of the learner of each open row
  LightPolicy light_;
  mutable Discipline discipline_;  ///< noted by targets, too, while const functions trace
  Rows rows_;
  DensityLife densities_{options_, rows_, light_, target_.get()};
  SampleLife sampled_{options_, rows_, light_, samples_.get()};
  std::map<SliceKey, PackedSlice> unused_;  ///< cached slices that were not added by add_slice()
  std::vector<RowChange> changes_;
  std::vector<RowChange> prepared_;  ///< changes by prepare(), which the next publish() announces
  /// The nodes of a slice whose interpolated answers a state had kept, ascending; set while the state is taken over.
  const std::vector<std::uint32_t>* kept_before_ = nullptr;
  const Slice* kept_slice_ = nullptr;
  std::vector<Error> refusals_;
  std::function<void(const RowReport&)> listener_;
  bool learns_ = true;
  bool stopped_ = false;                      ///< whether Options::progress has ended the work of this pass
  bool monitor_refused_ = false;              ///< whether Options::memory_monitor has refused a row in this call
  std::size_t monitored_bytes_ = 0;           ///< the sum of what Options::memory_monitor was given
  std::uint32_t pass_ = 0;                    ///< number of the publish() that runs or ran last
  std::size_t bytes_ = 0;                     ///< bytes of all rows, heard paths and entries of forms
  std::size_t index_bytes_ = 0;               ///< bytes of the indices of all slices
  std::uint64_t reopened_ = 0;                ///< rows reopened in this session
  std::uint64_t reopened_logged_ = 0;         ///< how many of reopened_ have been logged
  bool ceiling_logged_ = false;               ///< whether full memory has been logged
  bool unusable_logged_ = false;              ///< whether unusable draws have been logged
  ErrorQuantiles absorbed_errors_;            ///< errors of rows that converged in this session
  PassReport between_passes_;                 ///< work of load() and add_slice(), reported by the next publish()
  std::atomic<std::size_t> formed_bytes_{0};  ///< bytes of all answers in forms and interpolated ones
  FormStore forms_{formed_bytes_};
  std::mutex interpolated_mutex_;  ///< guards Slice::interpolated
  std::atomic<std::size_t> memo_bytes_{0};
  std::atomic<std::uint64_t> traces_{0};  ///< traces by readers in the running pass
  StripedCounter answered_queries_;       ///< queries of the running pass that forms answered
  StripedCounter converged_queries_;      ///< those of answered_queries_ whose rows have converged
  StripedCounter forms_made_anew_;        ///< forms made again in the running pass for lack of memory
  StripedCounter unindexed_queries_;      ///< queries of the running pass to slices without an index
};

}  // namespace tress::inline v0_2::adaptive
