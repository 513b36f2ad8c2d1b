// Rows: which nodes get one and what it starts with, what a pass does for it, and how it answers.
//
// Creation of rows: which nodes get a row, in which order, and what a new row starts with.
#include "table/table.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "base/pi.h"
#include "density/interpolated_row.h"
#include "fit/absorbed_error.h"
#include "fit/fit_mixture.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr std::size_t batch = 256;         // candidates traced between two checks of memory
constexpr std::uint32_t audit_one_in = 8;  // one converged row of a cache in this many is audited, chosen by key

}  // namespace

bool Service::Table::answers(SliceId slice, const CachedRow& cached) const {
  if (cached.state != RowState::converged) return false;
  if (cached.ribbons) return true;
  const double objective = cached.objective;
  return objective <= options_.epsilon ||
         (light_.paths > 0 && objective <= epsilon_of(slice, cached.node, cached.energy));
}

bool Service::Table::needs_nodes(const Candidate& candidate) const {
  const auto& stored = rows_.slice(candidate.slice).stored;
  const auto found = stored.find(candidate.node);
  return found == stored.end() || !answers(candidate.slice, found->second);
}

std::size_t Service::Table::bytes_needed(const Candidate& candidate) const {
  const Slice& slice = rows_.slice(candidate.slice);
  const auto found = slice.stored.find(candidate.node);
  if (!needs_nodes(candidate)) {
    return sizeof(Row) +
           (found->second.ribbons ? sizeof(RibbonAnswer) : PackedMixture::bytes_of(found->second.fit.component_count));
  }
  const bool keeps_earlier = found != slice.stored.end() && found->second.state == RowState::converged;
  return sizeof(Row) + Learning::bytes_before_nodes(slice.description.blur_rad, learner_bytes_) +
         (keeps_earlier ? cached_row_bytes(found->second) : 0) +
         (candidate.nodes ? candidate.nodes->bytes() : sizeof(TracedNodes));
}

bool Service::Table::outdated(const Row& row) const {
  const std::vector<ObservedPair> pairs = row.learning->sketch.pairs();
  double sum = 0;
  for (const ObservedPair& pair : pairs) {
    const double change = static_cast<double>(row.learning->nodes->density(pair.azimuth)) - pair.g;
    sum += change * change;
  }
  const double objective =
      pairs.empty() ? 0 : sum * two_pi / (static_cast<double>(pairs.size()) * row.learning->nodes->variation());
  return objective > epsilon_of(row.slice, row.node, row.energy) / 4;  // the error that a fit must reach on its pairs
}

Service::Table::Outcome Service::Table::settle(Row& row) const {
  const Slice& slice = rows_.slice(row.slice);
  Outcome outcome;
  const auto found = slice.stored.find(row.node);
  const CachedRow* cached = found == slice.stored.end() ? nullptr : &found->second;
  if (cached != nullptr) {
    row.generation = cached->generation;
    if (answers(row.slice, *cached)) {
      row.set_count(cached->count);
      row.energy = cached->energy;
      row.audit = stream_of(row, 0).next_bits() % audit_one_in == 0 ? Audit::due : Audit::possible;
      outcome.cached = cached;
      return outcome;
    }
  }
  Learning& learning = *row.learning;
  row.energy = learning.nodes->energy();
  if (cached != nullptr) {
    learning.count = cached->count;
    if (cached->state == RowState::converged) {
      learning.fit = cached->fit;
      learning.has_fit = true;
      learning.objective = cached->objective;
      learning.earlier = std::make_unique<const CachedRow>(*cached);
    }
    learning.sketch.merge(cached->sketch);
    if (outdated(row)) {
      learning.sketch.clear();
      learning.count = 0;
      row.raise_generation();
      outcome.reopened = true;
    }
  }
  begin(row, outcome);
  return outcome;
}

