// A table as bytes between two passes, and the way back. One list of fields serves both directions, in this order:
//
//   u32 state_version; text model, text learner
//   totals: u32 pass, u64 paths, reopened, reopened that were logged, queried, u8 ceiling logged, unusable
//     logged; u32 number of absorbed errors, each u32 bits, u64 count
//   u32 number of slices, each: text description (as in a cache), u8 has an index, then SavedSlice
//   u32 number of unused slices, each: text, a cache file of its own
//   u32 number of rows in order of creation, each: u32 slice, node, u8 kind, u8 audit and whether a row of samples has
//     converged, u8 failed tests, f32 energy, u32 generation, u64 count; the fields of its Learning, if it learns
//
// text: u32 length, bytes. list: u32 number, elements. packed: PackedSlice::write. All is little-endian; floats are
// written by their bits, which keeps a negative zero.

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "cache/byte_source.h"
#include "cache/bytes.h"
#include "cache/format.h"
#include "cache/packed_slice.h"
#include "cache/reader.h"
#include "table/table.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr std::uint32_t state_version = 3;
/// The bit of RibbonAnswer::has_converged in the byte that holds Row::audit.
constexpr std::uint8_t converged_row = 0x80;

Error bad_state(std::string_view expected, std::string_view found) {
  return {"", "table", std::string(expected), std::string(found)};
}

std::string described(std::uint32_t number) { return std::to_string(number); }
std::string described(bool) { return "another"; }
std::string described(const std::string& name) { return name.substr(0, 80); }

/// Appends fields to a state.
class StateWriter {
 public:
  static constexpr bool reads = false;
  void operator()(bool x) { out_.u8(x ? 1 : 0); }
  void operator()(std::uint8_t x) { out_.u8(x); }
  void operator()(std::uint32_t x) { out_.u32(x); }
  void operator()(std::uint64_t x) { out_.u64(x); }
  void operator()(float x) { out_.u32(std::bit_cast<std::uint32_t>(x)); }
  void operator()(const PackedSlice& x) { x.write(out_); }
  void operator()(const std::string& x) {
    out_.u32(static_cast<std::uint32_t>(x.size()));
    out_.text(x);
  }
  void count(std::uint32_t number, std::size_t) { out_.u32(number); }
  bool good() const { return !error; }
  void require(bool is_so, std::string_view expected, std::string_view found) {
    if (!is_so && good()) error = bad_state(expected, found);
  }
  std::string take() { return out_.take(); }

  std::optional<Error> error;  ///< the first

 private:
  ByteWriter out_;
};

/// Reads fields from bytes that may hold anything. After an error it reads on, but no lists; what it reads is unused.
class StateReader {
 public:
  static constexpr bool reads = true;
  explicit StateReader(std::string_view bytes) : source_(bytes), in_(&source_, 0, bytes.size()) {}

  void operator()(bool& x) {
    const std::uint8_t byte = in_.u8();
    require(byte <= 1, "0 or 1", "another byte");
    x = byte != 0;
  }
  void operator()(std::uint8_t& x) { x = in_.u8(); }
  void operator()(std::uint32_t& x) { x = in_.u32(); }
  void operator()(std::uint64_t& x) { x = in_.u64(); }
  void operator()(float& x) { x = in_.f32(); }
  void operator()(PackedSlice& x) { require(x.read(in_), "packed rows within the bytes that remain", "more"); }
  void operator()(std::string& x) {
    std::uint32_t size = 0;
    count(size, 1);
    x.clear();
    while (x.size() < size && good()) {
      x += in_.text(std::min<std::size_t>(size - x.size(), ByteReader::largest_buffer));
      require(true, "", "");
    }
  }
  /// Reads the number of things of at least `size` bytes each; 0 if the bytes that remain cannot hold them.
  void count(std::uint32_t& number, std::size_t size) {
    number = in_.u32();
    require(number <= in_.remaining() / size, "as many as fit into the bytes that remain", std::to_string(number));
    if (!good()) number = 0;
  }
  bool good() const { return !error; }
  void require(bool is_so, std::string_view expected, std::string_view found) {
    if (in_.short_of_bytes() && good()) error = bad_state("more bytes", "the end of the state");
    if (!is_so && good()) error = bad_state(expected, found);
  }
  void end() { require(in_.remaining() == 0, "the end", std::to_string(in_.remaining()) + " more bytes"); }

