#include "properties/service_model.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "fit/fit_mixture.h"
#include "fit/known_error.h"

namespace tress::adaptive {
namespace {

__extension__ typedef unsigned __int128 Wide;

constexpr std::uint64_t validation_purpose = 0, audit_purpose = 0x6175646974ull;  // "audit"
constexpr std::uint64_t largest_count = (std::uint64_t{1} << 48) - 1;

std::uint32_t later(std::uint32_t generation) { return std::max(generation + 1, generation); }

/// Attributes as a table keeps them.
Mixture rounded(const Mixture& fit) {
  std::vector<float> memory(PackedMixture::bytes_of(fit.component_count) / sizeof(float));
  return *PackedMixture::put(memory.data(), fit, 0);
}

}  // namespace

void ServiceModel::Scores::add(double residual, double q, double variation) {
  const double score = residual * residual / (q * variation);
  fixed.push_back(static_cast<std::uint64_t>((score > 0 ? std::min(score, 4.0) : 0.0) * 0x1p38 + 0.5));
}

double ServiceModel::Scores::mean() const {
  std::uint64_t sum = 0;
  for (const std::uint64_t one : fixed) sum += one;
  return static_cast<double>(sum) / static_cast<double>(fixed.size()) * 0x1p-38;
}

double ServiceModel::Scores::standard_error() const {
  Wide sum = 0;
  for (const std::uint64_t one : fixed) sum += static_cast<Wide>(one) * one;
  const auto n = static_cast<double>(fixed.size());
  const double square = static_cast<double>(sum) / n * 0x1p-76;
  const double variance = std::max(0.0, (square - mean() * mean()) * (n / (n - 1)));
  return std::sqrt(variance / n);
}

void ServiceModel::add_slice(const SliceDescription& description) {
  for (const Slice& slice : slices_) {
    if (slice.description.key == description.key) return;
  }
  Slice slice{description, {}, false};
  for (std::uint32_t n = 0; n < description.node_count(); ++n) slice.nodes[n];
  slices_.push_back(std::move(slice));
  const auto cached = unused_.find(description.key);
  if (cached == unused_.end()) return;
  std::vector<std::pair<Place, CachedRow>> rows;
  for (const CachedRow& row : cached->second.rows) rows.push_back({{slices_.size() - 1, row.node}, row});
  unused_.erase(cached);
  resume(rows);
}

void ServiceModel::load(const TableSnapshot& image) {
  changes_.clear();
  std::vector<std::pair<Place, CachedRow>> rows;
  for (const CachedSlice& cached : image.slices) {
    const auto slice =
        std::ranges::find(slices_, cached.description.key, [](const Slice& p) { return p.description.key; });
    if (slice == slices_.end()) {
      unused_[cached.description.key] = cached;
      continue;
    }
    const auto index = static_cast<std::size_t>(slice - slices_.begin());
    for (const CachedRow& row : cached.rows) rows.push_back({{index, row.node}, row});
  }
  resume(rows);
}

void ServiceModel::resume(const std::vector<std::pair<Place, CachedRow>>& rows) {
  // Those that answer at once first, then by key and node.
  const auto answers = [&](const CachedRow& row) {
    return row.state == RowState::converged && row.objective <= options_.epsilon;
  };
  std::vector<std::pair<Place, CachedRow>> sorted = rows;
  std::ranges::sort(sorted, [&](const auto& x, const auto& y) {
    const auto key = [&](const auto& row) {
      return std::tuple(!answers(row.second), slices_[row.first.slice].description.key, row.first.node);
    };
    return key(x) < key(y);
  });
  for (const auto& [place, cached] : sorted) take(place, cached);
  std::ranges::sort(changes_);
}

void ServiceModel::take(Place place, const CachedRow& cached) {
  const SliceDescription& slice = slices_[place.slice].description;
  Row row;
  row.generation = cached.generation;
  row.order = births_++;
  if (cached.state == RowState::converged && cached.objective <= options_.epsilon) {
    row.state = RowState::converged;
    row.count = std::min(cached.count, largest_count);
    row.energy = cached.energy;
    row.objective = cached.objective;
    row.knots = cached.knots;
    row.has_fit = cached.knots.empty();
    row.fit = rounded(cached.fit);
    row.audit_due = stream(place, 0).next_bits() % 8 == 0;
    row.audit_possible = !row.audit_due;
  } else {
    ++before_.traces;
    open(place, row, trace(place));
    row.count = cached.count;
    if (cached.state == RowState::converged) {
      row.fit = cached.fit;
      row.has_fit = cached.knots.empty();
      row.objective = cached.objective;
      row.earlier = cached;
    }
    row.sketch->merge(cached.sketch);
    double sum = 0;
    const std::vector<ObservedPair> pairs = row.sketch->pairs();
    for (const ObservedPair& pair : pairs) {
      const double change = static_cast<double>(row.nodes->density(pair.azimuth)) - pair.g;
      sum += change * change;
    }
    const double mean =
        pairs.empty() ? 0 : sum * (2 * std::numbers::pi) / (static_cast<double>(pairs.size()) * row.nodes->variation());
    if (mean > options_.epsilon / 4) {
      row.sketch->clear();
      row.count = 0;
      row.generation = later(row.generation);
      ++reopened_;
    }
    begin(row, slice, before_);
  }
  changes_.emplace_back(place.slice, place.node, row.state);
  at(place).row = std::move(row);
}

void ServiceModel::ask(std::size_t slice, std::uint32_t node, Ask how, float u) {
  Node& asked = at({slice, node});
  ++asked.queries;
  if (!asked.row) {
    if (!asked.traced) ++before_.traces;
    asked.traced = true;
    return;
  }
  Row& row = *asked.row;
  if (how == Ask::look || row.state != RowState::open || !learns_) return;
  const Mixture proposal = how == Ask::score && row.has_fit ? row.fit : Mixture{};
  const float x = proposal.sample(u, options_.uniform_share_open);
  const float g = row.nodes->density(x);
  offer(row, x, g);
  ++row.observed;
  if (how != Ask::score || !row.has_fit) return;
  const float q = proposal.proposal_density(x, options_.uniform_share_open);
  row.scores.add(static_cast<double>(g) - row.fit.density(x), q, row.nodes->variation());
}

void ServiceModel::carry(std::size_t slice, std::uint32_t node, float light) {
  at({slice, node}).light += static_cast<std::uint64_t>(light * 0x1p20f);
}

std::vector<ServiceModel::Place> ServiceModel::rows_by_birth() {
  std::map<std::uint64_t, Place> sorted;
  for (std::size_t p = 0; p < slices_.size(); ++p) {
    for (const auto& [n, node] : slices_[p].nodes) {
      if (node.row) sorted[node.row->order] = {p, n};
    }
  }
  std::vector<Place> places;
  for (const auto& [order, place] : sorted) places.push_back(place);
  return places;
}

PassReport ServiceModel::publish() {
  PassReport report = std::exchange(before_, PassReport{});
  changes_.clear();
  ++pass_;
  std::vector<Place> to_be_born;
  for (std::size_t p = 0; p < slices_.size(); ++p) {
    for (const auto& [n, node] : slices_[p].nodes) {
      report.rows_queried += node.queries > 0 ? 1 : 0;
      report.queries += node.queries - node.queries_before;
      if (node.row && node.row->state == RowState::converged) {
        report.converged_queries += node.queries - node.queries_before;
      }
      if (!node.row && learns_ && node.queries > 0 && node.queries >= options_.queries_before_creation)
        to_be_born.push_back({p, n});
    }
  }
  if (learns_) {
    std::vector<Place> dirty;
    for (const Place place : rows_by_birth()) {
      const Node& node = at(place);
      const Row& row = *node.row;
      bool& audited = slices_[place.slice].audited;
      const bool asked = node.queries != node.queries_before;
      const bool audits = row.audit_due || (row.audit_possible && !audited);
      if (row.state == RowState::open && (asked || row.observed > 0)) dirty.push_back(place);
      if (row.state == RowState::converged && audits && asked) {
        dirty.push_back(place);
        audited = true;
      }
    }
    std::set<std::size_t> misfitting;
    for (const Place place : dirty) {
      if (at(place).row->state == RowState::open) {
        update(place, report);
      } else if (audit(place, report)) {
        reopen(place, report);
        misfitting.insert(place.slice);
      }
    }
    for (const Place place : rows_by_birth()) {
      Row& row = *at(place).row;
      if (row.audit_possible && misfitting.contains(place.slice)) {
        row.audit_possible = false;
        row.audit_due = true;
      }
    }
  }
  std::ranges::sort(to_be_born, [&](Place x, Place y) {
    const Node &a = at(x), &b = at(y);
    const SliceKey &key_a = slices_[x.slice].description.key, &key_b = slices_[y.slice].description.key;
    return std::tuple(b.light, b.queries, key_a, x.node) < std::tuple(a.light, a.queries, key_b, y.node);
  });
  for (const Place place : to_be_born) {
    Row row;
    row.order = births_++;
    if (!at(place).traced) ++report.traces;
    open(place, row, trace(place));
    begin(row, slices_[place.slice].description, report);
    at(place).row = std::move(row);
    changes_.emplace_back(place.slice, place.node, RowState::open);
    ++report.creations;
  }
  for (Slice& slice : slices_) {
    for (auto& [n, node] : slice.nodes) {
      node.queries_before = node.queries;
      node.traced = false;
      if (!node.row) continue;
      const Row& row = *node.row;
      report.rows_open += row.state == RowState::open ? 1 : 0;
      report.rows_refused += row.state == RowState::refused ? 1 : 0;
      report.rows_converged += row.state == RowState::converged ? 1 : 0;
      if (row.state == RowState::converged && row.has_fit) ++report.components[row.fit.component_count];
      if (row.objective >= 0) report.objective_max = std::max<double>(report.objective_max, row.objective);
    }
  }
  report.rows_reopened = reopened_;
  std::ranges::sort(changes_);
  return report;
}

RandomStream ServiceModel::stream(Place place, std::uint64_t purpose) const {
  const SliceKey& key = slices_[place.slice].description.key;
  std::uint64_t mixed = mix_bits(options_.seed + purpose) ^ key.lobe;
  for (const float parameter : key.parameters) mixed = mix_bits(mixed) ^ std::bit_cast<std::uint32_t>(parameter + 0.0f);
  return RandomStream(mixed, place.node, pass_);
}

std::shared_ptr<const TracedNodes> ServiceModel::trace(Place place) const {
  const SliceDescription& slice = slices_[place.slice].description;
  std::vector<TracedRay> rays;
  const std::size_t width = slice.axis_b.size();
  target_.trace(slice, slice.axis_a[place.node / width], slice.axis_b[place.node % width], rays);
  return std::make_shared<const TracedNodes>(rays, slice.blur_rad);
}

void ServiceModel::open(Place place, Row& row, std::shared_ptr<const TracedNodes> nodes) {
  row.state = RowState::open;
  row.nodes = std::move(nodes);
  row.energy = row.nodes->energy();
  row.sketch = std::make_shared<Sketch>(Sketch::bin_count(row.nodes->blur_rad()));
  row.created_pass = pass_;
  row.queries_at_creation = at(place).queries;
}

void ServiceModel::begin(Row& row, const SliceDescription& slice, PassReport& report) {
  if (row.sketch->occupied() == 0) cover(row, report);
  if (row.has_fit) {
    row.bins_at_fit = row.sketch->occupied();
    row.count_at_fit = row.count;
  } else {
    refit(row, slice, report);
  }
}

void ServiceModel::offer(Row& row, float x, float g) { row.sketch->offer(x, g); }

void ServiceModel::cover(Row& row, PassReport& report) {
  for (const float x : gap_fill_azimuths(row.sketch->pairs(), row.nodes->blur_rad())) {
    ask_g(row, x, report);
  }
}

void ServiceModel::ask_g(Row& row, float x, PassReport& report) {
  offer(row, x, row.nodes->density(x));
  ++row.count;
  ++report.g_evaluations;
}

namespace {

/// From each pair to the next on the circle.
std::vector<double> gaps(const std::vector<ObservedPair>& pairs) {
  std::vector<double> result;
  for (std::size_t i = 0; i + 1 < pairs.size(); ++i) {
    result.push_back(static_cast<double>(pairs[i + 1].azimuth) - static_cast<double>(pairs[i].azimuth));
  }
  const double first = pairs.front().azimuth, last = pairs.back().azimuth;
  result.push_back(first + 2 * std::numbers::pi - last);
  return result;
}

}  // namespace

double ServiceModel::largest_error(Row& row, PassReport& report) {
  const std::span<const float> grid = row.nodes->grid();
  const auto azimuth = [](std::size_t i, std::size_t n) {
    const double turns = static_cast<double>(i) / static_cast<double>(n) - 0.5;
    return wrap_angle(static_cast<float>(turns * 2 * std::numbers::pi));
  };
  KnownError error = known_error(row.fit, *row.nodes, grid);
  if (error.most > options_.epsilon && error.seen <= options_.epsilon) {
    std::vector<float> finer;
    for (std::size_t i = 0; i < grid.size(); ++i) {
      const float between = azimuth(2 * i + 1, 2 * grid.size());
      ask_g(row, between, report);
      finer.insert(finer.end(), {grid[i], row.nodes->density(between)});
    }
    error = known_error(row.fit, *row.nodes, finer);
  }
  if (error.most > options_.epsilon) {
    for (std::size_t i = 0; i < grid.size(); ++i) offer(row, azimuth(i, grid.size()), grid[i]);
  }
  return error.most;
}

void ServiceModel::refine(Row& row, PassReport& report) {
  const std::vector<ObservedPair> pairs = row.sketch->pairs();
  const std::vector<double> gap = gaps(pairs);
  std::vector<double> off;
  for (const ObservedPair& pair : pairs) {
    off.push_back(std::abs(static_cast<double>(pair.g) - static_cast<double>(row.fit.density(pair.azimuth))));
  }
  std::vector<std::pair<double, std::size_t>> wide;  // the worst first
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (gap[i] > 0.5 * row.nodes->blur_rad()) {
      wide.emplace_back(-(gap[i] * std::max(off[i], off[(i + 1) % pairs.size()])), i);
    }
  }
  std::ranges::sort(wide);
  wide.resize(std::min(wide.size(), std::size_t{12}));
  for (const auto& [rank, i] : wide) ask_g(row, static_cast<float>(pairs[i].azimuth + gap[i] / 2), report);
}

