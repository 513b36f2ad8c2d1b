// Merging is commutative: whichever of two tables comes first, the file is the same to the byte.
#include "properties/generators.h"

namespace tress::inline v0_2::adaptive {
namespace {

RC_GTEST_PROP(Merging, IsCommutativeToTheByte, ()) {
  const TableSnapshot a = *any_image(), b = *any_image();
  RC_ASSERT(merged(a, b) == merged(b, a));
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
