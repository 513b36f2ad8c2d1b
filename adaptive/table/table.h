// The state behind Service, and the steps of a publish() (README.md, the life of a row).
#pragma once

#include <atomic>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "cache/packed_slice.h"
#include "density/mixture_store.h"
#include "table/block_store.h"
#include "table/error_quantiles.h"
#include "table/guarded_samples.h"
#include "table/row.h"
#include "table/slice.h"
#include "table/striped_counter.h"
#include "tress/adaptive/service.h"
#include "tress/base/random.h"

namespace tress::adaptive {

/// What a reader sees of a node that has a row.
RowView view_of(const Slot& slot);

/// Reader methods (look_up, fetch, count_formed, observe, score, credit, hear): any thread. All else: one thread, no
/// reader.
class Service::Table {
 public:
  /// One of them may be null: there are no slices of its kind.
  Table(const Options& options, const Target* target, const SampledTarget* samples)
      : options_(options), target_(target), learner_bytes_(options.learner->make()->bytes()) {
    if (samples != nullptr)
      samples_ = std::make_unique<GuardedSamples>(*samples, [this](Error e) { note(std::move(e)); });
  }

  // service.cpp: what readers do
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
  /// Queries that were answered without look_up() or fetch(), and how many of them by converged rows.
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

  // state_write.cpp, state_read.cpp
  Result<std::string> state() const;
  std::optional<Error> restore(const std::string& state);

  // publish.cpp
  PassReport publish(std::uint64_t paths);

  // heard_test.cpp
  HeardTest test_by_heard();

  const Options& options() const { return options_; }
  std::string model_name() const { return target_ != nullptr ? target_->model_name() : samples_->model_name(); }
  bool has_target(SliceKind kind) const {
    return kind == SliceKind::samples ? samples_ != nullptr : target_ != nullptr;
  }
  const std::vector<std::unique_ptr<Slice>>& slices() const { return slices_; }
  const std::vector<Error>& refusals() const { return refusals_; }
  void set_learning(bool on) { learns_ = on; }
  void set_listener(std::function<void(const RowReport&)> listener) { listener_ = std::move(listener); }

 private:
  class Rows;
  /// A row whose published fit or state changed.
  struct RowChange {
    SliceId slice;
    std::uint32_t node;
    RowState state;
  };
  /// What was made of the rows of a slice.
  struct Made {
    void* block;
    std::size_t bytes;
    std::uint32_t node;
  };
  struct Form {
    std::unique_ptr<FormedRows> rows;
    std::vector<Made> made;
  };
  enum class Phase : std::uint8_t { between, pass, publishing };

  /// A node that is to have a row: because it was asked for often enough, or because a cache has it.
  struct Candidate {
    SliceId slice;
    std::uint32_t node;
    std::uint32_t queries;
    std::uint64_t light;
    std::unique_ptr<const TracedNodes> nodes;
  };
  /// What one row did in a pass.
  struct Outcome {
    std::uint64_t g_evaluations = 0, validation_draws = 0, refits = 0, bad_fits = 0, traces = 0;
    std::uint32_t failed = 0;  ///< tests of a row of samples that it did not pass
    bool changed = false, converged = false, audit_failed = false, reopened = false;
    const CachedRow* cached = nullptr;         ///< what a row is to be answered by from now on, without learning
    double absorbed_error = -1;                ///< of a row that converged, largest_absorbed_error()
    Moments weights;                           ///< g/(q energy) of what was scored
    std::unique_ptr<const TracedNodes> nodes;  ///< of a row of a density that failed its audit
    // What a row of samples has come to, one of them.
    std::unique_ptr<const RibbonAnswer> ribbons;
    std::unique_ptr<const SampledRefusal> refusal;
  };
  /// What answers for a node of samples; kept: holds what the table had no room for.
  struct SampledAnswer {
    const RibbonAnswer* answer = nullptr;
    std::shared_ptr<const RibbonAnswer> kept;
    explicit operator bool() const { return answer != nullptr; }
    const RibbonAnswer* operator->() const { return answer; }
    const RibbonAnswer& operator*() const { return *answer; }
  };
  /// A row of samples that did not fit its target, by its index, and the paths that it had.
  struct Stale {
    std::uint32_t row, paths;
  };

