#include "cli/interrupt.h"

#include <array>
#include <csignal>
#include <cstddef>

namespace tress::cli {
namespace {

std::atomic<bool> stop_requested{false};
std::atomic<int> first_signal{0};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free,
              "only lock-free atomics may be touched by a signal handler");

constexpr std::array<int, 3> signals{SIGINT, SIGTERM, SIGHUP};
std::array<struct sigaction, signals.size()> former;

void handle_signal(int signal) {
  int none = 0;
  if (first_signal.compare_exchange_strong(none, signal)) {
    stop_requested = true;
    return;
  }
  struct sigaction standard = {};
  standard.sa_handler = SIG_DFL;
  sigaction(signal, &standard, nullptr);
  raise(signal);  // delivered when this handler returns
}

}  // namespace

InterruptGuard::InterruptGuard() {
  stop_requested = false;
  first_signal = 0;
  struct sigaction ours = {};
  ours.sa_handler = handle_signal;
  ours.sa_flags = SA_RESTART;
  sigemptyset(&ours.sa_mask);
  for (std::size_t i = 0; i < signals.size(); ++i) {
    sigaction(signals[i], nullptr, &former[i]);
    // nohup is a wish of the caller's; shells ignore SIGINT for what they start in the background, which is none.
    const bool unwanted = signals[i] == SIGHUP && former[i].sa_handler == SIG_IGN;
    if (!unwanted) sigaction(signals[i], &ours, nullptr);
  }
}

InterruptGuard::~InterruptGuard() {
  for (std::size_t i = 0; i < signals.size(); ++i) sigaction(signals[i], &former[i], nullptr);
}

const std::atomic<bool>& InterruptGuard::requested() const { return stop_requested; }

int InterruptGuard::exit_status() const {
  const int signal = first_signal;
  return signal == 0 ? 0 : 128 + signal;
}

}  // namespace tress::cli
