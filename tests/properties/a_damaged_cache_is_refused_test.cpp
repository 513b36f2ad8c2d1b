// No prefix of a cache, no cache with a tail and no cache with changed bytes is taken for one, and the reason is
// reported.
#include <string>

#include "properties/generators.h"

namespace tress::inline v0_2::adaptive {
namespace {

void expect_refused(const std::string& bytes) {
  const Result<TableSnapshot> read = decode_cache(bytes, any_model, "a.cache");
  RC_ASSERT(!read.has_value());
  RC_ASSERT(read.error().file == "a.cache");
  RC_ASSERT(!read.error().place.empty() && !read.error().expected.empty() && !read.error().found.empty());
}

RC_GTEST_PROP(Cache, OfWhichThereIsOnlyAPrefixIsRefused, ()) {
  const std::string bytes = encode_cache(*any_image());
  for (const std::uint32_t at : *any_numbers(16, static_cast<std::uint32_t>(bytes.size()))) {
    expect_refused(bytes.substr(0, at));
  }
}

RC_GTEST_PROP(Cache, WithATailIsRefused, ()) {
  const std::string bytes = encode_cache(*any_image());
  std::string tail;
  for (const std::uint32_t byte : *any_numbers(4, 256)) expect_refused(bytes + (tail += static_cast<char>(byte)));
}

RC_GTEST_PROP(Cache, WithAChangedByteIsRefused, ()) {
  const std::string bytes = encode_cache(*any_image());
  for (const std::uint32_t at : *any_numbers(16, static_cast<std::uint32_t>(bytes.size()))) {
    std::string changed = bytes;
    changed[at] = static_cast<char>(changed[at] ^ static_cast<int>(1 + at % 255));
    expect_refused(changed);
  }
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
