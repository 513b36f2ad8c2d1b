// Merging is associative: however three tables are bracketed, the file is the same to the byte.
#include "properties/generators.h"

namespace tress::inline v0_2::adaptive {
namespace {

RC_GTEST_PROP(Merging, IsAssociativeToTheByte, ()) {
  const TableSnapshot a = *any_image(), b = *any_image(), c = *any_image();
  RC_ASSERT(merged(merge_caches(a, b), c) == merged(a, merge_caches(b, c)));
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
