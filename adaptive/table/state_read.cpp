// Reads a table from bytes that state_write.cpp made, or from any others. All is checked before any is taken over.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cache/format.h"
#include "cache/reader.h"
#include "table/saved_table.h"
#include "table/table.h"

namespace tress::adaptive {
namespace {

using namespace state_format;

Error bad_state(const std::string& what, const std::string& found) { return {"", "table", what, found}; }

std::string described(const SliceDescription& slice) {
  ByteWriter out;
  format::write_description(out, slice, format::version_of_samples);
  return out.take();
}

bool is_finite(const Mixture& fit) {
  const auto good = [](const Component& part) {
    return std::isfinite(part.attribute_mean) && std::isfinite(part.attribute_variance);
  };
  return std::isfinite(fit.uniform_attribute_mean) && std::isfinite(fit.uniform_attribute_variance) &&
         std::ranges::all_of(fit.parts(), good);
}

}  // namespace

/// Reads the plain data of a state. The first fault ends the reading and is in `error`.
class Service::Table::StateReader {
 public:
  explicit StateReader(const std::string& bytes) : source_(bytes), in_(&source_, 0, bytes.size()) {}

  bool read(const Table& table, SavedTable& saved) {
    saved.version = in_.u32();
    if (saved.version != state_version)
      return fail("state version " + std::to_string(state_version), std::to_string(saved.version));
    return names(table) && totals(saved) && slices(table, saved) && unused(table, saved) && rows(table, saved) &&
           (in_.remaining() == 0 || fail("the end", std::to_string(in_.remaining()) + " more bytes"));
  }
  std::optional<Error> error;

 private:
  bool fail(const std::string& expected, const std::string& found) {
    if (!error) error = bad_state(expected, in_.short_of_bytes() ? "the end of the state" : found);
    return false;
  }
  bool whole() { return !in_.short_of_bytes() || fail("more bytes", "the end of the state"); }
  bool flag(bool& value) {
    const std::uint8_t byte = in_.u8();
    value = byte != 0;
    return byte <= 1 || fail("0 or 1", std::to_string(byte));
  }
  bool number(float& value, const char* what) {
    value = in_.f32();
    return std::isfinite(value) || fail(what, std::to_string(value));
  }
  bool count(std::size_t size, std::uint32_t& number, const char* what) {
    number = in_.u32();
    return whole() && (number <= in_.remaining() / size || fail(what, std::to_string(number)));
  }
  bool text(std::string& value) {
    std::uint32_t size = 0;
    if (!count(1, size, "a text within the bytes that remain")) return false;
    value.clear();
    while (value.size() < size) {
      const std::string_view piece = in_.text(std::min<std::size_t>(size - value.size(), ByteReader::largest_buffer));
      if (piece.empty()) return whole();
      value += piece;
    }
    return true;
  }
  bool is_text(const std::string& expected, const char* what) {
    std::string found;
    return text(found) && (found == expected || fail(std::string(what) + " " + expected, found.substr(0, 80)));
  }

  bool names(const Table& table) {
    return is_text(table.model_name(), "model") && is_text(table.options_.learner->name, "learner");
  }

  bool totals(SavedTable& saved) {
    saved.pass = in_.u32();
    for (std::uint64_t* total : {&saved.paths, &saved.reopened, &saved.reopened_told, &saved.queried})
      *total = in_.u64();
    if (!whole() || saved.pass == 0) return fail("a pass above 0", std::to_string(saved.pass));
    std::uint32_t errors = 0;
    if (!flag(saved.ceiling_told) || !flag(saved.unusable_told) || !count(12, errors, "so many errors")) return false;
    for (std::uint32_t i = 0; i < errors; ++i) {
      const std::uint32_t bits = in_.u32();
      if (!(std::bit_cast<float>(bits) > 0) || !std::isfinite(std::bit_cast<float>(bits)))
        return fail("an error above 0", std::to_string(std::bit_cast<float>(bits)));
      saved.absorbed_errors.add_counted(bits, in_.u64());
    }
    return whole();
  }

