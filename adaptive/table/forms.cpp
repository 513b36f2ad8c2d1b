// Answers of rows in a form: which rows have one, how queries of them count, and which of them memory has room for.
#include <algorithm>
#include <tuple>
#include <utility>

#include "table/table.h"

namespace tress::inline v0_2::adaptive {
namespace {

/// Whether a row answers without evaluating g.
bool has_answer(const RowView& row) { return row.state == RowState::converged || row.ribbons != nullptr; }

}  // namespace

/// Something that readers may make: a form's answer of a node or, without a form, its interpolated answer.
struct Service::Table::Makeable {
  static constexpr std::uint32_t no_form = ~0u;
  SliceId slice;
  std::uint32_t node, form;
  bool has_row;  ///< whether the node has a row of its own
  std::size_t bytes;
};

template <class Visit>
void Service::Table::for_each_makeable(SliceId id, const std::vector<std::uint32_t>& forms, const Visit& visit) const {
  const Slice& slice = rows_.slice(id);
  if (!slice.has_index()) return;
  for (std::uint32_t node = 0; node < slice.description.node_count(); ++node) {
    const Slot& slot = slice.slots[node];
    if (!slot.has_answer() && !may_be_interpolated(slice, node)) continue;
    RowView row = slot.has_answer() ? view_of(slot) : RowView{};
    row.slice = id;
    row.node = node;
    for (const std::uint32_t form : forms) {
      const FormedRows& rows = forms_.rows(form);
      if (FormStore::has_entries(rows) && rows.form().instead_of_row(node) == nullptr)
        visit(Makeable{id, node, form, slot.has_answer(), FormStore::bytes_of(rows, row)});
    }
    if (!slot.has_answer()) visit(Makeable{id, node, Makeable::no_form, false, sizeof(RibbonAnswer)});
  }
}

Result<const FormedRows*> Service::Table::add_form(SliceId slice, std::shared_ptr<const RowForm> form,
                                                   const std::vector<float>& decay_rates) {
  if (std::optional<Error> early = discipline_.within_pass("add_form")) return std::move(*early);
  if (slice >= rows_.slice_count()) return no_such_slice("add_form", slice);
  if (form == nullptr) return Error{"", "add_form", "a form", "none"};
  const SliceDescription& description = rows_.slice(slice).description;
  const std::size_t size = sizeof(RowEntry) * description.node_count();
  const bool has_room = bytes_ + formed_bytes_ + size <= options_.memory_bytes;
  for (const float rate : decay_rates) rows_.slice(slice).add_rate(rate);
  const auto index = static_cast<std::uint32_t>(forms_.size());
  rows_.slice(slice).forms.push_back(index);
  const FormedRows* rows = forms_.add(slice, description, std::move(form), has_room, !options_.check_passes);
  if (forms_.is_marked()) return rows;  // what it asks for is granted at the next publish()
  for_each_makeable(slice, {index}, [this](const Makeable& one) {
    if (one.form != Makeable::no_form) makeable_bytes_ += one.bytes;
  });
  if (bytes_ + forms_.entry_bytes() + makeable_bytes_ > options_.memory_bytes) grant_forms();
  return rows;
}

bool Service::Table::has_room_for_form(const FormedRows& rows, std::uint32_t node) const {
  return FormStore::has_entries(rows) && forms_.ask(rows, node);
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
    if (options_.check_passes && found.answer.has_row())
      rows_.slice(id).slots[node].queries.fetch_add(1, std::memory_order_relaxed);
    else
      count_formed(found.answer.has_row() ? 1 : 0, found.answer.has_converged() ? 1 : 0);
    return found;
  }
  if (!rows_.slice(id).has_index() || !has_room_for_form(rows, node)) return found;
  found.answer = forms_.wake(rows, node);
  const Slice& slice = rows_.slice(id);
  Slot& slot = slice.slots[node];
  RowState state = found.answer.has_converged() ? RowState::converged
                   : slot.row != Slot::no_row   ? RowState::open
                                                : RowState::absent;
  if (!found.answer) {
    const RowView row = view_at(id, node);
    if (!has_answer(row)) return found;
    found.answer = forms_.make(rows, row);
    state = row.state;
  }
  if (options_.check_passes) {
    slot.queries.fetch_add(1, std::memory_order_relaxed);
  } else {
    // Shows that the row is in use and may be audited. How often a form is missing depends on threads, so that it is
    // not counted as a query of the node.
    slice.formed[node].store(1, std::memory_order_relaxed);
    count_formed(1, state == RowState::converged ? 1 : 0);
  }
  found.row = bare_view(state, id, node);
  found.row.row = slot.row;
  return found;
}

