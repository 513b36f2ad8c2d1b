#include "tress/adaptive/service.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>

#include "table/table.h"

namespace tress::inline v0_2::adaptive {
namespace {

/// g of a node that cannot be traced.
const TracedNodes& no_light() {
  static const TracedNodes none({}, 1);
  return none;
}

}  // namespace

void Service::Table::show(Row& row, RowOutcome& outcome) {
  if (outcome.cached != nullptr) {
    const double objective = outcome.cached->objective;
    return rows_.show_cached(row, *outcome.cached,
                             objective <= options_.sampled_epsilon && !(options_.picture_error > 0));
  }
  if (outcome.ribbons) return rows_.show_ribbons(row, std::move(outcome.ribbons));
  if (outcome.refused) {
    if (std::optional<Error> error = sampled_.invalid_exits(row, outcome.g_evaluations))
      discipline_.note(std::move(*error));
    return rows_.refuse(row);
  }
  rows_.show_learning(row, outcome.converged);
}

Error Service::Table::no_such_slice(const char* call, SliceId slice) const {
  return {"", call, "a slice below " + std::to_string(rows_.slice_count()), std::to_string(slice)};
}

bool Service::Table::is_misuse(const char* call, SliceId slice, std::uint32_t node) {
  if (slice >= rows_.slice_count()) {
    discipline_.note(no_such_slice(call, slice));
    return true;
  }
  if (const std::uint32_t count = rows_.slice(slice).description.node_count(); node >= count) {
    discipline_.note({"", call, "a node below " + std::to_string(count) + " of slice " + std::to_string(slice),
                      std::to_string(node)});
    return true;
  }
  return !discipline_.begin_reading(call);
}

bool Service::Table::is_stale(const char* call, const RowView& row) {
  if (!options_.check_passes) return false;
  if (row.pass == pass_) return is_misuse(call, row.slice, row.node);
  discipline_.note({"", call, "a view of pass " + std::to_string(pass_), "one of pass " + std::to_string(row.pass)});
  return true;
}

std::uint32_t Service::Table::node_of(SliceId slice, std::uint32_t a, std::uint32_t b) const {
  if (slice >= rows_.slice_count()) return no_node;
  const SliceDescription& of = rows_.slice(slice).description;
  if (a >= of.axis_a.size() || b >= of.axis_b.size()) return no_node;
  return a * static_cast<std::uint32_t>(of.axis_b.size()) + b;
}

RowView Service::Table::look_up(SliceId slice_id, std::uint32_t a, std::uint32_t b) {
  const std::uint32_t node = node_of(slice_id, a, b);
  if (node == no_node || options_.check_passes) [[unlikely]] {
    const bool is_off_axes = node == no_node && slice_id < rows_.slice_count();
    if (is_off_axes) {
      const SliceDescription& of = rows_.slice(slice_id).description;
      discipline_.note(
          {"", "look_up",
           "a node below " + std::to_string(of.node_count()) + ", a below " + std::to_string(of.axis_a.size()) +
               " and b below " + std::to_string(of.axis_b.size()),
           "a " + std::to_string(a) + ", b " + std::to_string(b) + " of slice " + std::to_string(slice_id)});
    }
    if (is_off_axes || is_misuse("look_up", slice_id, node)) {
      RowView nothing = bare_view(RowState::absent, slice_id, node);
      add_g(nothing, false);
      return nothing;
    }
  }
  const Discipline::Reader inside(discipline_);
  Slice& slice = rows_.slice(slice_id);
  if (slice.has_index()) {
    slice.slots[node].queries.fetch_add(1, std::memory_order_relaxed);
  } else {
    unindexed_queries_.add(1);
  }
  RowView view = slice.has_index() ? view_at(slice_id, node) : bare_view(RowState::absent, slice_id, node);
  if (view.row == RowView::no_row) add_g(view, true);
  return view;
}

void Service::Table::add_g(RowView& view, bool may_trace) {
  if (view.slice < rows_.slice_count() && rows_.slice(view.slice).description.kind == SliceKind::samples) return;
  if (!may_trace) {
    view.nodes = &no_light();
    return;
  }
  const Slice& slice = rows_.slice(view.slice);
  Slot* slot = slice.has_index() ? &slice.slots[view.node] : nullptr;
  if (slot != nullptr) view.nodes = Slot::target_of<TracedNodes>(slot->word.load(std::memory_order_acquire));
  if (view.nodes != nullptr) return;
  std::unique_ptr<const TracedNodes> traced = trace(view.slice, view.node);
  if (!traced) {
    view.nodes = &no_light();
    return;
  }
  const std::size_t size = traced->bytes();
  const std::size_t before = slot != nullptr ? memo_bytes_.fetch_add(size, std::memory_order_relaxed) : 0;
  const std::size_t formed = formed_bytes_.load(std::memory_order_relaxed);
  const bool has_room = slot != nullptr && bytes_ + formed + before + size <= options_.memory_bytes;
  bool is_kept = false;
  if (has_room) {
    std::tie(view.nodes, is_kept) = slot->put_first(std::move(traced), Slot::Kind::traced);
  } else {
    view.nodes = traced.get();
    view.kept = std::shared_ptr<const TracedNodes>(std::move(traced));
  }
  if (slot != nullptr && !is_kept) memo_bytes_.fetch_sub(size, std::memory_order_relaxed);
  if (is_kept || !has_room) traces_.fetch_add(1, std::memory_order_relaxed);
}

Slice* Service::Table::indexed_slice(const RowView& view) const {
  if (view.slice >= rows_.slice_count()) return nullptr;
  Slice& slice = rows_.slice(view.slice);
  return slice.has_index() && view.node < slice.description.node_count() ? &slice : nullptr;
}

double Service::Table::light(SliceId slice, std::uint32_t a, std::uint32_t b) const {
  const std::uint32_t node = node_of(slice, a, b);
  return node == no_node ? 0 : light_.share(rows_.slice(slice).light_at(node));
}

std::uint32_t Service::Table::queries(SliceId slice, std::uint32_t a, std::uint32_t b) const {
  const std::uint32_t node = node_of(slice, a, b);
  if (node == no_node || !rows_.slice(slice).has_index()) return 0;
  return rows_.slice(slice).slots[node].queries.load(std::memory_order_relaxed);
}

RowView Service::Table::peek(SliceId slice, std::uint32_t a, std::uint32_t b) {
  const std::uint32_t node = node_of(slice, a, b);
  if (node == no_node) return bare_view(RowState::absent, slice, node);
  return rows_.slice(slice).has_index() ? view_at(slice, node) : bare_view(RowState::absent, slice, node);
}

void Service::Table::credit(const RowView& view, float light, std::uint32_t events) {
  if (is_stale("credit", view)) return;
  const Slice* slice = indexed_slice(view);
  if (slice == nullptr) return;
  slice->events[view.node].fetch_add(events, std::memory_order_relaxed);
  if (light > 0) slice->light[view.node].fetch_add(fixed_light(light), std::memory_order_relaxed);
}

void Service::Table::hear(const RowView& view, const SampledExit& exit) {
  if (is_stale("hear", view)) return;
  Slice* slice = indexed_slice(view);
  if (slice != nullptr && slice->parts > 0) slice->heard.add(view.node, exit);  // a density has no parts
}

void Service::Table::observe(const RowView& view, float x, float g) {
  if (view.row >= rows_.size() || !learns_ || is_stale("observe", view)) return;
  Row& row = rows_[view.row];
  if (!row.learning || row.learning->state() != RowState::open) return;
  row.learning->sketch.offer(x, g);
  row.learning->observed.fetch_add(1, std::memory_order_relaxed);
}

void Service::Table::score(const RowView& view, float x, float g, float q) {
  if (is_stale("score", view)) return;
  observe(view, x, g);
  if (view.row >= rows_.size() || !learns_) return;
  Row& row = rows_[view.row];
  if (!row.learning || row.learning->state() != RowState::open || !row.learning->has_fit) return;
  if (q > 0 && std::isfinite(q) && g >= 0 && std::isfinite(g) && std::isfinite(x)) row.learning->add_score(x, g, q);
}

class Service::MonitoredCall {
 public:
  explicit MonitoredCall(Table& table) : table_(table) {}
  ~MonitoredCall() { table_.report_memory(); }
  MonitoredCall(const MonitoredCall&) = delete;
  MonitoredCall& operator=(const MonitoredCall&) = delete;

