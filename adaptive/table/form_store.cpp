#include "table/form_store.h"

#include <algorithm>
#include <utility>

namespace tress::inline v0_2::adaptive {

const FormedRows* FormStore::add(SliceId slice, const SliceDescription& description,
                                 std::shared_ptr<const RowForm> form, bool has_entries, bool shows) {
  std::unique_ptr<FormedRows> rows(new FormedRows);
  rows->slice_ = slice;
  rows->index_ = static_cast<std::uint32_t>(forms_.size());
  rows->width_ = static_cast<std::uint32_t>(description.axis_b.size());
  rows->height_ = static_cast<std::uint32_t>(description.axis_a.size());
  rows->form_ = std::move(form);
  if (has_entries) {
    rows->entries_ = std::make_unique<RowEntry[]>(description.node_count());
    bytes_ += sizeof(RowEntry) * description.node_count();
    entry_bytes_ += sizeof(RowEntry) * description.node_count();
  }
  if (has_entries && is_marked_) rows->marks_ = FormMarks::make(description.node_count());
  if (has_entries && shows) {
    rows->shown_ = rows->entries_.get();
    rows->stride_ = rows->width_;
  } else {
    rows->empty_ = std::make_unique<RowEntry[]>(rows->width_);
    rows->shown_ = rows->empty_.get();
  }
  return forms_.emplace_back(std::move(rows)).rows.get();
}

RowAnswer FormStore::find(const FormedRows& rows, std::uint32_t node) const {
  RowEntry* entry = has_entries(rows) ? &rows.entries_[node] : nullptr;
  if (entry != nullptr) {
    if (const RowAnswer made = entry->get()) return made;
  }
  const void* instead = rows.form_->instead_of_row(node);
  if (instead == nullptr) return {};
  const RowAnswer answer = RowAnswer::without_row(instead);
  if (entry != nullptr) entry->put(answer);
  return answer;
}

RowAnswer FormStore::wake(const FormedRows& rows, std::uint32_t node) const {
  const std::vector<Made>& resting = forms_[rows.index_].resting;
  const auto found = std::ranges::lower_bound(resting, node, {}, &Made::node);
  if (found == resting.end() || found->node != node) return {};
  rows.entries_[node].put(found->answer());
  return found->answer();
}

RowAnswer FormStore::make(const FormedRows& rows, const RowView& row) {
  const std::size_t size = bytes_of(rows, row);
  bytes_.fetch_add(size, std::memory_order_relaxed);
  void* block = blocks_.take(size);
  rows.form_->write(row, block);
  const Made made{block, size, row.node, row.state == RowState::converged};
  const RowAnswer answer = rows.entries_[row.node].put_first(made.answer());
  if (answer.block() == block) {
    const std::scoped_lock lock(mutex_);
    forms_[rows.index_].made.push_back(made);
  } else {
    bytes_.fetch_sub(size, std::memory_order_relaxed);  // another thread has written the same bytes
    blocks_.give_back(block, size);
  }
  return answer;
}

void FormStore::mark_all() {
  is_marked_ = true;
  for (Form& form : forms_) {
    if (!has_entries(*form.rows)) continue;
    form.rows->marks_ = FormMarks::make(form.rows->width_ * form.rows->height_);
  }
}

void FormStore::free_all() {
  is_marked_ = false;
  for (Form& form : forms_) {
    form.rows->marks_.reset();
    for (const Made& one : form.resting) form.rows->entries_[one.node].put(one.answer());
    form.made.insert(form.made.end(), form.resting.begin(), form.resting.end());
    form.resting.clear();
  }
}

void FormStore::rest_all() {
  for (std::size_t i = 0; i < forms_.size(); ++i) {
    Form& form = forms_[i];
    drop_if(i, [&](std::uint32_t node) { return !is_granted(*form.rows, node); });
    form.resting.insert(form.resting.end(), form.made.begin(), form.made.end());
    form.made.clear();
    std::ranges::sort(form.resting, {}, &Made::node);
    for (const Made& one : form.resting) form.rows->entries_[one.node].put({});
  }
}

std::vector<std::uint32_t> FormStore::made_nodes(std::size_t form) const {
  std::vector<std::uint32_t> nodes;
  for (const std::vector<Made>* kept : {&forms_[form].made, &forms_[form].resting}) {
    for (const Made& one : *kept) nodes.push_back(one.node);
  }
  std::ranges::sort(nodes);  // so that the order does not depend on that of threads
  return nodes;
}

}  // namespace tress::inline v0_2::adaptive