bool Service::Table::admit(std::vector<Candidate>& candidates, PassReport& report) {
  bool room = true;
  for (std::size_t start = 0; start < candidates.size() && room; start += batch) {
    if (!goes_on(share_of_densities * static_cast<double>(start) / static_cast<double>(candidates.size()))) break;
    const std::size_t end = std::min(start + batch, candidates.size());
    // Stops before tracing rows that would not fit in memory even without rays.
    std::size_t traced_end = start;
    for (std::size_t least = bytes_; traced_end < end; ++traced_end) {
      least += bytes_needed(candidates[traced_end]);
      if (least > options_.memory_bytes) break;
    }
    room = traced_end == end;
    std::atomic<std::uint64_t> traces{0};
    in_parallel(traced_end - start, [&](std::size_t i) {
      Candidate& one = candidates[start + i];
      if (!one.nodes && needs_nodes(one)) {
        one.nodes = trace(one.slice, one.node);
        traces.fetch_add(1, std::memory_order_relaxed);
      }
    });
    const std::size_t first = rows_.size();
    std::vector<std::size_t> sizes;
    for (std::size_t i = start; i < traced_end; ++i) {
      Candidate& one = candidates[i];
      if (!one.nodes && needs_nodes(one)) continue;  // the target could not trace them
      const std::size_t size = bytes_needed(one);
      if (!takes(size)) {
        room = false;
        break;
      }
      sizes.push_back(size);
      Row& row = rows_.add({one.slice, one.node});
      if (needs_nodes(one)) {
        row.learning = std::make_unique<Learning>(std::move(one.nodes), *options_.learner);
        row.learning->created_pass = pass_;
        row.learning->queries_at_creation = one.queries;
      }
    }
    std::vector<Outcome> outcomes(rows_.size() - first);
    in_parallel(outcomes.size(), [&](std::size_t i) { outcomes[i] = settle(rows_[first + i]); });
    for (std::size_t i = 0; i < outcomes.size(); ++i) {
      Row& row = rows_[first + i];
      show(row, outcomes[i]);
      rows_.slice(row.slice).stored.erase(row.node);
      bytes_ = bytes_ - sizes[i] + rows_.bytes_of(row);  // settle() may have ended its learning
      changes_.push_back({row.slice, row.node});
      account(outcomes[i], report);
      reopened_ += outcomes[i].reopened ? 1 : 0;
    }
    report.creations += outcomes.size();
    report.traces += traces.load(std::memory_order_relaxed);
  }
  return room;
}

// The end of a pass for one row: it takes the draws that its learner wants, tests the fit and lets the learner refit.
namespace {

constexpr std::uint64_t validation_purpose = 0;
constexpr std::uint64_t audit_purpose = 0x6175646974ull;
constexpr std::uint64_t learner_purpose = 0x6c6561726e6572ull;
constexpr std::uint32_t queries_before_validation = 8;
constexpr int audit_draws = 64;

}  // namespace

RandomStream Service::Table::stream_of(const Row& row, std::uint64_t purpose) const {
  const SliceKey& key = rows_.slice(row.slice).description.key;
  std::uint64_t mixed = mix_bits(options_.seed + purpose) ^ key.lobe;
  for (const float parameter : key.told_parameters())
    mixed = mix_bits(mixed) ^ std::bit_cast<std::uint32_t>(parameter + 0.0f);
  return RandomStream(mixed, row.node, pass_);
}

Options Service::Table::options_of(const Row& row) const {
  Options options = options_;
  options.epsilon = epsilon_of(row.slice, row.node, row.energy);
  return options;
}

FitContext Service::Table::context_of(Row& row, const Options& options) const {
  Learning& learning = *row.learning;
  return FitContext{.options = options,
                    .nodes = *learning.nodes,
                    .sketch = learning.sketch,
                    .stop = learning.stop,
                    .random = stream_of(row, learner_purpose),
                    .components = static_cast<int>(std::clamp<std::uint32_t>(
                        std::min(options_.max_components, rows_.slice(row.slice).description.max_components), 1,
                        Mixture::max_components)),
                    .fit = learning.fit,
                    .has_fit = learning.has_fit,
                    .count = learning.count};
}

double Service::Table::largest_absorbed_error(const Row& row) const {
  double largest = -1;
  const Slice& slice = rows_.slice(row.slice);
  if (slice.decay_rates.empty() || !stands_for_others(slice.description.key, row.node)) return largest;
  for (const float rate : representative_rates(slice.decay_rates)) {
    largest = std::max(largest, absorbed_error(row.learning->fit, *row.learning->nodes, rate).value_or(-1));
  }
  return largest;
}

void Service::Table::leave_unfitted(Row& row, Outcome& outcome) const {
  Learning& learning = *row.learning;
  learning.fit = Mixture{};
  learning.fit.uniform_weight = row.energy;
  assign_attributes(learning.fit, *learning.nodes);
  learning.has_fit = true;
  learning.objective = 1;  // an upper bound: integral (g - mean)^2 / L is at most 1
  outcome.absorbed_error = largest_absorbed_error(row);
  outcome.changed = outcome.converged = true;
}