bool ServiceModel::refit(Row& row, const SliceDescription& slice, PassReport& report) {
  const std::vector<ObservedPair> pairs = row.sketch->pairs();
  if (pairs.empty()) return false;
  const bool grown = 20 * pairs.size() >= 21 * std::size_t{row.bins_at_fit};  // by 5 %
  if (row.has_fit && !grown && row.count < 2 * row.count_at_fit) return false;
  FitSettings settings;
  settings.epsilon = options_.epsilon;
  settings.max_components = static_cast<int>(std::min(options_.max_components, slice.max_components));
  settings.restart = row.count >= 64 && row.last_failed;
  row.fit = fit_mixture(pairs, row.nodes->energy(), row.nodes->variation(), row.has_fit ? &row.fit : nullptr, settings)
                .mixture;
  row.has_fit = true;
  row.bins_at_fit = static_cast<std::uint32_t>(pairs.size());
  row.count_at_fit = row.count;
  ++report.refits;
  return true;
}

bool ServiceModel::test(Row& row, PassReport& report) {
  if (row.scores.fixed.size() < (options_.epsilon < 0.01 ? 24u : 16u)) return false;
  row.bound = static_cast<float>(row.scores.mean() + 2 * row.scores.standard_error());
  row.scores.fixed.clear();
  const std::uint32_t needed = options_.epsilon < 0.01 ? 3 : 2;
  row.last_failed = !(row.bound <= options_.epsilon);
  row.overruled = false;
  if (!row.last_failed && row.passed + 1 >= needed) {
    row.bound = std::max(row.bound, static_cast<float>(largest_error(row, report)));
    row.last_failed = row.overruled = !(row.bound <= options_.epsilon);
  }
  row.objective = row.bound;
  if (row.last_failed) {
    row.passed = 0;
    row.largest_passed = 0;
    if (++row.failed >= options_.tests_before_refusal) row.state = RowState::refused;
    return row.state == RowState::refused;
  }
  row.largest_passed = std::max(row.largest_passed, row.bound);
  if (++row.passed < needed) return false;
  row.objective = row.largest_passed;
  row.state = RowState::converged;
  return true;
}

