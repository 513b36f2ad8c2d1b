// The progress of a render, and its display.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "integrate/renderer.h"
#include "integrate/stop_rule.h"

namespace tress::cli {

using integrate::StopRule;

struct Outlook {
  const char* reason = nullptr;        ///< from StopRule::reason_to_end()
  double share = 0;                    ///< estimated share of the work that is done, [0, 1]
  std::optional<double> seconds_left;  ///< unset until it is known within a factor of two
};

/// Estimates the passes to come from those so far. One thread at a time.
class Forecast {
 public:
  explicit Forecast(const StopRule& rule) : rule_(rule) {}

  /// Call it after each pass, `elapsed` seconds after the command began. noise: the value that the stop rule uses. The
  /// time left until a noise is reached assumes that it falls as 1 / sqrt(samples).
  ///
  /// The first passes cost up to ten times a later one while rows are learned. So the time left is the work left at the
  /// pace of the later half of what is done. It is first given after a pass whose pace is within a quarter of that of
  /// the pass before; if rows are learned, both must be passes over the whole picture.
  Outlook after(const integrate::PassProgress& pass, double noise, double elapsed);
  Outlook after(const integrate::PassProgress& pass, double elapsed) { return after(pass, pass.noise, elapsed); }

 private:
  struct Done {
    double paths, seconds;  ///< at the end of a pass, since the start of the first
  };
  double pace() const;  ///< seconds per path
  void watch(const integrate::PassProgress& pass);

  StopRule rule_;
  std::vector<Done> done_{{0, 0}};
  double last_pace_ = 0;
  bool is_steady_ = false;
};

/// A step before the first pass, reported while it lasts. On a terminal the last line shows the step, its time and its
/// progress; elsewhere a line is printed after 5 s and then every 10 s. Short steps print nothing. While one exists,
/// only it and its thread may use the console.
class Step {
 public:
  explicit Step(std::string what);
  ~Step();
  Step(const Step&) = delete;
  Step& operator=(const Step&) = delete;
  /// Sets its progress, [0, 1]. Any thread.
  void set_share(double share) { share_.store(static_cast<float>(share), std::memory_order_relaxed); }

 private:
  void watch(const std::stop_token& stop);

  std::string what_;
  std::atomic<float> share_{0};
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::jthread watcher_;
};

/// The progress bar. One thread at a time. Prints nothing under --quiet.
class Progress {
 public:
  Progress();
  /// Call it after each pass.
  void update(const integrate::PassProgress& pass, const Outlook& outlook);
  /// Removes the bar.
  void finish();
  /// Time since construction.
  double seconds() const;

 private:
  std::chrono::steady_clock::time_point start_, last_line_;
};

}  // namespace tress::cli