  std::optional<Error> error;  ///< the first

 private:
  MemoryBytes source_;
  ByteReader in_;
};

template <class Archive, class T, class Each>
void list(Archive& fields, std::vector<T>& all, std::size_t least_bytes, const Each& each) {
  auto number = static_cast<std::uint32_t>(all.size());
  fields.count(number, least_bytes);
  for (std::uint32_t i = 0; i < number && fields.good(); ++i) each(Archive::reads ? all.emplace_back() : all[i]);
}

template <class Archive, class AnyMixture>
void write_or_read(Archive& fields, AnyMixture& fit) {
  fields(fit.component_count);
  fields.require(fit.component_count <= Mixture::max_components, "at most 8 components", "more");
  for (auto* value : {&fit.uniform_weight, &fit.uniform_attribute_mean, &fit.uniform_attribute_variance})
    fields(*value);
  for (std::uint32_t i = 0; i < fit.component_count && fields.good(); ++i) {
    auto& part = fit.components[i];
    for (auto* value : {&part.shape.mu, &part.shape.s_left, &part.shape.s_right, &part.weight, &part.attribute_mean,
                        &part.attribute_variance})
      fields(*value);
  }
}

void write_or_read(auto& fields, StopTest::State& stop) {
  for (std::uint64_t& word : stop.scores) fields(word);
  auto verdict = static_cast<std::uint8_t>(stop.verdict);
  fields(verdict);
  stop.verdict = static_cast<StopTest::Verdict>(verdict);
  fields.require(stop.verdict == StopTest::Verdict::undecided || stop.verdict == StopTest::Verdict::refused,
                 "an open or refused row", "another");
  for (float* value : {&stop.bound, &stop.largest_passed}) fields(*value);
  fields.require(std::isfinite(stop.bound) && std::isfinite(stop.largest_passed), "bounds", "others");
  for (std::uint32_t* value : {&stop.passed, &stop.failed}) fields(*value);
  for (bool* value : {&stop.last_failed, &stop.overruled}) fields(*value);
}

bool is_finite(const Mixture& fit) {
  const auto good = [](const Component& part) {
    return std::isfinite(part.attribute_mean) && std::isfinite(part.attribute_variance);
  };
  return std::isfinite(fit.uniform_attribute_mean) && std::isfinite(fit.uniform_attribute_variance) &&
         std::ranges::all_of(fit.parts(), good);
}

}  // namespace

struct SavedNode {
  std::uint32_t node = 0, queries = 0, events = 0;
  std::uint64_t light = 0;
};

struct SavedHeard {
  std::uint32_t node = 0;
  std::vector<SampledExit> exits;
};

struct SavedSlice {
  explicit SavedSlice(const SliceDescription& slice) : answers(slice), stored(slice), earlier(slice) {}

  bool audited = false;
  std::vector<SavedNode> nodes;          ///< those that were queried or carry light, ascending, as all nodes here
  PackedSlice answers, stored, earlier;  ///< earlier: Learning::earlier
  std::vector<std::uint32_t> interpolated;
  std::uint64_t heard_paths = 0;
  std::vector<SavedHeard> heard;
  std::vector<std::vector<std::uint32_t>> made;  ///< nodes whose answer each form had made
};

namespace {

void write_or_read(auto& fields, const Slice& own, SavedSlice& saved) {
  std::uint32_t least = 0;
  const auto node_field = [&](std::uint32_t& node) {
    fields(node);
    fields.require(own.has_index() && node >= least && node < own.description.node_count(),
                   "an ascending node of its slice", "another");
    least = node + 1;
  };
  fields(saved.audited);
  list(fields, saved.nodes, 20, [&](SavedNode& node) {
    node_field(node.node);
    for (std::uint32_t* value : {&node.queries, &node.events}) fields(*value);
    fields(node.light);
  });
  for (PackedSlice* rows : {&saved.answers, &saved.stored, &saved.earlier}) fields(*rows);
  least = 0;
  list(fields, saved.interpolated, 4, node_field);
  fields(saved.heard_paths);
  least = 0;
  list(fields, saved.heard, 8, [&](SavedHeard& heard) {
    node_field(heard.node);
    list(fields, heard.exits, 17, [&](SampledExit& exit) {
      for (float* value : {&exit.azimuth, &exit.height, &exit.weight, &exit.attribute}) fields(*value);
      auto part = static_cast<std::uint8_t>(exit.part);
      fields(part);
      exit.part = part;
      fields.require(is_exit(exit, SampledTarget::most_parts), "exits of paths", "others");
    });
    fields.require(heard.exits.size() <= HeardExits::most, "as many paths as are kept", "more");
  });
  list(fields, saved.made, 4,
       [&](std::vector<std::uint32_t>& nodes) { list(fields, nodes, 4, [&](std::uint32_t& node) { fields(node); }); });
  fields.require(saved.made.size() == own.forms.size(), "the forms of the service", "others");
}

}  // namespace

