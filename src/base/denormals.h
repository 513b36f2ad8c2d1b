// Denormal floats as zero while a task runs: they cost a hundred cycles each, and every task must agree on them.
#pragma once

#if defined(__SSE2__)
#include <pmmintrin.h>
#include <xmmintrin.h>
#endif

namespace tress {

/// Flushes denormals to zero on this thread from here to the end of the scope. To be put into every task, never once
/// per thread: which thread runs a task is chance, the pixels must not be. Does nothing but on x86.
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

}  // namespace tress
