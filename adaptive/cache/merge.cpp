#include <algorithm>
#include <cassert>
#include <utility>

#include "cache/format.h"

namespace tress::inline v0_2::adaptive {
namespace {

std::string encoded(const CachedRow& row) {
  ByteWriter out;
  format::write_row(out, row);
  return out.take();
}

/// Compares as unsigned bytes, as std::string does.
bool below(const CachedRow& a, const CachedRow& b) {
  const bool a_converged = a.state == RowState::converged, b_converged = b.state == RowState::converged;
  if (a.generation != b.generation) return a.generation < b.generation;
  if (a_converged != b_converged) return b_converged;
  // The objective of a row of samples is a noisy test result: to keep the lowest of many would be convergence by
  // selection.
  const bool are_noisy = a.ribbons() != nullptr && b.ribbons() != nullptr;
  if (!are_noisy && a.objective != b.objective) return a.objective > b.objective;
  if (a.count != b.count) return a.count < b.count;
  return encoded(a) < encoded(b);
}

std::vector<SketchBin> minimum(const std::vector<SketchBin>& a, const std::vector<SketchBin>& b) {
  std::vector<SketchBin> result;
  result.reserve(std::max(a.size(), b.size()));
  auto i = a.begin(), j = b.begin();
  while (i != a.end() || j != b.end()) {
    if (j == b.end() || (i != a.end() && i->index < j->index)) {
      result.push_back(*i++);
    } else if (i == a.end() || j->index < i->index) {
      result.push_back(*j++);
    } else {
      result.push_back({i->index, std::min(i->bits, j->bits)});
      ++i, ++j;
    }
  }
  return result;
}

}  // namespace

MergedRows::MergedRows(RowSource& a, RowSource& b) : a_{a}, b_{b} {
  assert(a.model() == b.model());
  rewind();
}

void MergedRows::rewind() {
  for (Side* side : {&a_, &b_}) {
    side->rows.rewind();
    side->slice = nullptr;
    side->row = nullptr;
    side->is_current = false;
    side->has_slice = side->has_row = true;
  }
}

/// Reads the next slice of the side, if the last one has been returned.
void MergedRows::read_slice(Side& side) {
  if (side.has_slice) side.slice = side.rows.next_slice();
  side.has_slice = side.is_current = false;
}

void MergedRows::read_row(Side& side) {
  if (side.has_row) side.row = side.is_current ? side.rows.next_row() : nullptr;
  side.has_row = false;
}

/// Two slices of one key have the same description in one model. Should they differ, the one with the larger bytes is
/// kept with all its rows.
const SliceDescription* MergedRows::next_slice() {
  read_slice(a_);
  read_slice(b_);
  a_.has_row = b_.has_row = true;
  if (a_.slice == nullptr && b_.slice == nullptr) return nullptr;
  const bool a_first = b_.slice == nullptr || (a_.slice != nullptr && a_.slice->key < b_.slice->key);
  const bool b_first = a_.slice == nullptr || (b_.slice != nullptr && b_.slice->key < a_.slice->key);
  a_.has_slice = a_.is_current = !b_first;
  b_.has_slice = b_.is_current = !a_first;
  if (a_.is_current && b_.is_current) {
    const std::string a = format::described(*a_.slice), b = format::described(*b_.slice);
    a_.is_current = !(a < b);
    b_.is_current = !(b < a);
  }
  return a_.is_current ? a_.slice : b_.slice;
}

const CachedRow* MergedRows::next_row() {
  read_row(a_);
  read_row(b_);
  const CachedRow *a = a_.row, *b = b_.row;
  if (a == nullptr && b == nullptr) return nullptr;
  a_.has_row = b == nullptr || (a != nullptr && a->node <= b->node);
  b_.has_row = a == nullptr || (b != nullptr && b->node <= a->node);
  if (!a_.has_row || !b_.has_row) return a_.has_row ? a : b;
  const bool both_open = a->state != RowState::converged && b->state != RowState::converged;
  if (!both_open || a->generation != b->generation) return below(*a, *b) ? b : a;
  joined_ = *a;
  if (a->density() != nullptr && b->density() != nullptr)
    joined_.density()->sketch = minimum(a->density()->sketch, b->density()->sketch);
  joined_.count = std::max(a->count, b->count);
  joined_.energy = std::max(a->energy, b->energy);
  return &joined_;
}

std::optional<Error> MergedRows::failure() const {
  std::optional<Error> error = a_.rows.failure();
  return error ? error : b_.rows.failure();
}

TableSnapshot collect(RowSource& rows) {
  TableSnapshot table{rows.model(), {}};
  rows.rewind();
  while (const SliceDescription* slice = rows.next_slice()) {
    CachedSlice& all = table.slices.emplace_back(CachedSlice{*slice, {}});
    while (const CachedRow* row = rows.next_row()) all.rows.push_back(*row);
  }
  return table;
}

TableSnapshot merge_caches(const TableSnapshot& a, const TableSnapshot& b) {
  SnapshotRows from_a(a), from_b(b);
  MergedRows both(from_a, from_b);
  return collect(both);
}

}  // namespace tress::inline v0_2::adaptive
