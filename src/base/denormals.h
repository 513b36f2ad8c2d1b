// Treats denormal floats as zero while a task runs: each costs a hundred cycles, and every task must treat them alike.
#pragma once

#if defined(__SSE2__)
#include <pmmintrin.h>
#include <xmmintrin.h>
#endif

namespace tress::inline v0_2 {

/// Flushes denormals to zero on this thread until the end of the scope. Put it into every task, never once per thread:
/// the thread of a task is random, and the pixels must not depend on it. Does nothing except on x86.
class FlushDenormals {
 public:
#if defined(__SSE2__)
  FlushDenormals() : before_(_mm_getcsr()) {
    _mm_setcsr(before_ | static_cast<unsigned>(_MM_FLUSH_ZERO_ON) | static_cast<unsigned>(_MM_DENORMALS_ZERO_ON));
  }
  ~FlushDenormals() { _mm_setcsr(before_); }
#else
  FlushDenormals() {}
  ~FlushDenormals() {}
#endif
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

#if defined(__SSE2__)
 private:
  unsigned before_;
#endif
};

}  // namespace tress::inline v0_2
