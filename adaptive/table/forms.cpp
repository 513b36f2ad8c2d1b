// Answers of rows in a form: which rows have one, and how queries of them count.
#include <limits>
#include <utility>

#include "table/table.h"

namespace tress::inline v0_2::adaptive {
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

}  // namespace tress::inline v0_2::adaptive
