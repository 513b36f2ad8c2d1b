// How far a render is: a bar with the time left on a terminal, a line now and then elsewhere.
#pragma once

#include <chrono>

#include "cli/stop_rule.h"
#include "integrate/renderer.h"

namespace tress::cli {

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