/// A state as read from bytes, before the table takes it over. To write one, it has one slice at a time, and no rows.
struct Service::Table::Saved {
  /// The kind of answer of a saved row.
  enum class Kind : std::uint8_t { answer = 0, learning = 1, refusal = 2 };

  struct OfRow {
    Row row{0, 0};
    Kind kind = Kind::answer;
    bool has_converged = false;  ///< for rows of samples
    bool is_published = false, has_earlier = false;
  };

  /// The counts of the table as a whole, as a state has them.
  static auto totals_of(auto& table) {
    return std::tie(table.pass_, table.light_.paths, table.reopened_, table.reopened_logged_, table.light_.queried,
                    table.ceiling_logged_, table.unusable_logged_);
  }
  std::tuple<std::uint32_t, std::uint64_t, std::uint64_t, std::uint64_t, std::uint64_t, bool, bool> totals;
  std::vector<std::pair<std::uint32_t, std::uint64_t>> absorbed_errors;
  std::vector<SavedSlice> slices;
  std::map<SliceKey, PackedSlice> unused;  ///< as in Table
  std::vector<OfRow> rows;
  std::vector<std::vector<std::uint32_t>> row_of_node;  ///< by slice; Slot::no_row for nodes without a row

  template <class Archive>
  void write_or_read_all(Archive& fields, const Table& table) {
    const auto same = [&fields](const auto& value, const std::string& expected) {
      auto found = value;
      fields(found);
      fields.require(found == value, expected, described(found));
    };
    same(state_version, "state version " + std::to_string(state_version));
    same(table.model_name(), "model " + table.model_name());
    same(std::string(table.options_.learner->name), std::string("learner ") + table.options_.learner->name);
    std::apply([&fields](auto&... total) { (fields(total), ...); }, totals);
    fields.require(std::get<0>(totals) > 0, "a pass above 0", "0");
    list(fields, absorbed_errors, 12, [&](auto& error) {
      fields(error.first);
      fields(error.second);
      const auto value = std::bit_cast<float>(error.first);
      fields.require(value > 0 && std::isfinite(value), "an error above 0", "another");
    });
    const auto count = table.rows_.slice_count();
    same(count, std::to_string(count) + " slices");
    for (std::uint32_t id = 0; id < count && fields.good(); ++id) {
      const Slice& own = table.rows_.slice(id);
      std::string description = format::described(own.description);
      const std::string wanted = description;
      fields(description);
      fields.require(description == wanted, "slice " + std::to_string(id) + " as it was added", "another");
      same(own.has_index(), "as much room for indices");
      if constexpr (Archive::reads) {
        row_of_node.emplace_back(own.description.node_count(), Slot::no_row);
        write_or_read(fields, own, slices.emplace_back(own.description));
      } else {
        SavedSlice now = table.saved_slice(own);
        write_or_read(fields, own, now);
      }
    }
    unused_slices(fields, table);
    auto number = table.rows_.size();
    fields.count(number, 27);  // bytes of a row that does not learn
    for (std::uint32_t i = 0; i < number && fields.good(); ++i) {
      if constexpr (Archive::reads) {
        OfRow& read = rows.emplace_back();
        row(fields, table, read.row, read);
        if (!fields.good()) return;
        std::uint32_t& place = row_of_node[read.row.slice][read.row.node];
        fields.require(place == Slot::no_row, "one row for each node", "two");
        place = i;
      } else {
        const Row& own = table.rows_[i];
        const RibbonAnswer* ribbons = table.rows_.slot_of(own).ribbons();
        OfRow marks;
        marks.kind = own.learning                            ? Kind::learning
                     : table.rows_.slot_of(own).is_refused() ? Kind::refusal
                                                             : Kind::answer;
        marks.has_converged = ribbons != nullptr && ribbons->has_converged;
        marks.is_published = own.learning && own.learning->published != nullptr;
        marks.has_earlier = earlier_of(own) != nullptr;
        row(fields, table, own, marks);
      }
    }
  }