  // light.cpp
  /// What the node carried of the light of the paths so far: >= 0, of all rows together about the hits of a path.
  /// unseen: light that is added to it.
  double light_share(SliceId slice, std::uint32_t node, double unseen) const;
  /// What the row at a node has to reach, from the light that it carries; epsilon_without_light() for all without
  /// `picture_error`. energy: of g there, for rows of densities.
  double epsilon_of(SliceId slice, std::uint32_t node, float energy) const;
  double epsilon_without_light(SliceId slice) const {
    return slices_[slice]->is_sampled() ? options_.sampled_epsilon : options_.epsilon;
  }
  /// PassReport::bias_bound.
  double bias_bound() const;
  bool is_light_driven(const Slice& slice) const {
    return options_.picture_error > 0 && (slice.is_sampled() || !options_.learner->on_first_query);
  }

  // creations.cpp
  /// Makes rows of the candidates, in their order, until the ceiling. Appends to changes_. True if all had room.
  bool admit(std::vector<Candidate>& candidates, PassReport& report);
  /// Fills a new row: from the cache if that has it, and then it may have converged; else opens or learns it.
  Outcome settle(Row& row) const;
  /// Of a density; cached: what a cache has of it, or null.
  Outcome open(Row& row, const CachedRow* cached) const;
  std::size_t bytes_needed(const Candidate& candidate) const;
  bool needs_nodes(const Candidate& candidate) const;
  /// Whether a cached row answers at once: any of samples does; another is good enough for the light of its node.
  bool answers(SliceId slice, const CachedRow& cached) const;
  /// True if the pairs of the row's sketch, which a cache brought, are not what its nodes say.
  bool outdated(const Row& row) const;

  // sampled_rows.cpp
  /// Brings every row of samples to the stage that its events ask for, coarse rows before finer ones.
  void grow_samples(PassReport& report);
  /// The same for the rows of one level of one slice. again: paths of rows that begin anew, by node. moved: set for
  /// every node whose answer has changed.
  void grow_level(SliceId slice, std::size_t level, const std::vector<std::uint32_t>& again, std::vector<bool>& moved,
                  PassReport& report);
  bool learns_to_epsilon() const { return options_.learns_to_epsilon || options_.picture_error > 0; }
  /// Paths beyond which no row of samples is taught.
  std::uint32_t most_paths() const;
  /// Events by node of a level: those of each node, shared among the nodes of the level around it.
  std::vector<double> gathered_events(const Slice& slice, std::size_t level) const;
  /// Paths that a row at a node of a level is to have; 0: no row yet.
  std::uint32_t wanted_paths(SliceId slice, std::size_t level, double events) const;
  /// Learns a row up to so many paths, and further where it learns until it passes its test. parent: what answered
  /// before a new row, or null. Rows run in parallel.
  Outcome learn(const Row& row, std::uint32_t paths, const RibbonAnswer* parent) const;
  /// Tests a row of a cache on fresh draws.
  Outcome audit_samples(const Row& row) const;
  /// Tests rows of a cache, once their slice is asked; all of them where one does not fit. Fills stale_.
  void audit_slice(SliceId slice, PassReport& report, std::vector<bool>& moved);

  // interpolation.cpp
  /// The answer of a node by its own row, or by those of the levels above `level`. Any thread.
  SampledAnswer answer_of(Slice& slice, std::uint32_t node, std::size_t level);
  SampledAnswer keep_interpolated(Slice& slice, std::uint32_t node, std::unique_ptr<const RibbonAnswer> made);
  /// What a reader sees of a node of samples. Any thread.
  RowView sampled_view(SliceId slice, std::uint32_t node);
  /// Lets go of forms and interpolated answers of nodes whose row, or any row that answers for them, has moved.
  void forget_interpolated(SliceId slice, std::vector<bool> moved);
  void let_go_interpolated(Slice& slice, std::uint32_t node);
  void let_go_all_interpolated(Slice& slice);

