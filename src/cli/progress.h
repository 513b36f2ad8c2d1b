// How far a render is, and what of that is shown.
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
  const char* reason = nullptr;        ///< StopRule::reason_to_end()
  double share = 0;                    ///< of the work that is done, as far as can be told, [0, 1]
  std::optional<double> seconds_left;  ///< unset until it can be known within a factor of two
};

/// What the passes so far tell of those to come. One thread at a time.
class Forecast {
 public:
  explicit Forecast(const StopRule& rule) : rule_(rule) {}

  /// After each pass, `elapsed` seconds after the command began. noise: what the rule goes by. The time left until a
  /// noise is reached takes it to fall as 1 / sqrt(samples).
  ///
  /// The first passes cost up to ten times a later one, as long as rows are learned. So the time left is the work left
  /// at the pace of the later half of what is done, and is told from the first pass on whose pace is that of the one
  /// before it by a quarter; where rows are learned, both must be passes over the whole picture.
  Outlook after(const integrate::PassProgress& pass, double noise, double elapsed);
  Outlook after(const integrate::PassProgress& pass, double elapsed) { return after(pass, pass.noise, elapsed); }

 private:
  struct Done {
    double paths, seconds;  ///< at the end of a pass, since the first began
  };
  double pace() const;  ///< seconds a path
  void watch(const integrate::PassProgress& pass);

  StopRule rule_;
  std::vector<Done> done_{{0, 0}};
  double last_pace_ = 0;
  bool is_steady_ = false;
};

/// A step before the first pass, told while it lasts: of a terminal the last line has what is done, for how long and
/// how much of it; elsewhere a line says so after 5 s and then every 10. Short steps say nothing. While one lives, the
/// console is its own but for what its thread says.
class Step {
 public:
  explicit Step(std::string what);
  ~Step();
  Step(const Step&) = delete;
  Step& operator=(const Step&) = delete;
  /// How much of it is done, [0, 1]. Any thread.
  void tell(double share) { share_.store(static_cast<float>(share), std::memory_order_relaxed); }

 private:
  void watch(const std::stop_token& stop);

  std::string what_;
  std::atomic<float> share_{0};
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::jthread watcher_;
};

/// One thread at a time. Says nothing under --quiet.
class Progress {
 public:
  Progress();
  /// After each pass.
  void update(const integrate::PassProgress& pass, const Outlook& outlook);
  /// Removes the bar.
  void finish();
  /// Since construction.
  double seconds() const;

 private:
  std::chrono::steady_clock::time_point start_, last_line_;
};

}  // namespace tress::cli
