// Statistical tests state their seeds. TRESS_TEST_SEED=N in the environment gives all of them others.
#pragma once

#include <cstdint>
#include <cstdlib>

namespace tress::test {

/// The stated seed; with TRESS_TEST_SEED=N, N million and 3 N more, so that no two tests swap theirs.
inline std::uint64_t seed(std::uint64_t stated) {
  static const std::uint64_t moved = [] {
    const char* text = std::getenv("TRESS_TEST_SEED");
    return text == nullptr ? 0 : std::strtoull(text, nullptr, 10);
  }();
  return stated + 1'000'003 * moved;
}

}  // namespace tress::test
