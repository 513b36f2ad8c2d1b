// The environment of the process: standard streams, signals, cores.
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <stop_token>
#include <thread>

#include "tress/base/error.h"

namespace tress::cli {

/// Call it first. It replaces closed streams, because otherwise a file that is opened could take the number of one, and
/// messages would be written into it; writing to the replacement fails. A pipe without a reader, or a file at its size
/// limit, makes the write fail instead of killing the process with all unsaved results.
void prepare_standard_streams();

/// Error if standard output has not taken all results.
std::optional<Error> flush_results();

/// Handles SIGINT, SIGTERM and SIGHUP while it lives: the first signal requests an end with everything saved, the
/// second kills. One at a time in the process. A SIGHUP that the caller ignores (nohup) stays ignored. The former
/// handlers are restored at its end.
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

/// After a signal the current pass may continue for a while, so that nothing of it is lost. Any thread.
class Deadline {
 public:
  /// asked: set by the signal, must outlive it; seconds: from then on, 0: no limit. dropped: whether the pass is no
  /// longer needed; a thread of the deadline calls it every 20 ms.
  Deadline(const std::atomic<bool>& asked, double seconds, std::function<bool()> dropped);
  const std::atomic<bool>& passed() const { return passed_; }

 private:
  void watch(const std::stop_token& over, double seconds);

  const std::atomic<bool>& asked_;
  std::function<bool()> dropped_;
  std::atomic<bool> passed_{false};
  std::jthread watcher_;
};

/// Runs `work` with that many threads (oneTBB); unset: one per hardware thread that the process may use. `work` gets
/// the number. Returns what it returns.
int run_threaded(std::optional<int> threads, const std::function<int(int)>& work);

}  // namespace tress::cli