void Service::Table::begin(Row& row, Outcome& outcome) const {
  const Options options = options_of(row);
  if (light_.is_driven() && options.epsilon >= 1) {
    leave_unfitted(row, outcome);
    return;
  }
  FitContext context = context_of(row, options);
  row.learning->learner->begin(context);
  conclude(row, context, outcome);
}

std::uint64_t Service::Table::draw_validation(Row& row, const Options& options) const {
  Learning& learning = *row.learning;
  const std::uint32_t queries = rows_.slot_of(row).queries.load(std::memory_order_relaxed);
  const std::uint64_t wanted = options.scores_per_test();
  const std::uint64_t have = learning.stop.scores();
  if (learning.created_pass >= pass_ || !learning.has_fit ||
      queries - learning.queries_at_creation < queries_before_validation)
    return 0;
  if (have >= wanted) return 0;
  RandomStream random = stream_of(row, validation_purpose);
  for (std::uint64_t i = have; i < wanted; ++i) {
    const float x = learning.fit.sample(random.next(), options_.uniform_share_open);
    const float q = learning.fit.proposal_density(x, options_.uniform_share_open);
    const float g = learning.nodes->density(x);
    learning.add_score(x, g, q);
    learning.sketch.offer(x, g);
  }
  learning.count += wanted - have;
  return wanted - have;
}

void Service::Table::conclude(Row& row, const FitContext& context, Outcome& outcome) const {
  outcome.g_evaluations += context.g_evaluations;
  outcome.refits += context.fits;
  outcome.bad_fits += context.bad_fits;
  outcome.changed = outcome.changed || context.fits > 0;
  Learning& learning = *row.learning;
  if (learning.stop.bound() >= 0) learning.objective = learning.stop.bound();
  if (learning.stop.verdict() == StopTest::Verdict::undecided) return;
  outcome.changed = true;
  if (learning.stop.verdict() == StopTest::Verdict::refused) return;
  assign_attributes(learning.fit, *learning.nodes);
  outcome.absorbed_error = largest_absorbed_error(row);
  outcome.converged = true;
}

Service::Table::Outcome Service::Table::update(Row& row) const {
  if (!row.learning) return audit(row);
  Outcome outcome;
  outcome.g_evaluations = row.learning->observed.exchange(0, std::memory_order_relaxed);
  row.learning->count += outcome.g_evaluations;
  const Options options = options_of(row);
  FitContext context = context_of(row, options);
  row.learning->learner->before_test(context);
  outcome.validation_draws = draw_validation(row, options);
  outcome.g_evaluations += outcome.validation_draws;
  outcome.weights = row.learning->weights.moments();
  row.learning->weights.clear();
  context.own_draws = outcome.weights.count;
  if (row.learning->has_fit) context.test();
  if (row.learning->stop.verdict() == StopTest::Verdict::undecided) row.learning->learner->learn(context);
  conclude(row, context, outcome);
  return outcome;
}

Service::Table::Outcome Service::Table::audit(Row& row) const {
  Outcome outcome;
  if (row.audit != Audit::due) return outcome;
  row.audit = Audit::none;
  const RowView view = view_of(rows_.slot_of(row));
  std::unique_ptr<const TracedNodes> nodes = trace(row.slice, row.node);
  if (!nodes) return outcome;
  RandomStream random = stream_of(row, audit_purpose);
  FixedMoments<2> scores;
  for (int i = 0; i < audit_draws; ++i) {
    const float x = view.sample(random.next(), options_.uniform_share_open);
    const double q = view.proposal_density(x, options_.uniform_share_open);
    const double r = static_cast<double>(nodes->density(x)) - view.density(x);
    scores.add(r * r / (q * nodes->variation()));
  }
  outcome.traces = 1;
  outcome.g_evaluations = audit_draws;
  const Moments moments = scores.moments();
  // The error that the row was accepted with: epsilon, or its own bound if it carries little light.
  const double claimed = std::max(options_.epsilon, static_cast<double>(view.objective));
  if (moments.mean - 2 * standard_error(moments) <= claimed) return outcome;
  outcome.nodes = std::move(nodes);
  outcome.audit_failed = true;
  return outcome;
}

// Answers of rows in a form: which rows have one, and how queries of them count.
namespace {

/// Whether a row answers without evaluating g.
bool has_answer(const RowView& row) { return row.state == RowState::converged || row.ribbons != nullptr; }

}  // namespace

