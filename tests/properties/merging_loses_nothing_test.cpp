// Merging is a maximum: of every node the larger row, by the order of CACHE_FORMAT.md written down once more here, and
// of open rows all that both saw. The result can be read.
#include <algorithm>
#include <span>

#include "cache/format.h"
#include "properties/generators.h"

namespace tress::inline v0_2::adaptive {
namespace {

/// The table of this row alone: equal rows are equal bytes.
std::string bytes_of(const CachedRow& row) {
  CachedSlice slice{description_of(0), {row}};
  return encode_cache({any_model, {slice}});
}

std::string encoded(const CachedRow& row) {
  ByteWriter out;
  format::write_row(out, row);
  return out.take();
}

std::span<const SketchBin> sketch_of(const CachedRow& row) {
  return row.density() != nullptr ? std::span(row.density()->sketch) : std::span<const SketchBin>();
}

bool is_open(const CachedRow& row) { return row.state != RowState::converged; }

/// Whether `row` has all that `other` has, and is not below it.
bool dominates(const CachedRow& row, const CachedRow& other) {
  if (row.generation != other.generation) return row.generation > other.generation;
  if (is_open(row) != is_open(other)) return is_open(other);
  if (is_open(row)) {
    if (row.count < other.count || row.energy < other.energy) return false;
    return std::ranges::all_of(sketch_of(other), [&](const SketchBin& bin) {
      const auto sketch = sketch_of(row);
      const auto same = std::ranges::find(sketch, bin.index, &SketchBin::index);
      return same != sketch.end() && same->bits <= bin.bits;
    });
  }
  const bool is_sampled = row.ribbons() != nullptr && other.ribbons() != nullptr;  // whose objectives are noisy
  if (!is_sampled && row.objective != other.objective) return row.objective < other.objective;
  if (row.count != other.count) return row.count > other.count;
  return encoded(row) >= encoded(other);
}

const CachedSlice* slice_of(const TableSnapshot& image, const SliceKey& key) {
  const auto found =
      std::ranges::find(image.slices, key, [](const CachedSlice& slice) { return slice.description.key; });
  return found != image.slices.end() ? &*found : nullptr;
}

const CachedRow* row_of(const CachedSlice* slice, std::uint32_t node) {
  if (slice == nullptr) return nullptr;
  const auto found = std::ranges::find(slice->rows, node, &CachedRow::node);
  return found != slice->rows.end() ? &*found : nullptr;
}

RC_GTEST_PROP(Merging, KeepsOfEachNodeTheLargerRowAndNoOther, ()) {
  const TableSnapshot a = *any_image(), b = *any_image();
  const TableSnapshot both = merge_caches(a, b);
  for (std::size_t index = 0; index < all_keys; ++index) {
    const CachedSlice *of_a = slice_of(a, key_of(index)), *of_b = slice_of(b, key_of(index));
    const CachedSlice* of_both = slice_of(both, key_of(index));
    RC_ASSERT((of_both != nullptr) == (of_a != nullptr || of_b != nullptr));
    if (of_both == nullptr) continue;
    if (of_a && of_b && of_a->description.axis_b != of_b->description.axis_b) {
      // One of the two whole, the same for either order (commutative).
      const CachedSlice* kept = of_both->description.axis_b == of_a->description.axis_b ? of_a : of_b;
      RC_ASSERT(encode_cache({any_model, {*kept}}) == encode_cache({any_model, {*of_both}}));
      continue;
    }
    for (std::uint32_t node = 0; node < of_both->description.node_count(); ++node) {
      const CachedRow *x = row_of(of_a, node), *y = row_of(of_b, node), *kept = row_of(of_both, node);
      RC_ASSERT((kept != nullptr) == (x != nullptr || y != nullptr));
      if (kept == nullptr) continue;
      for (const CachedRow* one : {x, y}) RC_ASSERT((one == nullptr || dominates(*kept, *one)));
      const bool is_one = (x && bytes_of(*kept) == bytes_of(*x)) || (y && bytes_of(*kept) == bytes_of(*y));
      if (is_one) continue;
      // Only two open rows of one generation become a third.
      RC_ASSERT((x && y && is_open(*x) && is_open(*y) && x->generation == y->generation));
      RC_ASSERT(kept->count == std::max(x->count, y->count));
      for (const SketchBin& bin : sketch_of(*kept)) {
        const auto of_x = sketch_of(*x), of_y = sketch_of(*y);
        RC_ASSERT(std::ranges::find(of_x, bin) != of_x.end() || std::ranges::find(of_y, bin) != of_y.end());
      }
    }
  }
}

RC_GTEST_PROP(Merging, GivesATableThatCanBeRead, ()) {
  const TableSnapshot both = merge_caches(*any_image(), *any_image());
  const Result<TableSnapshot> read = decode_cache(encode_cache(both), any_model, "both.cache");
  RC_ASSERT(read.has_value());
  RC_ASSERT(encode_cache(*read) == encode_cache(both));
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