void ServiceModel::update(Place place, PassReport& report) {
  Node& node = at(place);
  Row& row = *node.row;
  report.g_evaluations += row.observed;
  row.count += std::exchange(row.observed, 0);
  cover(row, report);
  const std::size_t wanted = options_.epsilon < 0.01 ? 24 : 16;
  if (row.created_pass < pass_ && row.has_fit && node.queries - row.queries_at_creation >= 8) {
    RandomStream random = stream(place, validation_purpose);
    while (row.scores.fixed.size() < wanted) {
      const float x = row.fit.sample(random.next(), options_.uniform_share_open);
      const float g = row.nodes->density(x);
      row.scores.add(static_cast<double>(g) - row.fit.density(x),
                     row.fit.proposal_density(x, options_.uniform_share_open), row.nodes->variation());
      offer(row, x, g);
      ++row.count;
      ++report.g_evaluations;
      ++report.validation_draws;
    }
  }
  const bool decided = row.has_fit && test(row, report);
  if (!decided && row.has_fit && (row.overruled || (row.last_failed && row.count >= 64))) refine(row, report);
  const bool fitted = !decided && refit(row, slices_[place.slice].description, report);
  if (decided || fitted) changes_.emplace_back(place.slice, place.node, row.state);
  if (row.state != RowState::converged) return;
  assign_attributes(row.fit, *row.nodes);
  row.fit = rounded(row.fit);
  row.count = std::min(row.count, largest_count);
  row.failed = std::min(row.failed, 255u);
  row.nodes.reset();
  row.sketch.reset();
  row.earlier.reset();
  ++report.newly_converged;
}

