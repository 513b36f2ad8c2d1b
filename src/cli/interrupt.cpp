#include "cli/interrupt.h"

#include <csignal>

namespace tress::cli {
namespace {

std::atomic<bool> stop_requested{false};
std::atomic<int> first_signal{0};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free,
              "only lock-free atomics may be touched by a signal handler");

struct sigaction former_interrupt, former_terminate;

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
  sigaction(SIGINT, &ours, &former_interrupt);
  sigaction(SIGTERM, &ours, &former_terminate);
}

InterruptGuard::~InterruptGuard() {
  sigaction(SIGINT, &former_interrupt, nullptr);
  sigaction(SIGTERM, &former_terminate, nullptr);
}

const std::atomic<bool>& InterruptGuard::requested() const { return stop_requested; }

int InterruptGuard::exit_status() const {
  const int signal = first_signal;
  return signal == 0 ? 0 : 128 + signal;
}

}  // namespace tress::cli