  // row_update.cpp
  /// The end of a pass for one row. Touches nothing but the row: rows run in parallel.
  Outcome update(Row& row) const;
  /// Scores a converged row of a cache against a fresh trace, or fresh draws.
  Outcome audit(Row& row) const;
  Outcome audit_density(Row& row) const;
  /// Starts anew a row that failed its audit.
  Outcome reopen(Row& row, std::unique_ptr<const TracedNodes> nodes) const;
  /// Opens the row: what its learner does before the first pass of it.
  void begin(Row& row, Outcome& outcome) const;
  std::uint64_t draw_validation(Row& row, const Options& options) const;
  /// Answers the row by its mean for good: its error cannot be seen. No g is asked.
  void leave_unfitted(Row& row, Outcome& outcome) const;
  /// The settings of the service with the row's own epsilon.
  Options options_of(const Row& row) const;
  /// options: options_of(row), which must outlive the context.
  FitContext context_of(Row& row, const Options& options) const;
  /// Takes over what a context and the stop test have come to.
  void conclude(Row& row, const FitContext& context, Outcome& outcome) const;
  /// The largest error of a fit, whose attributes are known, at the decay rates of its slice; negative without any, and
  /// of rows for which others stand.
  template <class Fit>
  double largest_absorbed_error(const Row& row, const Fit& fit) const;
  RandomStream stream_of(const Row& row, std::uint64_t purpose) const;

  // publish.cpp
  void update_rows(PassReport& report);
  /// reopen(), where there is room; else the audit stays due.
  void start_anew(Row& row, std::unique_ptr<const TracedNodes> nodes, PassReport& report);
  void count_converged(const Outcome& outcome, PassReport& report);
  void fill_totals(PassReport& report) const;
  void announce();

  // snapshot.cpp
  /// Why the service can have no such slice.
  std::optional<Error> unusable(const SliceDescription& slice) const;
  /// False of a converged row that is of no use in the slice: of the other kind, or with other parts.
  bool may_answer(const Slice& slice, const CachedRow& row) const;
  /// Gives rows to cached rows until the ceiling, those that answer at once first, and keeps the rest as it is.
  std::optional<Error> take(RowSource& rows);

  // state_write.cpp
  void write_totals(ByteWriter& out) const;
  void write_slice(ByteWriter& out, const Slice& slice) const;
  /// False if its learner cannot be told.
  bool write_row(ByteWriter& out, const Row& row) const;

  // state_read.cpp
  class StateReader;
  struct SavedRow;
  struct SavedSlice;
  struct SavedTable;
  /// Checks what it must know the targets for, and makes of the rows what answers for them.
  std::optional<Error> rebuild(SavedTable& saved);
  std::optional<Error> check_rows(SavedTable& saved, SliceId id) const;
  void take_over(SavedTable& saved);
  void take_row(SavedRow& saved);
  void take_slice(const SavedTable& all, SavedSlice& saved, Slice& slice);

  // forms.cpp
  /// Makes the answer of a converged row again, without counting a query. False if the row has no answer.
  bool make_again(Form& form, std::uint32_t node);
  std::size_t form_of(const FormedRows& rows) const;
  /// All rows of the slice are to be asked again: of readers that is, who so make them anew and show what is asked.
  void drop_forms(SliceId slice);
  void drop(Form& form);
  void let_go(Form& form, const Made& one);
  /// Forms give way to rows.
  void make_room();

  // discipline.cpp
  /// Keeps the first since the last publish().
  void note(Error error) const;
  /// Why a call that belongs between passes is refused.
  std::optional<Error> within_pass(const char* call) const;
  Error no_such_slice(const char* call, SliceId slice) const;
  /// Notes a node that is not there and, where passes are checked, a reader inside publish().
  /// Options::log, if there is one.
  void tell(const std::string& sentence) const {
    if (options_.log) options_.log(sentence);
  }
  /// What of a pass is worth a sentence.
  void tell_of(const PassReport& report);
  bool is_misuse(const char* call, SliceId slice, std::uint32_t node);
  /// The same of a view, which may be of an earlier pass. False unless passes are checked.
  bool is_stale(const char* call, const RowView& row);
  /// g of a node that is not there.
  static const TracedNodes& no_light();