  bool slices(const Table& table, SavedTable& saved) {
    const std::uint32_t slices = in_.u32();
    if (slices != table.slices_.size())
      return fail(std::to_string(table.slices_.size()) + " slices", std::to_string(slices));
    for (const std::unique_ptr<Slice>& own : table.slices_) {
      std::string description;
      bool has_index = false;
      if (!text(description)) return false;
      if (description != described(own->description))
        return fail("slice " + std::to_string(saved.slices.size()) + " as it was added", "another");
      if (!flag(has_index)) return false;
      if (has_index != own->has_index()) return fail("as much room for indices", "another ceiling");
      saved.slices.emplace_back(own->description);
      if (!slice(*own, saved.slices.back())) return false;
    }
    return true;
  }

  bool slice(const Slice& own, SavedSlice& saved) {
    std::uint32_t nodes = 0;
    if (!flag(saved.audited) || !count(20, nodes, "so many nodes")) return false;
    std::uint32_t least = 0;
    for (std::uint32_t i = 0; i < nodes; ++i) {
      const SavedNode node{in_.u32(), in_.u32(), in_.u32(), in_.u64()};
      if (!own.has_index() || node.node < least || node.node >= own.description.node_count())
        return fail("an ascending node of the slice", std::to_string(node.node));
      least = node.node + 1;
      saved.nodes.push_back(node);
    }
    if (!saved.answers.read(in_) || !saved.stored.read(in_) || !saved.earlier.read(in_))
      return fail("packed rows within the bytes that remain", "more");
    std::uint32_t interpolated = 0;
    if (!count(4, interpolated, "so many interpolated nodes")) return false;
    for (std::uint32_t i = 0; i < interpolated; ++i) {
      const std::uint32_t node = saved.interpolated.emplace_back(in_.u32());
      const bool ascends = i == 0 || node > saved.interpolated[i - 1];
      if (!own.is_sampled() || !ascends || node >= own.description.node_count())
        return fail("an ascending node of a slice of samples", std::to_string(node));
    }
    if (!heard(own, saved)) return false;
    std::uint32_t forms = in_.u32();
    if (forms != own.forms.size()) return fail(std::to_string(own.forms.size()) + " forms", std::to_string(forms));
    for (; forms > 0; --forms) {
      std::uint32_t made = 0;
      if (!count(4, made, "so many forms of rows")) return false;
      std::vector<std::uint32_t>& of_form = saved.made.emplace_back();
      for (std::uint32_t i = 0; i < made; ++i) of_form.push_back(in_.u32());
    }
    return whole();
  }

  bool heard(const Slice& own, SavedSlice& saved) {
    saved.heard_paths = in_.u64();
    std::uint32_t nodes = 0;
    if (!count(8, nodes, "so many nodes with paths")) return false;
    for (std::uint32_t i = 0; i < nodes; ++i) {
      const std::uint32_t node = in_.u32();
      std::uint32_t exits = 0;
      if (!count(17, exits, "so many paths")) return false;
      const bool ascends = i == 0 || node > saved.heard.back().first;
      if (!own.is_sampled() || !ascends || node >= own.description.node_count() || exits > HeardExits::most)
        return fail("an ascending node with as many paths as are kept", std::to_string(node));
      std::vector<SampledExit>& of_node = saved.heard.emplace_back(node, std::vector<SampledExit>()).second;
      for (std::uint32_t k = 0; k < exits; ++k) {
        SampledExit& exit = of_node.emplace_back();
        for (float* number : {&exit.azimuth, &exit.height, &exit.weight, &exit.attribute}) *number = in_.f32();
        exit.part = in_.u8();
        if (!is_exit(exit, SampledTarget::most_parts)) return fail("exits of paths", "others");
      }
    }
    return whole();
  }

  bool unused(const Table& table, SavedTable& saved) {
    std::uint32_t slices = 0;
    if (!count(4, slices, "so many slices")) return false;
    for (std::uint32_t i = 0; i < slices; ++i) {
      std::string bytes;
      if (!text(bytes)) return false;
      const MemoryBytes source(bytes);
      CacheReader rows(source, "unused slices");
      if (!rows.check(table.model_name())) return fail("slices as of a cache", rows.error().message());
      while (const SliceDescription* slice = rows.next_slice()) {
        PackedSlice& packed = saved.unused.insert_or_assign(slice->key, PackedSlice(*slice)).first->second;
        while (const CachedRow* row = rows.next_row()) packed.add(*row);
      }
    }
    return true;
  }