bool ServiceModel::audit(Place place, PassReport& report) {
  Row& row = *at(place).row;
  row.audit_due = row.audit_possible = false;
  const std::shared_ptr<const TracedNodes> nodes = trace(place);
  RandomStream random = stream(place, audit_purpose);
  const float share = options_.uniform_share_open;
  Scores scores;
  for (int i = 0; i < 64; ++i) {
    const float u = random.next();
    const float x = row.has_fit ? row.fit.sample(u, share) : row.knots.sample(u, share);
    const float q = row.has_fit ? row.fit.proposal_density(x, share) : row.knots.proposal_density(x, share);
    const float f = row.has_fit ? row.fit.density(x) : row.knots.density(x);
    scores.add(static_cast<double>(nodes->density(x)) - f, q, nodes->variation());
  }
  ++report.traces;
  report.g_evaluations += 64;
  return scores.mean() - 2 * scores.standard_error() > std::max<double>(options_.epsilon, row.objective);
}

void ServiceModel::reopen(Place place, PassReport& report) {
  Node& node = at(place);
  Row fresh;
  fresh.generation = later(node.row->generation);
  fresh.failed = node.row->failed;
  fresh.order = node.row->order;
  open(place, fresh, trace(place));
  begin(fresh, slices_[place.slice].description, report);
  node.row = std::move(fresh);
  ++reopened_;
  changes_.emplace_back(place.slice, place.node, RowState::open);
}