  template <class Archive>
  void unused_slices(Archive& fields, const Table& table) {
    auto number = static_cast<std::uint32_t>(table.unused_.size());
    fields.count(number, 4);
    auto next = table.unused_.begin();
    for (std::uint32_t i = 0; i < number && fields.good(); ++i) {
      std::string bytes;
      if constexpr (!Archive::reads) {
        PackedSliceRows packed((next++)->second, table.model_name());
        bytes = format::cache_bytes(packed);
        fields.require(!bytes.empty(), "rows of a cache that can be read back", "others");
      }
      fields(bytes);
      if (!Archive::reads || !fields.good()) continue;
      const MemoryBytes source(bytes);
      CacheReader cache(source, "unused slices");
      const bool is_cache = cache.check(table.model_name());
      fields.require(is_cache, "slices as of a cache", is_cache ? "" : cache.error().message());
      while (const SliceDescription* slice = is_cache ? cache.next_slice() : nullptr) {
        fields.require(table.rows_.find(slice->key) == nullptr, "slices that nobody uses", "one that is used");
        PackedSlice& packed = unused.insert_or_assign(slice->key, PackedSlice(*slice)).first->second;
        while (const CachedRow* one = cache.next_row()) packed.add(*one);
      }
    }
  }

  template <class Archive, class AnyRow>
  static void row(Archive& fields, const Table& table, AnyRow& row, OfRow& marks) {
    auto kind = static_cast<std::uint8_t>(marks.kind), failed = static_cast<std::uint8_t>(row.failed);
    auto audit = static_cast<std::uint8_t>(static_cast<std::uint8_t>(Audit(row.audit)) |
                                           (marks.has_converged ? converged_row : 0));
    std::uint64_t count = row.count;
    for (auto* value : {&row.slice, &row.node}) fields(*value);
    for (std::uint8_t* value : {&kind, &audit, &failed}) fields(*value);
    fields(row.energy);
    fields(row.generation);
    fields(count);
    const Slice* slice = row.slice < table.rows_.slice_count() ? &table.rows_.slice(row.slice) : nullptr;
    fields.require(slice != nullptr && slice->has_index() && row.node < slice->description.node_count(),
                   "a row of a node", "another");
    if (!fields.good()) return;
    if constexpr (Archive::reads) {
      marks.kind = static_cast<Kind>(kind);
      marks.has_converged = (audit & converged_row) != 0;
      row.audit = static_cast<Audit>(audit & ~converged_row);
      row.set_failed(failed);
      row.set_count(count);
      fields.require(kind <= static_cast<std::uint8_t>(Kind::refusal) && row.audit <= Audit::due &&
                         std::isfinite(row.energy) &&
                         (marks.kind == Kind::answer ||
                          (slice->description.kind == SliceKind::samples) == (marks.kind == Kind::refusal)),
                     "a row as of its slice", "another");
      if (marks.kind == Kind::learning && fields.good())
        row.learning = std::make_unique<Learning>(slice->description.blur_rad, *table.options_.learner);
    }
    if (row.learning) learning(fields, *row.learning, marks, Sketch::bin_count(slice->description.blur_rad));
  }