  bool rows(const Table& table, SavedTable& saved) {
    std::uint32_t rows = 0;
    if (!count(27, rows, "so many rows")) return false;
    saved.rows.reserve(rows);
    for (SavedSlice& slice : saved.slices) slice.row_of_node.assign(slice.node_count(), Slot::no_row);
    for (std::uint32_t i = 0; i < rows; ++i) {
      SavedRow& row = saved.rows.emplace_back();
      if (!this->row(table, row)) return false;
      std::uint32_t& place = saved.slices[row.slice].row_of_node[row.node];
      if (place != Slot::no_row) return fail("one row for each node", "two");
      place = i;
    }
    return true;
  }

  bool row(const Table& table, SavedRow& row) {
    row.slice = in_.u32();
    row.node = in_.u32();
    const std::uint8_t kind = in_.u8(), marks = in_.u8();
    const auto audit = static_cast<std::uint8_t>(marks & ~state_format::converged_row);
    row.failed = in_.u8();
    if (!whole() || row.slice >= table.slices_.size() || !table.slices_[row.slice]->has_index() ||
        row.node >= table.slices_[row.slice]->description.node_count())
      return fail("a row of a node", "another");
    if (kind > 2 || audit > static_cast<std::uint8_t>(Audit::due)) return fail("a kind of row", std::to_string(kind));
    row.kind = static_cast<Kind>(kind);
    row.audit = static_cast<Audit>(audit);
    row.has_converged = (marks & state_format::converged_row) != 0;
    if (!number(row.energy, "an energy")) return false;
    row.generation = in_.u32();
    row.count = in_.u64();
    const bool sampled = table.slices_[row.slice]->is_sampled();
    if (row.kind == Kind::answer) return whole();
    if (sampled != (row.kind == Kind::refusal)) return fail("a row as of its slice", "one of the other kind");
    return row.kind == Kind::refusal ? whole() : learning(table, row);
  }

  bool learning(const Table& table, SavedRow& row) {
    std::uint32_t bins = 0, words = 0;
    if (!count(12, bins, "so many bins")) return false;
    const std::uint32_t most = Sketch::bin_count(table.slices_[row.slice]->description.blur_rad);
    for (std::uint32_t i = 0; i < bins; ++i) {
      const SketchBin bin{in_.u32(), in_.u64()};
      const float g = std::bit_cast<float>(static_cast<std::uint32_t>(bin.bits));
      if (bin.index >= most || !std::isfinite(g) || std::signbit(g)) return fail("bins of a sketch", "others");
      row.sketch.push_back(bin);
    }
    if (!count(8, words, "so many words")) return false;
    std::vector<std::uint64_t> state(words);
    for (std::uint64_t& word : state) word = in_.u64();
    row.learner = table.options_.learner->make();
    if (!whole() || !row.learner->set_state(state)) return fail("the state of a learner", "another");
    return stop(row.stop) && flag(row.has_fit) && fit(row.fit) && number(row.objective, "an objective") && rest(row);
  }

  bool stop(StopTest::State& stop) {
    for (std::uint64_t& word : stop.scores) word = in_.u64();
    const std::uint8_t verdict = in_.u8();
    stop.verdict = static_cast<StopTest::Verdict>(verdict);
    if (stop.verdict != StopTest::Verdict::undecided && stop.verdict != StopTest::Verdict::refused)
      return fail("an open or refused row", std::to_string(verdict));
    if (!number(stop.bound, "a bound") || !number(stop.largest_passed, "a bound")) return false;
    stop.passed = in_.u32();
    stop.failed = in_.u32();
    return flag(stop.last_failed) && flag(stop.overruled);
  }

  bool fit(Mixture& fit) {
    fit.component_count = in_.u32();
    if (fit.component_count > Mixture::max_components)
      return fail("at most 8 components", std::to_string(fit.component_count));
    for (float* value : {&fit.uniform_weight, &fit.uniform_attribute_mean, &fit.uniform_attribute_variance})
      *value = in_.f32();
    for (std::uint32_t i = 0; i < fit.component_count; ++i) {
      Component& part = fit.components[i];
      for (float* value : {&part.shape.mu, &part.shape.s_left, &part.shape.s_right, &part.weight, &part.attribute_mean,
                           &part.attribute_variance})
        *value = in_.f32();
    }
    return whole();
  }

