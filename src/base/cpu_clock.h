// CPU time of the calling thread.
#pragma once

#include <ctime>

namespace tress::inline v0_2 {

/// Seconds of CPU that the calling thread has used. A call takes about 0.2 us. Any thread.
inline double thread_cpu_seconds() {
  std::timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace tress::inline v0_2
