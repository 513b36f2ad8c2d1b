// Answers that forms make of rows. The first thread that needs one makes it; it is dropped when its row changes.
#include <new>
#include <string>
#include <utility>

#include "table/table.h"

namespace tress::adaptive {
namespace {

/// Whether a row answers without evaluating g.
bool has_answer(const RowView& row) { return row.state == RowState::converged || row.ribbons != nullptr; }

}  // namespace

Result<const FormedRows*> Service::Table::add_form(SliceId slice, std::shared_ptr<const RowForm> form,
                                                   const std::vector<float>& decay_rates) {
  if (std::optional<Error> early = discipline_.within_pass("add_form")) return std::move(*early);
  if (slice >= slices_.size()) return no_such_slice("add_form", slice);
  if (form == nullptr) return Error{"", "add_form", "a form", "none"};
  const SliceDescription& description = slices_[slice]->description;
  std::unique_ptr<FormedRows> rows(new FormedRows);
  rows->slice_ = slice;
  rows->width_ = static_cast<std::uint32_t>(description.axis_b.size());
  rows->height_ = static_cast<std::uint32_t>(description.axis_a.size());
  rows->form_ = std::move(form);
  const std::size_t size = sizeof(RowEntry) * description.node_count();
  const bool has_room = bytes_ + formed_bytes_ + size <= options_.memory_bytes;
  rows->stride_ = has_room && !options_.check_passes ? rows->width_ : 0;
  rows->owned_ = std::make_unique<RowEntry[]>(rows->stride_ != 0 ? description.node_count() : rows->width_);
  rows->entries_ = rows->owned_.get();
  if (rows->stride_ != 0) formed_bytes_ += size;
  forms_.push_back({std::move(rows), {}});
  for (const float rate : decay_rates) slices_[slice]->add_rate(rate);
  slices_[slice]->forms.push_back(static_cast<std::uint32_t>(forms_.size() - 1));
  return forms_.back().rows.get();
}

FormedLookup Service::Table::fetch(const FormedRows& rows, std::uint32_t node) {
  FormedLookup found;
  const bool is_there = rows.slice_ < slices_.size() && node < rows.height_ * rows.width_ &&
                        node < slices_[rows.slice_]->description.node_count();
  if ((!is_there || options_.check_passes) && is_misuse("fetch", rows.slice_, node)) return found;
  if (!is_there) return found;  // the rows belong to another service
  Slice& slice = *slices_[rows.slice_];
  RowEntry* entry = rows.stride_ != 0 ? &rows.entries_[node] : nullptr;
  if (entry != nullptr && entry->get()) {  // another thread has made it
    found.answer = entry->get();
    found.row = bare_view(RowState::converged, rows.slice_, node);
    count_formed(found.answer.has_row() ? 1 : 0, found.answer.has_converged() ? 1 : 0);
    return found;
  }
  if (const void* instead = rows.form_->instead_of_row(node)) {
    found.answer = RowAnswer::without_row(instead);
    if (entry != nullptr) entry->put(found.answer);
    return found;
  }
  if (!slice.has_index()) return found;
  Slot& slot = slice.slots[node];
  const RowView row = view_at(rows.slice_, node);
  if (!has_answer(row)) return found;
  if (slice.is_sampled() && entry != nullptr) {
    // Counts only whether the node was queried. How often a form is made again depends on threads and memory, but the
    // number of paths must not: it follows from the queries.
    std::uint32_t none = 0;
    const bool is_first = slot.queries.compare_exchange_strong(none, 1, std::memory_order_relaxed);
    if (!is_first) count_formed(1, row.state == RowState::converged ? 1 : 0);
  } else {
    slot.queries.fetch_add(1, std::memory_order_relaxed);  // shows that the row is in use and may be audited
  }
  found.row = bare_view(row.state, rows.slice_, node);
  found.row.row = row.row;

  const std::size_t size = BlockStore::rounded(rows.form_->bytes(row));
  const std::size_t before = formed_bytes_.fetch_add(size, std::memory_order_relaxed);
  const std::size_t others = bytes_ + memo_bytes_.load(std::memory_order_relaxed);
  if (entry == nullptr || others + before + size > options_.memory_bytes) {
    formed_bytes_.fetch_sub(size, std::memory_order_relaxed);
    forms_made_anew_.add(1);
    constexpr std::align_val_t line{BlockStore::line_bytes};
    std::shared_ptr<void> block(::operator new(size, line), [](void* memory) { ::operator delete(memory, line); });
    rows.form_->write(row, block.get());
    found.answer = RowAnswer::of_row(block.get(), row.state == RowState::converged);
    found.kept = std::move(block);
    return found;
  }
  void* block = blocks_.take(size);
  rows.form_->write(row, block);
  found.answer = entry->put_first(RowAnswer::of_row(block, row.state == RowState::converged));
  if (found.answer.block() == block) {
    const std::scoped_lock lock(made_mutex_);
    forms_[form_of(rows)].made.push_back({block, size, node});
  } else {
    formed_bytes_.fetch_sub(size, std::memory_order_relaxed);  // another thread has written the same bytes
    blocks_.give_back(block, size);
  }
  return found;
}

FormedLookup Service::Table::look_up(const FormedRows& rows, std::uint32_t node) {
  FormedLookup found = fetch(rows, node);
  if (!found.answer) found.row = look_up(rows.slice_, node / rows.width_, node % rows.width_);
  return found;
}

bool Service::Table::make_again(Form& form, std::uint32_t node) {
  FormedRows& rows = *form.rows;
  const Slice& slice = *slices_[rows.slice_];
  if (rows.stride_ == 0 || !slice.has_index() || node >= slice.description.node_count()) return false;
  if (rows.entries_[node].get() || rows.form_->instead_of_row(node) != nullptr) return false;
  const RowView row = view_at(rows.slice_, node);
  if (!has_answer(row)) return false;
  const std::size_t size = BlockStore::rounded(rows.form_->bytes(row));
  void* block = blocks_.take(size);
  rows.form_->write(row, block);
  rows.entries_[node].put(RowAnswer::of_row(block, row.state == RowState::converged));
  formed_bytes_ += size;
  form.made.push_back({block, size, node});
  return true;
}

std::size_t Service::Table::form_of(const FormedRows& rows) const {
  for (const std::uint32_t form : slices_[rows.slice_]->forms) {
    if (forms_[form].rows.get() == &rows) return form;
  }
  return forms_.size();
}

void Service::Table::drop_forms(SliceId slice) {
  for (const std::uint32_t form : slices_[slice]->forms) drop(forms_[form]);
}

void Service::Table::drop(Form& form) {
  for (const Made& one : form.made) let_go(form, one);
  form.made.clear();
}

void Service::Table::let_go(Form& form, const Made& one) {
  form.rows->entries_[one.node].put({});
  blocks_.give_back(one.block, one.bytes);
  formed_bytes_ -= one.bytes;
}

void Service::Table::make_room() {
  if (bytes_ + formed_bytes_ <= options_.memory_bytes) return;
  for (Form& form : forms_) drop(form);
  for (const std::unique_ptr<Slice>& slice : slices_) let_go_all_interpolated(*slice);
}

}  // namespace tress::adaptive
