// How much memory is taken by new, at the peak: for tests of what a step needs.
#pragma once

#include <cstddef>

namespace tress::testing {

/// Live bytes of all operator new of this program, all threads. Defined, with the operators, in counted_heap.cpp.
std::size_t heap_bytes();
/// The most that heap_bytes() has been since the last restart_peak().
std::size_t heap_peak();
void restart_peak();

/// The peak of what `step` takes beyond what was taken before it.
template <class Step>
std::size_t peak_of(Step&& step) {
  restart_peak();
  const std::size_t before = heap_bytes();
  step();
  return heap_peak() - before;
}

}  // namespace tress::testing
