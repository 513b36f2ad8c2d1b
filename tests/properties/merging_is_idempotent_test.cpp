// Merging is idempotent: what is in a table already changes nothing in it, and the empty table never does.
#include "properties/generators.h"

namespace tress::inline v0_2::adaptive {
namespace {

RC_GTEST_PROP(Merging, IsIdempotentToTheByte, ()) {
  const TableSnapshot a = *any_image(), b = *any_image();
  RC_ASSERT(merged(a, a) == encode_cache(a));
  const TableSnapshot both = merge_caches(a, b);
  RC_ASSERT(merged(both, a) == encode_cache(both));
  RC_ASSERT(merged(b, both) == encode_cache(both));
}

RC_GTEST_PROP(Merging, WithTheEmptyTableChangesNothing, ()) {
  const TableSnapshot a = *any_image(), empty{any_model, {}};
  RC_ASSERT(merged(a, empty) == encode_cache(a));
  RC_ASSERT(merged(empty, a) == encode_cache(a));
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