Result<const FormedRows*> Service::Table::add_form(SliceId slice, std::shared_ptr<const RowForm> form,
                                                   const std::vector<float>& decay_rates) {
  if (std::optional<Error> early = discipline_.within_pass("add_form")) return std::move(*early);
  if (slice >= rows_.slice_count()) return no_such_slice("add_form", slice);
  if (form == nullptr) return Error{"", "add_form", "a form", "none"};
  const SliceDescription& description = rows_.slice(slice).description;
  const std::size_t size = sizeof(RowEntry) * description.node_count();
  const bool has_room = bytes_ + formed_bytes_ + size <= options_.memory_bytes;
  for (const float rate : decay_rates) rows_.slice(slice).add_rate(rate);
  rows_.slice(slice).forms.push_back(static_cast<std::uint32_t>(forms_.size()));
  const bool has_entries = has_room && !options_.check_passes;
  if (has_entries) bytes_ += size;
  return forms_.add(slice, description, std::move(form), has_entries);
}

FormedLookup Service::Table::fetch(const FormedRows& rows, std::uint32_t node) {
  FormedLookup found;
  const SliceId id = rows.slice();
  const bool is_there = forms_.has(rows) && node < rows_.slice(id).description.node_count();
  if ((!is_there || options_.check_passes) && is_misuse("fetch", id, node)) return found;
  if (!is_there) return found;  // the rows belong to another service
  found.answer = forms_.find(rows, node);
  if (found.answer) {
    found.row = bare_view(RowState::converged, id, node);
    count_formed(found.answer.has_row() ? 1 : 0, found.answer.has_converged() ? 1 : 0);
    return found;
  }
  if (!rows_.slice(id).has_index()) return found;
  const RowView row = view_at(id, node);
  if (!has_answer(row)) return found;
  Slot& slot = rows_.slice(id).slots[node];
  if (FormStore::has_entries(rows)) {
    // Shows that the row is in use and may be audited. How often a form is made depends on threads and memory, so that
    // it is not counted as a query of the node.
    rows_.slice(id).formed[node].store(1, std::memory_order_relaxed);
    count_formed(1, row.state == RowState::converged ? 1 : 0);
  } else {
    slot.queries.fetch_add(1, std::memory_order_relaxed);
  }
  const std::size_t others = bytes_ + memo_bytes_.load(std::memory_order_relaxed);
  found = forms_.make(rows, row, options_.memory_bytes - std::min(others, options_.memory_bytes));
  if (found.kept) forms_made_anew_.add(1);
  found.row = bare_view(row.state, id, node);
  found.row.row = row.row;
  return found;
}

FormedLookup Service::Table::look_up(const FormedRows& rows, std::uint32_t node) {
  FormedLookup found = fetch(rows, node);
  if (!found.answer) found.row = look_up(rows.slice(), node / rows.width(), node % rows.width());
  return found;
}

void Service::Table::make_again(const FormedRows& rows, std::uint32_t node) {
  const Slice& slice = rows_.slice(rows.slice());
  if (!FormStore::has_entries(rows) || !slice.has_index() || forms_.find(rows, node)) return;
  const RowView row = view_at(rows.slice(), node);
  if (has_answer(row)) (void)forms_.make(rows, row, std::numeric_limits<std::size_t>::max());
}

void Service::Table::make_room() {
  if (bytes_ + formed_bytes_ <= options_.memory_bytes) return;
  for (std::size_t form = 0; form < forms_.size(); ++form) forms_.drop(form);
  for (const std::unique_ptr<Slice>& slice : rows_.slices()) let_go_all_interpolated(*slice);
}