  template <class Archive, class AnyLearning>
  static void learning(Archive& fields, AnyLearning& learning, OfRow& marks, std::uint32_t most_bins) {
    std::vector<SketchBin> bins = learning.sketch.bins();
    list(fields, bins, 12, [&](SketchBin& bin) {
      fields(bin.index);
      fields(bin.bits);
      const auto g = std::bit_cast<float>(static_cast<std::uint32_t>(bin.bits));
      fields.require(bin.index < most_bins && std::isfinite(g) && !std::signbit(g), "bins of a sketch", "others");
    });
    std::optional<std::vector<std::uint64_t>> words = learning.learner->state();
    fields.require(words.has_value(), "a learner whose rows can be saved as they are", "another");
    if (!fields.good()) return;
    if (Archive::reads) words->clear();
    list(fields, *words, 8, [&](std::uint64_t& word) { fields(word); });
    StopTest::State stop = learning.stop.state();
    write_or_read(fields, stop);
    fields(learning.has_fit);
    write_or_read(fields, learning.fit);
    fields(learning.objective);
    fields.require(std::isfinite(learning.objective), "an objective", "another");
    fields(learning.count);
    for (bool* mark : {&marks.is_published, &marks.has_earlier}) fields(*mark);
    for (auto* value : {&learning.created_pass, &learning.queries_at_creation}) fields(*value);
    std::uint64_t observed = learning.observed.load(std::memory_order_relaxed);
    fields(observed);
    auto weights = learning.weights.words();
    for (std::uint64_t& word : weights) fields(word);
    if constexpr (Archive::reads) {
      fields.require(learning.learner->set_state(*words), "the state of a learner", "another");
      learning.sketch.merge(bins);
      learning.stop.set_state(stop);
      learning.observed.store(observed, std::memory_order_relaxed);
      learning.weights.set_words(weights);
    }
  }
};

Result<std::string> Service::Table::state() const {
  if (pass_ == 0) return Error{"", "state", "a pass that was published", "none"};
  Saved now;
  now.totals = Saved::totals_of(*this);
  now.absorbed_errors.assign(absorbed_errors_.counts().begin(), absorbed_errors_.counts().end());
  StateWriter out;
  now.write_or_read_all(out, *this);
  if (out.error) return *out.error;
  return out.take();
}

SavedSlice Service::Table::saved_slice(const Slice& slice) const {
  SavedSlice saved(slice.description);
  saved.audited = slice.audited;
  for (const auto& [node, row] : slice.stored) saved.stored.add(row);
  for (std::uint32_t n = 0; slice.has_index() && n < slice.description.node_count(); ++n) {
    const Slot& slot = slice.slots[n];
    const SavedNode now{n, slot.queries.load(std::memory_order_relaxed),
                        slice.events[n].load(std::memory_order_relaxed), slice.light_at(n)};
    if (now.queries != 0 || now.light != 0 || now.events != 0) saved.nodes.push_back(now);
    const auto heard = slice.heard.at(n);
    if (!heard.empty()) saved.heard.push_back({n, {heard.begin(), heard.end()}});
    if (slot.row == Slot::no_row) continue;
    if (slot.has_answer()) {
      saved.answers.add(rows_.cached_form(rows_[slot.row]));
    } else if (const CachedRow* earlier = earlier_of(rows_[slot.row])) {
      saved.earlier.add(*earlier);
    }
  }
  saved.interpolated = slice.interpolated;
  std::ranges::sort(saved.interpolated);  // so that the bytes do not depend on the order of threads
  saved.heard_paths = slice.heard.paths();
  for (const std::uint32_t form : slice.forms) saved.made.push_back(forms_.made_nodes(form));
  return saved;
}

std::optional<Error> Service::Table::restore(const std::string& bytes) {
  if (pass_ != 0 || !rows_.empty() || !unused_.empty() ||
      std::ranges::any_of(rows_.slices(), [](const auto& slice) { return !slice->stored.empty(); }))
    return bad_state("a service that has loaded nothing and published no pass", "another");
  Saved saved;
  StateReader reader(bytes);
  saved.write_or_read_all(reader, *this);
  reader.end();
  if (reader.error) return reader.error;
  for (SliceId id = 0; id < rows_.slice_count(); ++id) {
    if (std::optional<Error> error = check_rows(saved, id)) return error;
  }
  std::atomic<bool> legal{true};
  in_parallel(saved.rows.size(), [&](std::size_t i) {
    const Row& row = saved.rows[i].row;
    if (!row.learning) return;
    Learning& learning = *row.learning;
    learning.nodes = trace(row.slice, row.node);
    if (!learning.nodes ||
        (learning.has_fit &&
         !(is_legal(learning.fit, Mixture::max_components, learning.nodes->energy()) && is_finite(learning.fit))))
      legal = false;
  });
  if (!legal) return bad_state("targets that can be traced, and fits within their bounds", "another");
  take_over(saved);
  return std::nullopt;
}

