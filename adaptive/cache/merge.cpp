#include <algorithm>
#include <cassert>
#include <utility>

#include "cache/format.h"

namespace tress::adaptive {
namespace {

std::string encoded(const CachedRow& row) {
  ByteWriter out;
  format::write_row(out, row);
  return out.take();
}

std::string encoded(const SliceDescription& slice) {
  ByteWriter out;
  format::write_description(out, slice);
  return out.take();
}

/// Unsigned bytes, as std::string compares them.
bool below(const CachedRow& a, const CachedRow& b) {
  const bool a_converged = a.state == RowState::converged, b_converged = b.state == RowState::converged;
  if (a.generation != b.generation) return a.generation < b.generation;
  if (a_converged != b_converged) return b_converged;
  if (a.objective != b.objective) return a.objective > b.objective;
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

CachedRow join(const CachedRow& a, const CachedRow& b) {
  const bool both_open = a.state != RowState::converged && b.state != RowState::converged;
  if (!both_open || a.generation != b.generation) return below(a, b) ? b : a;
  CachedRow row = a;
  row.sketch = minimum(a.sketch, b.sketch);
  row.count = std::max(a.count, b.count);
  row.energy = std::max(a.energy, b.energy);
  return row;
}

/// Union of two ascending lists; equal elements are joined.
template <class Item, class Less, class Join>
std::vector<Item> unite(const std::vector<Item>& a, const std::vector<Item>& b, Less less, Join join_equal) {
  std::vector<Item> result;
  result.reserve(std::max(a.size(), b.size()));
  auto i = a.begin(), j = b.begin();
  while (i != a.end() || j != b.end()) {
    if (j == b.end() || (i != a.end() && less(*i, *j))) {
      result.push_back(*i++);
    } else if (i == a.end() || less(*j, *i)) {
      result.push_back(*j++);
    } else {
      result.push_back(join_equal(*i++, *j++));
    }
  }
  return result;
}

/// One key, one description in one model; should two differ, the larger bytes win with all their rows.
CachedSlice join(const CachedSlice& a, const CachedSlice& b) {
  const std::string a_bytes = encoded(a.description), b_bytes = encoded(b.description);
  if (a_bytes != b_bytes) return a_bytes < b_bytes ? b : a;
  const auto by_node = [](const CachedRow& x, const CachedRow& y) { return x.node < y.node; };
  const auto join_rows = [](const CachedRow& x, const CachedRow& y) { return join(x, y); };
  return {a.description, unite(a.rows, b.rows, by_node, join_rows)};
}

}  // namespace

TableSnapshot merge_caches(const TableSnapshot& a, const TableSnapshot& b) {
  assert(a.model == b.model);
  const auto by_key = [](const CachedSlice& x, const CachedSlice& y) { return x.description.key < y.description.key; };
  const auto join_slices = [](const CachedSlice& x, const CachedSlice& y) { return join(x, y); };
  return {a.model, unite(a.slices, b.slices, by_key, join_slices)};
}

}  // namespace tress::adaptive
