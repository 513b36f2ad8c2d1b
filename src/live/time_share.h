// Limits how often a task runs during a render, so that it takes at most a share of the time.
#pragma once

#include <chrono>

namespace tress::live {

/// One thread at a time.
class TimeShare {
 public:
  using Clock = std::chrono::steady_clock;
  using Seconds = std::chrono::duration<double>;

  /// share: of the time since `start`, in (0, 1].
  explicit TimeShare(double share, Clock::time_point start = Clock::now()) : share_(share), start_(start) {}

  /// Whether doing it once more, in the time that it took last, stays within the share. The first time is always due.
  bool is_due(Clock::time_point now = Clock::now()) const {
    return last_ < Seconds(0) || (spent_ + last_) <= share_ * Seconds(now - start_);
  }
  void spent(Seconds time) {
    last_ = time;
    spent_ += time;
  }
  Seconds spent() const { return spent_; }

 private:
  double share_;
  Clock::time_point start_;
  Seconds spent_{0}, last_{-1};
};

}  // namespace tress::live
