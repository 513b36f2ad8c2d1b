#include "table/form_store.h"

#include <algorithm>
#include <new>
#include <utility>

namespace tress::inline v0_2::adaptive {

const FormedRows* FormStore::add(SliceId slice, const SliceDescription& description,
                                 std::shared_ptr<const RowForm> form, bool has_entries) {
  std::unique_ptr<FormedRows> rows(new FormedRows);
  rows->slice_ = slice;
  rows->index_ = static_cast<std::uint32_t>(forms_.size());
  rows->width_ = static_cast<std::uint32_t>(description.axis_b.size());
  rows->height_ = static_cast<std::uint32_t>(description.axis_a.size());
  rows->form_ = std::move(form);
  rows->stride_ = has_entries ? rows->width_ : 0;
  rows->owned_ = std::make_unique<RowEntry[]>(has_entries ? description.node_count() : rows->width_);
  rows->entries_ = rows->owned_.get();
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

FormedLookup FormStore::make(const FormedRows& rows, const RowView& row, std::size_t room) {
  FormedLookup found;
  const bool has_converged = row.state == RowState::converged;
  const std::size_t size = decltype(blocks_)::rounded(rows.form_->bytes(row));
  const std::size_t before = bytes_.fetch_add(size, std::memory_order_relaxed);
  if (!has_entries(rows) || before + size > room) {
    bytes_.fetch_sub(size, std::memory_order_relaxed);
    constexpr std::align_val_t line{line_bytes};
    std::shared_ptr<void> block(::operator new(size, line), [](void* memory) { ::operator delete(memory, line); });
    rows.form_->write(row, block.get());
    found.answer = RowAnswer::of_row(block.get(), has_converged);
    found.kept = std::move(block);
    return found;
  }
  void* block = blocks_.take(size);
  rows.form_->write(row, block);
  found.answer = rows.entries_[row.node].put_first(RowAnswer::of_row(block, has_converged));
  if (found.answer.block() == block) {
    const std::scoped_lock lock(mutex_);
    forms_[rows.index_].made.push_back({block, size, row.node});
  } else {
    bytes_.fetch_sub(size, std::memory_order_relaxed);  // another thread has written the same bytes
    blocks_.give_back(block, size);
  }
  return found;
}

std::vector<std::uint32_t> FormStore::made_nodes(std::size_t form) const {
  std::vector<std::uint32_t> nodes;
  for (const Made& one : forms_[form].made) nodes.push_back(one.node);
  std::ranges::sort(nodes);  // so that the order does not depend on that of threads
  return nodes;
}

}  // namespace tress::inline v0_2::adaptive
