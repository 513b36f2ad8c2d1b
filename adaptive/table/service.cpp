#include "tress/adaptive/service.h"

#include <cassert>
#include <cmath>
#include <utility>

#include "table/table.h"

namespace tress::adaptive {
namespace {

RowView view_of(const Slot& slot) {
  RowView view;
  view.state = slot.state;
  if (slot.is_knots) {
    view.knots = static_cast<const KnotTable*>(slot.answer);
  } else {
    view.fit = static_cast<const Mixture*>(slot.answer);
  }
  view.nodes = slot.nodes.load(std::memory_order_relaxed);
  view.row = slot.row;
  view.objective = slot.objective;
  return view;
}

}  // namespace

std::unique_ptr<const TracedNodes> Service::Table::trace(PageId page, std::uint32_t node) const {
  const PageDescription& d = pages_[page]->description;
  const auto width = static_cast<std::uint32_t>(d.axis_b.size());
  std::vector<TracedRay> rays;
  target_.trace(d, d.axis_a[node / width], d.axis_b[node % width], rays);
  return std::make_unique<const TracedNodes>(rays, d.blur_rad);
}

void Service::Table::show(std::uint32_t index) const {
  const Row& row = *rows_[index];
  Slot& slot = pages_[row.page]->slots[row.node];
  slot.state = row.state;
  slot.is_knots = row.knots != nullptr;
  slot.answer = row.knots ? static_cast<const void*>(row.knots.get()) : row.has_fit ? &row.fit : nullptr;
  slot.objective = row.objective >= 0 ? row.objective : 1.0f;
  slot.nodes.store(row.learning ? row.learning->nodes.get() : nullptr, std::memory_order_relaxed);
}

RowView Service::Table::look_up(PageId page_id, std::uint32_t a, std::uint32_t b) {
  Page& page = *pages_[page_id];
  const std::uint32_t node = a * static_cast<std::uint32_t>(page.description.axis_b.size()) + b;
  assert(node < page.description.node_count());
  Slot& slot = page.slots[node];
  slot.touches.fetch_add(1, std::memory_order_relaxed);
  if (slot.row != Slot::no_row) return view_of(slot);

  RowView view;
  view.nodes = slot.nodes.load(std::memory_order_acquire);
  if (view.nodes != nullptr) return view;
  std::unique_ptr<const TracedNodes> traced = trace(page_id, node);
  const std::size_t size = traced->bytes();
  const std::size_t before = memo_bytes_.fetch_add(size, std::memory_order_relaxed);
  if (bytes_ + before + size > options_.memory_bytes) {
    memo_bytes_.fetch_sub(size, std::memory_order_relaxed);
    traces_.fetch_add(1, std::memory_order_relaxed);
    view.kept = std::move(traced);
    view.nodes = view.kept.get();
    return view;
  }
  const TracedNodes* seen = nullptr;
  if (slot.nodes.compare_exchange_strong(seen, traced.get(), std::memory_order_acq_rel, std::memory_order_acquire)) {
    traces_.fetch_add(1, std::memory_order_relaxed);
    view.nodes = traced.release();
  } else {
    memo_bytes_.fetch_sub(size, std::memory_order_relaxed);
    view.nodes = seen;  // another thread was first: the same values
  }
  return view;
}

RowView Service::Table::peek(PageId page_id, std::uint32_t a, std::uint32_t b) const {
  const Page& page = *pages_[page_id];
  const Slot& slot = page.slots[a * page.description.axis_b.size() + b];
  return slot.row == Slot::no_row ? RowView{} : view_of(slot);
}

void Service::Table::observe(const RowView& view, float x, float g) {
  if (view.row == RowView::no_row || !learns_) return;
  Row& row = *rows_[view.row];
  if (row.state != RowState::open) return;
  row.learning->sketch.offer(x, g);
  row.learning->observed.fetch_add(1, std::memory_order_relaxed);
}

void Service::Table::score(const RowView& view, float x, float g, float q) {
  observe(view, x, g);
  if (view.row == RowView::no_row || !learns_) return;
  Row& row = *rows_[view.row];
  if (row.state != RowState::open || !row.has_fit) return;
  if (q > 0 && std::isfinite(q) && std::isfinite(g)) row.add_score(x, g, q);
}

Service::Service(const Options& options, const Target& target) : table_(std::make_unique<Table>(options, target)) {}
Service::~Service() = default;
const Options& Service::options() const { return table_->options(); }
PageId Service::add_page(const PageDescription& description) { return table_->add_page(description); }
const PageDescription& Service::page(PageId page) const { return table_->pages()[page]->description; }
std::uint32_t Service::page_count() const { return static_cast<std::uint32_t>(table_->pages().size()); }
std::optional<Error> Service::load(TableImage image) { return table_->load(std::move(image)); }
TableImage Service::snapshot() const { return table_->snapshot(); }
RowView Service::look_up(PageId page, std::uint32_t a, std::uint32_t b) const { return table_->look_up(page, a, b); }
void Service::count_converged(std::uint32_t queries) const { table_->count_converged(queries); }
void Service::observe(const RowView& row, float x, float g) const { table_->observe(row, x, g); }
void Service::score(const RowView& row, float x, float g, float q) const { table_->score(row, x, g, q); }
void Service::set_learning(bool on) { table_->set_learning(on); }
PassReport Service::publish() { return table_->publish(); }
const std::vector<Service::RowChange>& Service::last_changes() const { return table_->changes(); }
RowView Service::peek(PageId page, std::uint32_t a, std::uint32_t b) const { return table_->peek(page, a, b); }
const std::vector<Error>& Service::refusals() const { return table_->refusals(); }
void Service::set_row_listener(std::function<void(const RowReport&)> listener) {
  table_->set_listener(std::move(listener));
}

}  // namespace tress::adaptive
