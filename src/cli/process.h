// What a process is given and must live with: standard streams, signals, cores.
#pragma once

#include <atomic>
#include <functional>
#include <optional>

#include "tress/base/error.h"

namespace tress::cli {

/// To be called first. Puts something in the place of closed streams, lest a file that is opened takes the number of
/// one and is written into by messages; writing there fails. A pipe without a reader, or a file as large as is allowed,
/// becomes an error of that write, where it would have killed the process with all that it has not saved.
void prepare_standard_streams();

/// Error if standard output has not taken all of the results.
std::optional<Error> flush_results();

/// SIGINT, SIGTERM, SIGHUP: the first asks for an end with everything saved, the second kills. Handles the signals
/// while it lives; one at a time in the process. A SIGHUP that the caller ignores
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

/// Runs `work` with that many threads (oneTBB), unset: one per hardware thread that the process may use; `work` is
/// given the number. Returns what it returns.
int run_threaded(std::optional<int> threads, const std::function<int(int)>& work);

}  // namespace tress::cli