FormedLookup Service::Table::look_up(const FormedRows& rows, std::uint32_t node) {
  FormedLookup found = fetch(rows, node);
  if (found.answer) return found;
  const SliceId id = rows.slice();
  if (forms_.has(rows) && rows_.slice(id).has_index() && node < rows_.slice(id).description.node_count()) {
    Slice& slice = rows_.slice(id);
    const Slot& slot = slice.slots[node];
    if ((slot.has_answer() || may_be_interpolated(slice, node)) && !has_room_for_form(rows, node)) {
      without_form_.add(1);
      found.row = bare_view(RowState::absent, id, node);
      if (!slice.is_sampled()) add_g(found.row);
      return found;
    }
  }
  found.row = look_up(id, node / rows.width(), node % rows.width());
  return found;
}

void Service::Table::make_again(const FormedRows& rows, std::uint32_t node) {
  const Slice& slice = rows_.slice(rows.slice());
  if (!FormStore::has_entries(rows) || !slice.has_index() || forms_.find(rows, node)) return;
  const RowView row = view_at(rows.slice(), node);
  if (has_answer(row)) (void)forms_.make(rows, row);
}

void Service::Table::reserve_forms() {
  reserved_bytes_ = 0;
  for (SliceId id = 0; id < rows_.slice_count(); ++id) {
    for_each_makeable(id, rows_.slice(id).forms, [this](const Makeable& one) {
      if (one.has_row && forms_.was_asked(forms_.rows(one.form), one.node)) reserved_bytes_ += one.bytes;
    });
  }
}

std::size_t Service::Table::asked_form_bytes(SliceId id, std::uint32_t node) const {
  std::size_t bytes = 0;
  RowView row;
  row.slice = id;
  row.node = node;
  for (const std::uint32_t form : rows_.slice(id).forms) {
    const FormedRows& rows = forms_.rows(form);
    if (FormStore::has_entries(rows) && forms_.was_asked(rows, node)) bytes += FormStore::bytes_of(rows, row);
  }
  return bytes;
}

bool Service::Table::is_granted(const Makeable& one) const {
  return one.form != Makeable::no_form ? forms_.is_granted(forms_.rows(one.form), one.node)
                                       : FormMarks::has(rows_.slice(one.slice).marks, one.node, FormMarks::granted);
}

bool Service::Table::was_asked(const Makeable& one) const {
  if (one.form != Makeable::no_form) return forms_.was_asked(forms_.rows(one.form), one.node);
  const Slice& slice = rows_.slice(one.slice);
  if (slice.marks != nullptr) return FormMarks::has(slice.marks, one.node, FormMarks::asked);
  return slice.forms.empty() && slice.slots[one.node].interpolated() != nullptr;  // not made on the way to a form
}

void Service::Table::count_makeable() {
  makeable_bytes_ = 0;
  for (SliceId id = 0; id < rows_.slice_count(); ++id) {
    for_each_makeable(id, rows_.slice(id).forms, [this](const Makeable& one) {
      if (!forms_.is_marked() || is_granted(one)) makeable_bytes_ += one.bytes;
    });
  }
}