  RowView bare_view(RowState state, SliceId slice, std::uint32_t node) const {
    RowView view;
    view.state = state;
    view.slice = slice;
    view.node = node;
    view.pass = pass_;
    return view;
  }
  PassReport end_pass(std::uint64_t paths);
  RowState state_of(const Row& row) const;
  /// Bound of its last test, negative before the first.
  float objective_of(const Row& row) const;
  /// Null, and reported, where the target throws or gives rays that TracedRay does not allow.
  std::unique_ptr<const TracedNodes> trace(SliceId slice, std::uint32_t node) const;
  Slot& slot_of(const Row& row) const { return slices_[row.slice]->slots[row.node]; }
  /// Memory of the row and of what answers for it.
  std::size_t bytes_of(const Row& row) const;
  /// Puts into its slot what readers may see of the row from now on. One row at a time.
  void show(Row& row, Outcome& outcome);
  /// Of a row that its learning has changed: where that is at its end, what it has come to, and it goes.
  void show_learning(Row& row, bool converged);
  /// Answers a row without learning by what a cache has. has_converged: of a row of samples.
  void show_cached(Row& row, const CachedRow& cached, bool has_converged);

  Options options_;
  const Target* target_;
  std::unique_ptr<const GuardedSamples> samples_;
  std::size_t learner_bytes_;  ///< of each open row
  std::vector<std::unique_ptr<Slice>> slices_;
  std::map<SliceKey, SliceId, KeyLess> slice_of_key_;
  std::map<SliceKey, PackedSlice, KeyLess> unused_;  ///< cached slices that no add_slice() asked for
  std::deque<Row> rows_;                             ///< in order of creation
  MixtureStore mixtures_;                            ///< what is published
  std::vector<RowChange> changes_;
  std::vector<RowChange> prepared_;  ///< changes by prepare(), which the next publish() announces
  /// While a state is taken over: the nodes whose interpolated answers it had kept, ascending.
  const std::vector<std::uint32_t>* kept_before_ = nullptr;
  std::vector<Stale> stale_;  ///< of the slice that grow_samples() is at
  std::vector<Error> refusals_;
  std::function<void(const RowReport&)> listener_;
  bool learns_ = true;
  std::uint32_t pass_ = 0;           ///< number of the publish() that runs or ran last
  std::size_t bytes_ = 0;            ///< of all rows
  std::size_t index_bytes_ = 0;      ///< of all slices
  std::uint64_t reopened_ = 0;       ///< in this session
  std::uint64_t paths_ = 0;          ///< told to publish() so far
  std::uint64_t reopened_told_ = 0;  ///< of reopened_, by Options::log
  bool ceiling_told_ = false;        ///< likewise
  bool unusable_told_ = false;       ///< likewise
  std::uint64_t queried_ = 0;        ///< nodes ever asked for, as of the last publish()
  ErrorQuantiles absorbed_errors_;   ///< of rows that converged in this session: these stay so
  PassReport between_passes_;        ///< work of load() and add_slice(), told by the next publish()
  std::vector<Form> forms_;
  BlockStore blocks_;      ///< of all forms
  std::mutex made_mutex_;  ///< of Form::made
  mutable std::mutex misuse_mutex_;
  mutable std::optional<Error> misuse_;
  std::atomic<Phase> phase_{Phase::between};  ///< kept only where passes are checked
  std::atomic<std::uint32_t> readers_{0};     ///< likewise: inside look_up()
  std::atomic<std::size_t> formed_bytes_{0};  ///< of all forms and their entries
  std::atomic<std::size_t> memo_bytes_{0};
  std::atomic<std::uint64_t> traces_{0};  ///< by readers, in the running pass
  StripedCounter answered_queries_;       ///< queries in the running pass that were answered by forms
  StripedCounter converged_queries_;      ///< of them, those of converged rows
  StripedCounter forms_made_anew_;        ///< in the running pass, for want of room
  StripedCounter unindexed_queries_;      ///< likewise, of slices without an index
};

}  // namespace tress::adaptive