  bool rest(SavedRow& row) {
    row.taught = in_.u64();
    if (!flag(row.is_published) || !flag(row.has_earlier)) return false;
    row.created_pass = in_.u32();
    row.queries_at_creation = in_.u32();
    row.observed = in_.u64();
    for (std::uint64_t& word : row.weights) word = in_.u64();
    return whole();
  }

  MemoryBytes source_;
  ByteReader in_;
};

std::optional<Error> Service::Table::restore(const std::string& bytes) {
  if (pass_ != 0 || !rows_.empty() || !unused_.empty() ||
      std::ranges::any_of(slices_, [](const auto& slice) { return !slice->stored.empty(); }))
    return bad_state("a service that has loaded nothing and published no pass", "another");
  SavedTable saved;
  StateReader reader(bytes);
  if (!reader.read(*this, saved)) return reader.error;
  if (std::optional<Error> error = rebuild(saved)) return error;
  take_over(saved);
  return std::nullopt;
}

std::optional<Error> Service::Table::rebuild(SavedTable& saved) {
  for (const auto& [key, rows] : saved.unused) {
    if (slice_of_key_.contains(key)) return bad_state("slices that nobody uses", "one that is used");
  }
  for (std::size_t id = 0; id < saved.slices.size(); ++id) {
    SavedSlice& slice = saved.slices[id];
    if (std::optional<Error> error = check_rows(saved, static_cast<SliceId>(id))) return error;
    for (const std::vector<std::uint32_t>& made : slice.made) {
      for (const std::uint32_t node : made) {
        const bool is_node = node < slice.row_of_node.size();
        const bool is_row = is_node && slice.row_of_node[node] != Slot::no_row;
        if (!is_node ||
            (is_row ? saved.rows[slice.row_of_node[node]].kind != Kind::answer : !slices_[id]->is_sampled()))
          return bad_state("forms of nodes that are answered", "another");
      }
    }
  }
  std::atomic<bool> legal{true};
  tbb::parallel_for(std::size_t{0}, saved.rows.size(), [&](std::size_t i) {
    SavedRow& row = saved.rows[i];
    if (row.kind != Kind::learning) return;
    row.nodes = trace(row.slice, row.node);
    if (!row.nodes ||
        (row.has_fit && !(is_legal(row.fit, Mixture::max_components, row.nodes->energy()) && is_finite(row.fit))))
      legal = false;
  });
  return legal ? std::nullopt
               : std::optional(bad_state("targets that can be traced, and fits within their bounds", "another"));
}

std::optional<Error> Service::Table::check_rows(SavedTable& saved, SliceId id) const {
  SavedSlice& slice = saved.slices[id];
  const auto row_at = [&](std::uint32_t node) -> SavedRow* {
    const std::uint32_t row = slice.row_of_node.empty() ? Slot::no_row : slice.row_of_node[node];
    return row == Slot::no_row ? nullptr : &saved.rows[row];
  };
  std::uint32_t answers = 0, earlier = 0;
  for (const SavedRow& row : saved.rows) {
    if (row.slice != id) continue;
    answers += row.kind == Kind::answer ? 1 : 0;
    earlier += row.has_earlier ? 1 : 0;
  }
  if (slice.answers.rows() != answers || slice.earlier.rows() != earlier)
    return bad_state("an answer for each converged row", "others");
  bool good = true;
  const auto each = [&](const PackedSlice& packed, const auto& check) {
    PackedSliceRows rows(packed, model_name());
    (void)rows.next_slice();
    while (const CachedRow* row = rows.next_row())
      good = good && may_answer(*slices_[id], *row) && check(*row, row_at(row->node));
    good = good && !rows.failure();
  };
  each(slice.answers, [](const CachedRow& row, SavedRow* of) {
    return row.state == RowState::converged && of != nullptr && of->kind == Kind::answer;
  });
  each(slice.stored, [](const CachedRow&, const SavedRow* of) { return of == nullptr; });
  each(slice.earlier, [](const CachedRow& row, SavedRow* of) {
    if (of == nullptr || !of->has_earlier) return false;
    of->earlier = std::make_unique<const CachedRow>(row);
    return true;
  });
  return good ? std::nullopt : std::optional(bad_state("packed rows as of a cache, each of its row", "others"));
}

void Service::Table::take_over(SavedTable& saved) {
  pass_ = saved.pass;
  light_.paths = saved.paths;
  reopened_ = saved.reopened;
  reopened_told_ = saved.reopened_told;
  light_.queried = saved.queried;
  ceiling_told_ = saved.ceiling_told;
  unusable_told_ = saved.unusable_told;
  absorbed_errors_ = std::move(saved.absorbed_errors);
  unused_ = std::move(saved.unused);
  for (SavedRow& row : saved.rows) take_row(row);
  for (std::size_t id = 0; id < saved.slices.size(); ++id) take_slice(saved, saved.slices[id], *slices_[id]);
  for (const Row& row : rows_) bytes_ += bytes_of(row);
}

void Service::Table::take_row(SavedRow& saved) {
  slices_[saved.slice]->slots[saved.node].row = static_cast<std::uint32_t>(rows_.size());
  Row& row = rows_.emplace_back(saved.slice, saved.node);
  Slot& slot = slot_of(row);
  row.energy = saved.energy;
  row.generation = saved.generation;
  row.audit = saved.audit;
  row.set_count(saved.count);
  row.set_failed(saved.failed);
  if (saved.kind == Kind::refusal) slot.set<RibbonAnswer>(nullptr, Slot::Kind::refusal);
  if (saved.kind != Kind::learning) return;
  row.learning = std::make_unique<Learning>(std::move(saved.nodes), *options_.learner);
  Learning& learning = *row.learning;
  learning.learner = std::move(saved.learner);
  learning.sketch.merge(saved.sketch);
  learning.stop.set_state(saved.stop);
  learning.fit = saved.fit;
  learning.has_fit = saved.has_fit;
  learning.objective = saved.objective;
  learning.count = saved.taught;
  learning.earlier = std::move(saved.earlier);
  learning.created_pass = saved.created_pass;
  learning.queries_at_creation = saved.queries_at_creation;
  learning.observed.store(saved.observed, std::memory_order_relaxed);
  learning.weights.set_words(saved.weights);
  if (saved.is_published && saved.has_fit) learning.published = mixtures_.put(learning.fit, learning.objective);
  slot.set(&learning, Slot::Kind::learning);
}

void Service::Table::take_slice(const SavedTable& all, SavedSlice& saved, Slice& slice) {
  slice.audited = saved.audited;
  for (const SavedNode& node : saved.nodes) {
    slice.slots[node.node].queries.store(node.queries, std::memory_order_relaxed);
    slice.queries_before[node.node] = node.queries;
    slice.events[node.node].store(node.events, std::memory_order_relaxed);
    slice.light[node.node].store(node.light, std::memory_order_relaxed);
  }
  PackedSliceRows answers(saved.answers, model_name());
  (void)answers.next_slice();
  while (const CachedRow* row = answers.next_row()) {
    const std::uint32_t index = slice.slots[row->node].row;
    show_cached(rows_[index], *row, all.rows[index].has_converged);
  }
  PackedSliceRows stored(saved.stored, model_name());
  (void)stored.next_slice();
  while (const CachedRow* row = stored.next_row()) slice.stored.insert_or_assign(row->node, *row);
  slice.heard.set_paths(saved.heard_paths);
  for (auto& [node, exits] : saved.heard)
    bytes_ += slice.heard.restore(slice.description.node_count(), node, std::move(exits));
  kept_before_ = &saved.interpolated;
  kept_slice_ = &slice;
  for (const std::uint32_t node : saved.interpolated) (void)answer_of(slice, node, slice.levels.coarse());
  for (std::size_t i = 0; i < saved.made.size(); ++i) {
    for (const std::uint32_t node : saved.made[i]) make_again(forms_.rows(slice.forms[i]), node);
  }
  kept_before_ = nullptr;
}

}  // namespace tress::adaptive