std::optional<Error> Service::Table::check_rows(Saved& saved, SliceId id) const {
  const SavedSlice& slice = saved.slices[id];
  const std::vector<std::uint32_t>& row_of_node = saved.row_of_node[id];
  const auto row_at = [&](std::uint32_t node) {
    return row_of_node[node] == Slot::no_row ? nullptr : &saved.rows[row_of_node[node]];
  };
  for (const std::vector<std::uint32_t>& made : slice.made) {
    for (const std::uint32_t node : made) {
      const Saved::OfRow* row = node < row_of_node.size() ? row_at(node) : nullptr;
      if (node >= row_of_node.size() || (row != nullptr && row->kind != Saved::Kind::answer))
        return bad_state("forms of nodes that are answered", "another");
    }
  }
  const auto number = [&](const auto& is_one) {
    return std::ranges::count_if(saved.rows, [&](const auto& row) { return row.row.slice == id && is_one(row); });
  };
  if (slice.answers.rows() != number([](const auto& row) { return row.kind == Saved::Kind::answer; }) ||
      slice.earlier.rows() != number([](const auto& row) { return row.has_earlier; }))
    return bad_state("an answer for each converged row", "others");
  bool good = true;
  const auto check = [&](const PackedSlice& packed, const auto& is_right) {
    good = packed.for_each([&](const CachedRow& row) {
      good = good && may_answer(rows_.slice(id), row) && is_right(row, row_at(row.node));
    }) && good;
  };
  check(slice.answers, [](const CachedRow& row, const Saved::OfRow* of) {
    return row.state == RowState::converged && of != nullptr && of->kind == Saved::Kind::answer;
  });
  check(slice.stored, [](const CachedRow&, const Saved::OfRow* of) { return of == nullptr; });
  check(slice.earlier, [](const CachedRow& row, const Saved::OfRow* of) {
    if (of == nullptr || !of->has_earlier) return false;
    of->row.learning->earlier = std::make_unique<const CachedRow>(row);
    return true;
  });
  return good ? std::nullopt : std::optional(bad_state("packed rows as of a cache, each of its row", "others"));
}

void Service::Table::take_over(Saved& saved) {
  Saved::totals_of(*this) = saved.totals;
  for (const auto& [bits, count] : saved.absorbed_errors) absorbed_errors_.add_counted(bits, count);
  unused_ = std::move(saved.unused);
  std::vector<bool> has_converged;  // by row
  for (Saved::OfRow& of : saved.rows) {
    has_converged.push_back(of.has_converged);
    Row& row = rows_.add(std::move(of.row));
    if (of.kind == Saved::Kind::refusal) rows_.refuse(row);
    if (row.learning) rows_.show_learning(row, false, of.is_published);
  }
  for (std::size_t id = 0; id < saved.slices.size(); ++id) take_slice(saved.slices[id], rows_.slice(id), has_converged);
  for (const Row& row : rows_) bytes_ += rows_.bytes_of(row);
}

void Service::Table::take_slice(SavedSlice& saved, Slice& slice, const std::vector<bool>& has_converged) {
  slice.audited = saved.audited;
  for (const SavedNode& node : saved.nodes) {
    slice.slots[node.node].queries.store(node.queries, std::memory_order_relaxed);
    slice.queries_before[node.node] = node.queries;
    slice.events[node.node].store(node.events, std::memory_order_relaxed);
    slice.light[node.node].store(node.light, std::memory_order_relaxed);
  }
  saved.answers.for_each([&](const CachedRow& row) {
    const std::uint32_t index = slice.slots[row.node].row;
    rows_.show_cached(rows_[index], row, has_converged[index]);
  });
  saved.stored.for_each([&](const CachedRow& row) { slice.stored.insert_or_assign(row.node, row); });
  slice.heard.set_paths(saved.heard_paths);
  for (SavedHeard& heard : saved.heard)
    bytes_ += slice.heard.restore(slice.description.node_count(), heard.node, std::move(heard.exits));
  kept_before_ = &saved.interpolated;
  kept_slice_ = &slice;
  for (const std::uint32_t node : saved.interpolated) (void)answer_of(slice, node);
  for (std::size_t i = 0; i < saved.made.size(); ++i) {
    for (const std::uint32_t node : saved.made[i]) make_again(forms_.rows(slice.forms[i]), node);
  }
  kept_before_ = nullptr;
}

}  // namespace tress::inline v0_2::adaptive