RowState ServiceModel::state(std::size_t slice, std::uint32_t node) const {
  const std::optional<Row>& row = slices_[slice].nodes.at(node).row;
  return row ? row->state : RowState::absent;
}

std::optional<Mixture> ServiceModel::published(std::size_t slice, std::uint32_t node) const {
  const std::optional<Row>& row = slices_[slice].nodes.at(node).row;
  if (!row || !row->has_fit) return std::nullopt;
  return rounded(row->fit);
}

float ServiceModel::objective(std::size_t slice, std::uint32_t node) const {
  const std::optional<Row>& row = slices_[slice].nodes.at(node).row;
  return row && row->objective >= 0 ? row->objective : 1;
}

TableSnapshot ServiceModel::snapshot() const {
  std::map<SliceKey, CachedSlice> all = unused_;
  for (const Slice& slice : slices_) {
    CachedSlice cached{slice.description, {}};
    for (const auto& [n, node] : slice.nodes) {
      if (!node.row) continue;
      const Row& row = *node.row;
      if (row.earlier && row.state != RowState::converged) {
        cached.rows.push_back(*row.earlier);
        continue;
      }
      CachedRow saved;
      saved.node = n;
      saved.state = row.state == RowState::converged ? RowState::converged : RowState::open;
      saved.generation = row.generation;
      saved.count = row.count;
      saved.energy = row.energy;
      if (saved.state == RowState::open) {
        saved.sketch = row.sketch->bins();
      } else {
        saved.objective = row.objective;
        saved.fit = row.fit;
        saved.knots = row.knots;
      }
      cached.rows.push_back(std::move(saved));
    }
    if (!cached.rows.empty()) all[slice.description.key] = std::move(cached);
  }
  TableSnapshot image{target_.model_name(), {}};
  for (auto& [key, slice] : all) image.slices.push_back(std::move(slice));
  return image;
}

}  // namespace tress::adaptive
