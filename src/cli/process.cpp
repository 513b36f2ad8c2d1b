#include "cli/process.h"

#include <fcntl.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <utility>

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
  raise(signal);  // it is delivered when this handler returns
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
    // nohup is the caller's choice and is kept. Shells also ignore SIGINT for what they start in the background, which
    // is no choice of the caller, so SIGINT is handled all the same.
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

Deadline::Deadline(const std::atomic<bool>& asked, double seconds, std::function<bool()> dropped)
    : asked_(asked),
      dropped_(std::move(dropped)),
      watcher_([this, seconds](const std::stop_token& over) { watch(over, seconds); }) {}

void Deadline::watch(const std::stop_token& over, double seconds) {
  constexpr std::chrono::milliseconds step{20};
  double left = seconds;
  bool is_over = false;
  while (!over.stop_requested() && !is_over) {
    is_over = (asked_ && left <= 0) || dropped_();
    if (is_over) break;
    std::this_thread::sleep_for(step);
    if (asked_) left -= std::chrono::duration<double>(step).count();
  }
  if (is_over) passed_ = true;
}

void prepare_standard_streams() {
  for (int number = STDIN_FILENO; number <= STDERR_FILENO; ++number) {
    if (::fcntl(number, F_GETFD) != -1) continue;
    // The lowest free number is this one. It is opened in the wrong direction, so that any use of it fails.
    (void)::open("/dev/null", number == STDIN_FILENO ? O_WRONLY : O_RDONLY);
  }
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

std::optional<Error> flush_results() {
  errno = 0;
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return std::nullopt;
  const char* why = errno != 0 ? std::strerror(errno) : "an earlier write that failed";
  return Error{"standard output", "", "room for the results", why};
}

int run_threaded(std::optional<int> threads, const std::function<int(int)>& work) {
  const int count = threads.value_or(tbb::info::default_concurrency());
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, std::size_t(count));
  tbb::task_arena arena(count);
  return arena.execute([&] { return work(count); });
}

}  // namespace tress::cli
