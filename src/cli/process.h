// What a process is given and must live with: standard streams, signals, cores.
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <stop_token>
#include <thread>

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

/// After a signal the running pass may go on for a while, so that nothing of it is lost. Any thread.
class Deadline {
 public:
  /// asked: set by the signal, outlives it; seconds: from then on, 0: none. dropped: whether the pass is not wanted any
  /// more, asked every 20 ms by a thread of the deadline.
  Deadline(const std::atomic<bool>& asked, double seconds, std::function<bool()> dropped);
  const std::atomic<bool>& passed() const { return passed_; }

 private:
  void watch(const std::stop_token& over, double seconds);

  const std::atomic<bool>& asked_;
  std::function<bool()> dropped_;
  std::atomic<bool> passed_{false};
  std::jthread watcher_;
};

/// Runs `work` with that many threads (oneTBB), unset: one per hardware thread that the process may use; `work` is
/// given the number. Returns what it returns.
int run_threaded(std::optional<int> threads, const std::function<int(int)>& work);

}  // namespace tress::cli