// Nodes of samples without a row of their own: the coarser rows around them answer, by displacement interpolation.
Service::Table::SampledAnswer Service::Table::answer_of(Slice& slice, std::uint32_t node, std::size_t level) {
  const std::uintptr_t word = slice.slots[node].word.load(std::memory_order_acquire);
  const Slot::Kind kind = Slot::kind_of(word);
  if (kind == Slot::Kind::ribbons || kind == Slot::Kind::interpolated)
    return {Slot::target_of<RibbonAnswer>(word), nullptr};
  if (kind == Slot::Kind::refusal) return {};
  if (slice.coarse_rows != nullptr && level < slice.levels.coarse()) {
    const SampledAnswer theirs = answer_of(*slice.coarse_rows, node, level);
    if (!theirs) return {};
    auto copy = std::make_unique<RibbonAnswer>(*theirs);
    copy->has_converged = false;
    return keep_interpolated(slice, node, std::move(copy));
  }
  if (level == 0) return {};
  const Levels::Corners corners = slice.levels.around(level - 1, node);
  if (corners.count == 1 && corners.all[0].node == node) return answer_of(slice, node, level - 1);

  std::array<SampledAnswer, 4> parents;
  std::array<DecodedRow, 4> decoded;
  std::array<WeightedRow, 4> rows;
  auto made = std::make_unique<RibbonAnswer>();
  for (std::uint32_t i = 0; i < corners.count; ++i) {
    parents[i] = answer_of(slice, corners.all[i].node, level - 1);
    if (!parents[i]) return {};
    const RibbonAnswer& parent = *parents[i];
    decoded[i] = DecodedRow(parent.row);
    rows[i] = {&decoded[i], corners.all[i].weight};
    made->objective = i == 0 ? parent.objective : std::max(made->objective, parent.objective);
    made->paths = i == 0 ? parent.paths : std::min(made->paths, parent.paths);
  }
  made->row = interpolate_rows({rows.data(), corners.count});
  made->has_converged = false;
  return keep_interpolated(slice, node, std::move(made));
}

Service::Table::SampledAnswer Service::Table::keep_interpolated(Slice& slice, std::uint32_t node,
                                                                std::unique_ptr<const RibbonAnswer> made) {
  Slot& slot = slice.slots[node];
  const std::size_t before = formed_bytes_.fetch_add(made->bytes(), std::memory_order_relaxed);
  const std::size_t others = bytes_ + memo_bytes_.load(std::memory_order_relaxed);
  const bool has_room = kept_before_ != nullptr
                            ? &slice == kept_slice_ && std::ranges::binary_search(*kept_before_, node)
                            : others + before + made->bytes() <= options_.memory_bytes;
  if (slot.row != Slot::no_row || !has_room) {
    formed_bytes_.fetch_sub(made->bytes(), std::memory_order_relaxed);
    std::shared_ptr<const RibbonAnswer> kept = std::move(made);
    return {kept.get(), kept};
  }
  const auto [there, is_first] = slot.put_first(std::move(made), Slot::Kind::interpolated);
  if (!is_first) {
    formed_bytes_.fetch_sub(sizeof(RibbonAnswer), std::memory_order_relaxed);
    return {there, nullptr};
  }
  const std::scoped_lock lock(interpolated_mutex_);
  slice.interpolated.push_back(node);
  return {there, nullptr};
}

RowView Service::Table::view_at(SliceId id, std::uint32_t node) {
  Slice& slice = rows_.slice(id);
  const Slot& slot = slice.slots[node];
  RowView view = slot.row != Slot::no_row ? view_of(slot) : RowView{};
  view.slice = id;
  view.node = node;
  view.pass = pass_;
  if (slot.row != Slot::no_row) return view;
  const SampledAnswer answer = answer_of(slice, node, slice.levels.coarse());
  if (!answer) return view;
  view.ribbons = &answer->row;
  view.objective = answer->objective;
  view.paths = answer->paths;
  view.kept = answer.kept;
  return view;
}

void Service::Table::forget_interpolated(SliceId id, std::vector<bool> moved) {
  Slice& slice = rows_.slice(id);
  for (std::size_t level = 1; level <= slice.levels.coarse(); ++level) {
    for (std::uint32_t n = 0; n < slice.description.node_count(); ++n) {
      if (!slice.levels.has(level, n) || slice.slots[n].row != Slot::no_row) continue;
      for (const Levels::Corner& corner : slice.levels.around(level - 1, n)) {
        if (moved[corner.node]) moved[n] = true;
      }
    }
  }
  for (const std::uint32_t form : slice.forms) forms_.drop_if(form, [&](std::uint32_t node) { return moved[node]; });
  std::erase_if(slice.interpolated, [&](std::uint32_t n) {
    if (!moved[n] && slice.slots[n].row == Slot::no_row) return false;
    let_go_interpolated(slice, n);
    return true;
  });
}

void Service::Table::let_go_all_interpolated(Slice& slice) {
  for (const std::uint32_t node : slice.interpolated) let_go_interpolated(slice, node);
  slice.interpolated.clear();
}

void Service::Table::let_go_interpolated(Slice& slice, std::uint32_t node) {
  if (slice.slots[node].interpolated() == nullptr) return;
  formed_bytes_ -= sizeof(RibbonAnswer);
  slice.slots[node].set<TracedNodes>(nullptr, Slot::Kind::traced);
}

}  // namespace tress::inline v0_2::adaptive
