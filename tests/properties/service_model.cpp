#include "properties/service_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <utility>

#include "observations/sketch.h"
#include "properties/property.h"

namespace tress::inline v0_2::adaptive {
namespace {

/// As they stand in a file: equal values are equal bytes.
std::string bytes_of(const SliceDescription& slice, const CachedRow& row) {
  return encode_cache({"a", {{slice, {row}}}});
}

bool same_shape(const Component& a, const Component& b) {
  return a.shape.mu == b.shape.mu && a.shape.s_left == b.shape.s_left && a.shape.s_right == b.shape.s_right &&
         a.weight == b.weight;
}

bool same_density(const Mixture& a, const Mixture& b) {
  return a.uniform_weight == b.uniform_weight && std::ranges::equal(a.parts(), b.parts(), same_shape);
}

std::vector<ObservedPair> pairs_of(const CachedRow& row, float blur_rad) {
  Sketch sketch(Sketch::bin_count(blur_rad));
  sketch.merge(row.density()->sketch);
  return sketch.pairs();
}

/// Relative squared L2 between what a sketch has seen and g.
double distance(const std::vector<ObservedPair>& pairs, const TracedNodes& nodes) {
  double sum = 0;
  for (const ObservedPair& pair : pairs) sum += std::pow(double(nodes.density(pair.azimuth)) - double(pair.g), 2);
  return pairs.empty() ? 0 : sum / double(pairs.size()) * (2 * std::numbers::pi) / double(nodes.variation());
}

}  // namespace

ServiceModel::Answer ServiceModel::answer_of(const Service& service, std::size_t slice, std::uint32_t node) {
  const auto id = static_cast<SliceId>(slice);
  const auto width = static_cast<std::uint32_t>(service.slice(id).axis_b.size());
  const RowView row = service.peek(id, node / width, node % width);
  Answer answer{row.state, std::nullopt, row.objective};
  if (row.fit != nullptr) answer.fit = *row.fit;
  return answer;
}

bool ServiceModel::same(const Answer& a, const Answer& b) {
  return a.state == b.state && a.objective == b.objective && a.fit.has_value() == b.fit.has_value() &&
         (!a.fit || same_density(*a.fit, *b.fit));
}

TracedNodes ServiceModel::trace(std::size_t slice, std::uint32_t node) const {
  const SliceDescription& description = slices_[slice].description;
  const std::size_t width = description.axis_b.size();
  std::vector<TracedRay> rays;
  target_.trace(description, description.axis_a[node / width], description.axis_b[node % width], rays);
  return {rays, description.blur_rad};
}

void ServiceModel::add_slice(const SliceDescription& description) {
  for (const Slice& slice : slices_) {
    if (slice.description.key == description.key) return;
  }
  slices_.push_back({description, std::vector<Node>(description.node_count())});
  take(slices_.size() - 1);
}

void ServiceModel::load(const TableSnapshot& image) {
  has_loaded_ = true;
  for (const CachedSlice& slice : image.slices) cached_[slice.description.key] = slice;
  for (std::size_t p = 0; p < slices_.size(); ++p) take(p);
}

void ServiceModel::take(std::size_t p) {
  Slice& slice = slices_[p];
  const auto found = cached_.find(slice.description.key);
  if (found == cached_.end()) return;
  for (const CachedRow& row : found->second.rows) {
    Node& node = slice.nodes.at(row.node);
    node.cached = row;
    node.open_in_cache = !answers(row);
    node.answer.state = answers(row) ? RowState::converged : RowState::open;
    traces_of_loading_ += node.open_in_cache ? 1 : 0;  // g at once; what answers needs none
  }
  cached_.erase(found);
}

void ServiceModel::ask(std::size_t slice, std::uint32_t node, Ask how) {
  Node& asked = slices_[slice].nodes.at(node);
  ++asked.queries;
  ++asked.asked;
  if (how != Ask::look && learns_ && asked.answer.state == RowState::open) ++asked.given;
}

void ServiceModel::check_loaded(const Service& service) {
  for (std::size_t p = 0; p < slices_.size(); ++p) {
    for (std::uint32_t n = 0; n < slices_[p].nodes.size(); ++n) {
      Node& node = slices_[p].nodes[n];
      const Answer now = answer_of(service, p, n);
      RC_ASSERT(now.state == node.answer.state);
      if (node.queries == 0 && node.cached && node.cached->state == RowState::converged) {
        // Answers, or proposes, by what the cache says, and no better than it says.
        RC_ASSERT(now.objective == node.cached->objective);
        RC_ASSERT((now.fit && same_density(*now.fit, node.cached->density()->fit)));
      }
      node.answer = now;
    }
  }
}

/// The life of a row: what one pass may make of it.
void ServiceModel::check_change(Node& node, const Answer& now) {
  const bool touched = learns_ && (node.asked > 0 || node.given > 0);
  switch (node.answer.state) {
    case RowState::absent: {
      const bool created = learns_ && node.queries > 0 && node.queries >= options_.queries_before_creation;
      RC_ASSERT(now.state == (created ? RowState::open : RowState::absent));
      RC_ASSERT((now.fit.has_value() == created && now.objective == 1));  // fitted, and not yet tested
      break;
    }
    case RowState::open:
      if (!touched) {
        RC_ASSERT(same(now, node.answer));
        break;
      }
      // One test a pass at most.
      ++node.tests, ++node.tests_since_open;
      RC_ASSERT(now.state != RowState::absent);
      if (now.state == RowState::converged) {
        RC_ASSERT(node.tests_since_open >= options_.tests_to_converge());
        RC_ASSERT(now.objective <= options_.epsilon);
      }
      if (now.state == RowState::refused) {
        RC_ASSERT(node.tests >= options_.tests_before_refusal);
        RC_ASSERT(now.objective > options_.epsilon);
      }
      break;
    case RowState::converged:
      // Its answer stays, unless it is a cache's and an audit finds that the target has moved.
      if (now.state == RowState::open) {
        RC_ASSERT((touched && node.cached && !node.open_in_cache));
        RC_ASSERT(now.objective == 1);
        ++node.reopened;
        node.tests_since_open = 0;
        node.open_in_cache = true;  // from now on as any row of this session
        break;
      }
      RC_ASSERT(same(now, node.answer));
      break;
    case RowState::refused:
      RC_ASSERT(same(now, node.answer));
      break;
  }
}

void ServiceModel::check_pass(const Service& service, const PassReport& report) {
  PassReport wanted;
  std::uint64_t given = 0, audits_possible = 0;
  double objective_max = 0;
  wanted.traces = std::exchange(traces_of_loading_, 0);
  for (std::size_t p = 0; p < slices_.size(); ++p) {
    for (std::uint32_t n = 0; n < slices_[p].nodes.size(); ++n) {
      Node& node = slices_[p].nodes[n];
      const RowState before = node.answer.state;
      const bool may_be_audited = node.cached && !node.open_in_cache && before == RowState::converged;
      audits_possible += may_be_audited && node.asked > 0 ? 1 : 0;
      const Answer now = answer_of(service, p, n);
      check_change(node, now);
      wanted.queries += node.asked;
      wanted.converged_queries += before == RowState::converged ? node.asked : 0;
      wanted.rows_queried += node.queries > 0 ? 1 : 0;
      const bool created = before == RowState::absent && now.state != RowState::absent;
      wanted.creations += created ? 1 : 0;
      // An absent node is traced once a pass in which it is asked or created.
      wanted.traces += before == RowState::absent && (created || node.asked > 0) ? 1 : 0;
      wanted.newly_converged += before != RowState::converged && now.state == RowState::converged ? 1 : 0;
      wanted.rows_open += now.state == RowState::open ? 1 : 0;
      wanted.rows_converged += now.state == RowState::converged ? 1 : 0;
      wanted.rows_refused += now.state == RowState::refused ? 1 : 0;
      if (now.state == RowState::converged && now.fit) ++wanted.components[now.fit->component_count];
      if (now.state == RowState::converged && now.fit && !node.cached) {
        RC_ASSERT(now.fit->component_count <= options_.max_components);
      }
      if (now.state == RowState::converged || now.objective != 1) {
        objective_max = std::max<double>(objective_max, now.objective);
      }
      given += node.given;
      node.answer = now;
      node.asked = node.given = 0;
    }
  }
  RC_ASSERT(report.queries == wanted.queries);
  RC_ASSERT(report.converged_queries == wanted.converged_queries);
  RC_ASSERT(report.rows_queried == wanted.rows_queried);
  RC_ASSERT(report.creations == wanted.creations);
  RC_ASSERT(report.newly_converged == wanted.newly_converged);
  RC_ASSERT(report.rows_open == wanted.rows_open);
  RC_ASSERT(report.rows_converged == wanted.rows_converged);
  RC_ASSERT(report.rows_refused == wanted.rows_refused);
  RC_ASSERT(report.components == wanted.components);
  RC_ASSERT(report.objective_max >= objective_max);  // a bound may happen to be 1
  RC_ASSERT(!report.at_ceiling);
  RC_ASSERT(report.traces >= wanted.traces);
  if (audits_possible == 0 || !learns_) RC_ASSERT(report.traces == wanted.traces);
  RC_ASSERT(report.g_evaluations >= given + report.validation_draws);
  RC_ASSERT(report.refits >= report.creations);
  RC_ASSERT(report.rows_reopened >= last_reopened_);
  last_reopened_ = report.rows_reopened;
  g_evaluations_ += report.g_evaluations;
}

void ServiceModel::check_row(const Slice& slice, std::size_t p, const CachedRow& row) {
  const Node& node = slice.nodes.at(row.node);
  const RowState state = node.answer.state;
  RC_ASSERT(state != RowState::absent);
  const bool was_converged = node.cached && node.cached->state == RowState::converged;
  if (was_converged && node.open_in_cache && node.reopened == 0 && state != RowState::converged) {
    // A finer session lost nothing of what a coarser one had come to.
    RC_ASSERT(bytes_of(slice.description, row) == bytes_of(slice.description, *node.cached));
    return;
  }
  RC_ASSERT(row.state == (state == RowState::converged ? RowState::converged : RowState::open));
  const TracedNodes nodes = trace(p, row.node);
  const bool as_it_came = node.cached && !node.open_in_cache;
  // Each reopening and each sketch that was dropped raises the generation by one, up to the largest.
  const std::uint64_t first = node.cached ? node.cached->generation : 0;
  const std::uint64_t least = std::min<std::uint64_t>(first + node.reopened, ~0u);
  RC_ASSERT(row.generation >= least);
  if (row.state == RowState::converged) {
    RC_ASSERT(row.objective == node.answer.objective);
    RC_ASSERT(row.density()->sketch.empty());
    RC_ASSERT((node.answer.fit && same_density(row.density()->fit, *node.answer.fit)));
    RC_ASSERT(row.energy == (as_it_came ? node.cached->energy : nodes.energy()));
    if (as_it_came) RC_ASSERT(row.count == std::min(node.cached->count, (std::uint64_t{1} << 48) - 1));
    RC_ASSERT((row.generation == least || !as_it_came));
    return;
  }
  // What an open row remembers is g at its node; what a cache says of it at most epsilon/4 from that, or dropped.
  const std::vector<ObservedPair> pairs = pairs_of(row, slice.description.blur_rad);
  RC_ASSERT(!pairs.empty());
  RC_ASSERT(row.energy == nodes.energy());
  const bool kept_sketch =
      node.cached && !was_converged && !node.cached->density()->sketch.empty() && node.reopened == 0;
  if (kept_sketch) {
    const double off = distance(pairs_of(*node.cached, slice.description.blur_rad), nodes), most = options_.epsilon / 4;
    if (off > 1.001 * most) RC_ASSERT(row.generation == std::min<std::uint64_t>(first + 1, ~0u));
    if (off < 0.999 * most) RC_ASSERT(row.generation == first);
    if (off >= 0.999 * most) return;
    for (const SketchBin& bin : node.cached->density()->sketch) {
      const auto now = std::ranges::find(row.density()->sketch, bin.index, &SketchBin::index);
      RC_ASSERT((now != row.density()->sketch.end() &&
                 now->bits <= bin.bits));  // nothing is forgotten; the nearest pair stays
    }
    return;
  }
  RC_ASSERT(row.generation == least);
  const float tolerance = 1e-5f * (1 + *std::ranges::max_element(nodes.weight()) / slice.description.blur_rad);
  for (const ObservedPair& pair : pairs) RC_ASSERT(std::abs(pair.g - nodes.density(pair.azimuth)) <= tolerance);
  if (!node.cached) RC_ASSERT(row.count >= pairs.size());
}

void ServiceModel::check_saved(const Service& service) {
  const TableSnapshot saved = service.snapshot();
  RC_ASSERT(saved.model == target_.model_name());
  std::map<SliceKey, const CachedSlice*> of_key;
  for (const CachedSlice& slice : saved.slices) {
    RC_ASSERT((of_key.empty() || of_key.rbegin()->first < slice.description.key));
    of_key[slice.description.key] = &slice;
  }
  std::size_t found = 0;
  std::uint64_t count = 0;
  for (std::size_t p = 0; p < slices_.size(); ++p) {
    const Slice& slice = slices_[p];
    std::set<std::uint32_t> wanted, got;
    for (std::uint32_t n = 0; n < slice.nodes.size(); ++n) {
      if (slice.nodes[n].answer.state != RowState::absent) wanted.insert(n);
    }
    const auto at = of_key.find(slice.description.key);
    RC_ASSERT((at != of_key.end()) == !wanted.empty());  // a slice without rows says nothing
    if (wanted.empty()) continue;
    ++found;
    for (const CachedRow& row : at->second->rows) {
      RC_ASSERT((got.empty() || *got.rbegin() < row.node));
      got.insert(row.node);
      check_row(slice, p, row);
      count += row.count;
    }
    RC_ASSERT(got == wanted);
  }
  // What nobody uses is saved back as it came.
  RC_ASSERT(of_key.size() == found + cached_.size());
  for (const auto& [key, slice] : cached_) {
    RC_ASSERT(of_key.contains(key));
    RC_ASSERT(encode_cache({"a", {*of_key.at(key)}}) == encode_cache({"a", {slice}}));
  }
  // Every g that was asked taught a row.
  if (!has_loaded_) RC_ASSERT(count == g_evaluations_);
}

}  // namespace tress::inline v0_2::adaptive
