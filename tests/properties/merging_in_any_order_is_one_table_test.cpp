// Any list of tables, in any order, bracketed in any way, some of them more than once: one file, to the byte.
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "properties/generators.h"

namespace tress::inline v0_2::adaptive {
namespace {

/// Merges neighbours until one is left; `choices` says which.
TableSnapshot merge_all(std::vector<TableSnapshot> tables, const std::vector<std::uint32_t>& choices) {
  for (std::size_t step = 0; tables.size() > 1; ++step) {
    const std::size_t at = choices[step % choices.size()] % (tables.size() - 1);
    tables[at] = merge_caches(tables[at], tables[at + 1]);
    tables.erase(tables.begin() + static_cast<std::ptrdiff_t>(at) + 1);
  }
  return tables.front();
}

TRESS_DEAR_PROPERTY(Merging, OfAnyListInAnyOrderIsOneTable, 50) {
  std::vector<TableSnapshot> tables = *any_images(5);
  const std::string wanted = encode_cache(merge_all(tables, {0}));
  const std::vector<std::uint32_t> choices = *any_numbers(8, 12);
  // Each twice, moved about.
  const std::vector<TableSnapshot> once = tables;
  tables.insert(tables.end(), once.begin(), once.end());
  for (std::size_t i = tables.size(); i > 1; --i) std::swap(tables[i - 1], tables[choices[i % 8] % i]);
  RC_ASSERT(encode_cache(merge_all(tables, choices)) == wanted);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