void Service::Table::mark_all() {
  forms_.mark_all();
  for (const std::unique_ptr<Slice>& slice : rows_.slices()) {
    if (slice->has_index() && slice->levels.coarse() > 0)
      slice->marks = FormMarks::make(slice->description.node_count());
  }
}

void Service::Table::free_all() {
  forms_.free_all();
  for (const std::unique_ptr<Slice>& slice : rows_.slices()) slice->marks.reset();
}

void Service::Table::grant(const Makeable& one) {
  if (one.form != Makeable::no_form) {
    forms_.grant(forms_.rows(one.form), one.node);
  } else {
    rows_.slice(one.slice).marks[one.node].store(FormMarks::granted, std::memory_order_relaxed);
  }
}

bool Service::Table::other_forms_pay() const {
  if (!forms_.is_marked() || without_form_.sum() + without_room_.sum() == 0) return false;
  constexpr std::size_t none = ~std::size_t{0};
  const std::size_t taken = bytes_ + forms_.entry_bytes() + makeable_bytes_;
  std::size_t free = options_.memory_bytes - std::min(taken, options_.memory_bytes), least = none;
  for (SliceId id = 0; id < rows_.slice_count(); ++id) {
    for_each_makeable(id, rows_.slice(id).forms, [&](const Makeable& one) {
      const bool asked = was_asked(one), granted = is_granted(one);
      if (granted && !asked) free += one.bytes;
      if (asked && !granted) least = std::min(least, one.bytes);
    });
  }
  return least <= free;
}

void Service::Table::grant_forms() {
  makeable_bytes_ = 0;
  for (SliceId id = 0; id < rows_.slice_count(); ++id) {
    for_each_makeable(id, rows_.slice(id).forms, [this](const Makeable& one) { makeable_bytes_ += one.bytes; });
  }
  const std::size_t others = bytes_ + forms_.entry_bytes();
  if (others + makeable_bytes_ <= options_.memory_bytes) {
    free_all();
    return;
  }

  /// Lower ones come first.
  struct Rank {
    int use;  ///< 0: asked for in the pass, 1: made or granted before, 2: neither
    std::uint64_t light;
    std::uint32_t events;
    Makeable one;
  };
  std::vector<Rank> ranks;
  for (SliceId id = 0; id < rows_.slice_count(); ++id) {
    const Slice& slice = rows_.slice(id);
    for_each_makeable(id, slice.forms, [&](const Makeable& one) {
      const bool asked = was_asked(one), granted = is_granted(one);
      const bool is_by_product = one.form == Makeable::no_form && !slice.forms.empty();
      if (is_by_product && !asked && !granted) return;
      ranks.push_back({asked     ? 0
                       : granted ? 1
                                 : 2,
                       slice.light_at(one.node), slice.events[one.node].load(std::memory_order_relaxed), one});
    });
  }
  std::ranges::sort(ranks, [this](const Rank& x, const Rank& y) {
    if (x.use != y.use) return x.use < y.use;
    if (x.light != y.light) return x.light > y.light;
    if (x.events != y.events) return x.events > y.events;
    if (x.one.slice != y.one.slice)
      return rows_.slice(x.one.slice).description.key < rows_.slice(y.one.slice).description.key;
    return std::tie(x.one.node, x.one.form) < std::tie(y.one.node, y.one.form);
  });

  mark_all();
  std::size_t room = options_.memory_bytes - std::min(others, options_.memory_bytes);
  makeable_bytes_ = 0;
  for (const Rank& rank : ranks) {
    const Makeable& one = rank.one;
    if (one.bytes > room) continue;
    room -= one.bytes;
    makeable_bytes_ += one.bytes;
    grant(one);
  }
  forms_.rest_all();
  for (const std::unique_ptr<Slice>& slice : rows_.slices()) {
    std::erase_if(slice->interpolated, [&](std::uint32_t node) {
      if (FormMarks::has(slice->marks, node, FormMarks::granted)) return false;
      let_go_interpolated(*slice, node);
      return true;
    });
  }
}

}  // namespace tress::inline v0_2::adaptive
