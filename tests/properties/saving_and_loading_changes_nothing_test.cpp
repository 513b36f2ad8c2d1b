// A table is what its bytes say: encoded and decoded it is the same table, field by field and byte by byte.
#include <algorithm>

#include "properties/generators.h"

namespace tress::inline v0_2::adaptive {
namespace {

/// What a file keeps of a row: the same but for what its state does not have.
void expect_same(const CachedRow& read, const CachedRow& written) {
  const bool open = written.state != RowState::converged;
  RC_ASSERT(read.node == written.node);
  RC_ASSERT(read.state == (open ? RowState::open : RowState::converged));
  RC_ASSERT(read.generation == written.generation);
  RC_ASSERT(read.count == written.count);
  RC_ASSERT(read.energy == written.energy);
  RC_ASSERT(read.objective == (open ? 0.0f : written.objective));
  RC_ASSERT((read.density() != nullptr) == (written.density() != nullptr));
  RC_ASSERT((read.ribbons() != nullptr) == (!open && written.ribbons() != nullptr));
  RC_ASSERT((read.ribbons() == nullptr || *read.ribbons() == *written.ribbons()));
  if (read.density() == nullptr) return;
  RC_ASSERT(read.density()->sketch == (open ? written.density()->sketch : std::vector<SketchBin>{}));
  if (open) return;
  const Mixture &a = read.density()->fit, &b = written.density()->fit;
  RC_ASSERT(a.component_count == b.component_count);
  RC_ASSERT(a.uniform_weight == b.uniform_weight);
  RC_ASSERT(a.uniform_attribute_mean == b.uniform_attribute_mean);
  RC_ASSERT(a.uniform_attribute_variance == b.uniform_attribute_variance);
  for (std::size_t d = 0; d < a.component_count; ++d) {
    const Component &x = a.components[d], &y = b.components[d];
    RC_ASSERT(x.shape.mu == y.shape.mu && x.shape.s_left == y.shape.s_left && x.shape.s_right == y.shape.s_right);
    RC_ASSERT(x.weight == y.weight);
    RC_ASSERT(x.attribute_mean == y.attribute_mean && x.attribute_variance == y.attribute_variance);
  }
}

RC_GTEST_PROP(Cache, DecodesWhatItEncoded, ()) {
  const TableSnapshot image = *any_image();
  const std::string bytes = encode_cache(image);
  const Result<TableSnapshot> read = decode_cache(bytes, any_model, "a.cache");
  RC_ASSERT(read.has_value());
  RC_ASSERT(encode_cache(*read) == bytes);
  RC_ASSERT(cache_hash(*read) == cache_hash(image));
  RC_ASSERT(read->model == image.model);
  RC_ASSERT(read->slices.size() == image.slices.size());
  for (std::size_t p = 0; p < image.slices.size(); ++p) {
    const CachedSlice &x = read->slices[p], &y = image.slices[p];
    RC_ASSERT(x.description.key == y.description.key);
    RC_ASSERT(x.description.axis_a == y.description.axis_a && x.description.axis_b == y.description.axis_b);
    RC_ASSERT(x.description.blur_rad == y.description.blur_rad && x.description.kind == y.description.kind);
    RC_ASSERT(x.rows.size() == y.rows.size());
    for (std::size_t r = 0; r < y.rows.size(); ++r) expect_same(x.rows[r], y.rows[r]);
  }
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