 private:
  Table& table_;
};

Service::Service(const Options& options, const Target& target)
    : table_(std::make_unique<Table>(options, &target, nullptr)) {}
Service::Service(const Options& options, const Target& target, const SampledTarget& samples)
    : table_(std::make_unique<Table>(options, &target, &samples)) {}
Service::Service(const Options& options, const SampledTarget& samples)
    : table_(std::make_unique<Table>(options, nullptr, &samples)) {}
Service::~Service() = default;
const Options& Service::options() const { return table_->options(); }
std::string Service::model_name() const { return table_->model_name(); }
bool Service::has_target(SliceKind kind) const { return table_->has_target(kind); }
Result<SliceId> Service::add_slice(const SliceDescription& description) {
  const MonitoredCall call(*table_);
  return table_->add_slice(description);
}
Result<const FormedRows*> Service::add_form(SliceId slice, std::shared_ptr<const RowForm> form,
                                            const std::vector<float>& decay_rates) {
  const MonitoredCall call(*table_);
  return table_->add_form(slice, std::move(form), decay_rates);
}
const SliceDescription& Service::slice(SliceId slice) const {
  static const SliceDescription none;
  return slice < slice_count() ? table_->all().slice(slice).description : none;
}
std::uint32_t Service::slice_count() const { return table_->all().slice_count(); }
std::optional<Error> Service::load(RowSource& rows) {
  const MonitoredCall call(*table_);
  return table_->load(rows);
}
std::optional<Error> Service::load(const TableSnapshot& image) {
  SnapshotRows rows(image);
  return load(rows);
}
std::unique_ptr<RowSource> Service::rows() const { return table_->rows(); }
Result<std::string> Service::state() const { return table_->state(); }
std::optional<Error> Service::restore(const std::string& state) {
  const MonitoredCall call(*table_);
  return table_->restore(state);
}
TableSnapshot Service::snapshot() const { return table_->snapshot(); }
RowView Service::look_up(SliceId slice, std::uint32_t a, std::uint32_t b) const { return table_->look_up(slice, a, b); }
FormedLookup Service::look_up(const FormedRows& rows, std::uint32_t node) const { return table_->look_up(rows, node); }
FormedLookup Service::fetch(const FormedRows& rows, std::uint32_t node) const { return table_->fetch(rows, node); }
void Service::credit(const RowView& row, float light, std::uint32_t events) const {
  table_->credit(row, light, events);
}
void Service::prepare() {
  const MonitoredCall call(*table_);
  table_->prepare();
}
void AnswerReader::count() const {
  if (service_ != nullptr) service_->table_->count_formed(queries_, converged_);
}
void Service::hear(const RowView& row, const SampledExit& exit) const { table_->hear(row, exit); }
HeardTest Service::test_by_heard() const { return table_->test_by_heard(); }
void Service::observe(const RowView& row, float x, float g) const { table_->observe(row, x, g); }
void Service::score(const RowView& row, float x, float g, float q) const { table_->score(row, x, g, q); }
void Service::set_learning(bool on) { table_->set_learning(on); }
bool Service::publish_pays(double share) const { return table_->publish_pays(share); }
PassReport Service::publish(std::uint64_t paths) { return table_->publish(paths); }
RowView Service::peek(SliceId slice, std::uint32_t a, std::uint32_t b) const { return table_->peek(slice, a, b); }
double Service::light(SliceId slice, std::uint32_t a, std::uint32_t b) const { return table_->light(slice, a, b); }
std::uint32_t Service::queries(SliceId slice, std::uint32_t a, std::uint32_t b) const {
  return table_->queries(slice, a, b);
}
const std::vector<Error>& Service::refusals() const { return table_->refusals(); }
void Service::set_row_listener(std::function<void(const RowReport&)> listener) {
  table_->set_listener(std::move(listener));
}

}  // namespace tress::inline v0_2::adaptive
