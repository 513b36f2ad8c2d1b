// SIGINT, SIGTERM, SIGHUP: the first asks for an end with everything saved, the second kills.
#pragma once

#include <atomic>

namespace tress::cli {

/// Handles the signals while it lives; one at a time in the process. A SIGHUP that the caller ignores
/// (nohup) stays ignored. The former handlers return with its end.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  /// Set by the first signal. Any thread.
  const std::atomic<bool>& requested() const;
  /// 130 after SIGINT, 143 after SIGTERM, 129 after SIGHUP, 0 before any.
  int exit_status() const;
};

}  // namespace tress::cli
