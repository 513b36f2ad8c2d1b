#include "cli/progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "cli/console.h"
#include "integrate/pass_order.h"

namespace tress::cli {
namespace {

double ratio(double part, double whole) { return whole > 0 ? std::clamp(part / whole, 0.0, 1.0) : 1.0; }

constexpr int bar_cells = 30;
constexpr double seconds_between_lines = 10;

std::string duration(double seconds) {
  const long long whole = static_cast<long long>(std::max(0.0, seconds) + 0.5);
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

}  // namespace

double Forecast::pace() const {
  const Done& now = done_.back();
  const auto half = std::ranges::find_if(done_, [&](const Done& then) { return 2 * then.paths >= now.paths; });
  const Done& then = half == done_.end() || &*half == &now ? done_[done_.size() - 2] : *half;
  return (now.seconds - then.seconds) / std::max(1.0, now.paths - then.paths);
}

void Forecast::watch(const integrate::PassProgress& pass) {
  done_.push_back({static_cast<double>(pass.paths_so_far), done_.back().seconds + pass.seconds});
  const double pace = pass.seconds / std::max(1.0, static_cast<double>(pass.pixels));
  const bool compares = pass.table.queries == 0 ? pass.pass >= 1 : pass.pass > integrate::initial_passes;
  if (compares && pace >= 0.75 * last_pace_ && pace <= last_pace_ / 0.75) is_steady_ = true;
  last_pace_ = pace;
}

Outlook Forecast::after(const integrate::PassProgress& pass, double noise, double elapsed) {
  watch(pass);
  Outlook result;
  result.reason = rule_.reason_to_end(pass, noise, elapsed);
  if (rule_.seconds) {
    result.share = ratio(elapsed, *rule_.seconds);
    result.seconds_left = std::max(0.0, *rule_.seconds - elapsed);
  } else {
    const auto paths = static_cast<double>(pass.paths_so_far);
    result.share = ratio(paths, static_cast<double>(pass.paths_total));
    const bool noise_is_known = StopRule::is_noise_known(pass);
    if (rule_.noise && noise_is_known) {
      const double wanted = noise / *rule_.noise;
      result.share = std::max(result.share, ratio(1, wanted * wanted));
    }
    if (is_steady_ && result.share > 0 && (!rule_.noise || noise_is_known)) {
      result.seconds_left = pace() * paths * (1 - result.share) / result.share;
    }
  }
  return result;
}

Step::Step(std::string what) : what_(std::move(what)), watcher_([this](const std::stop_token& stop) { watch(stop); }) {}

Step::~Step() {
  watcher_.request_stop();
  watcher_.join();
}

void Step::watch(const std::stop_token& stop) {
  const bool redraws = console_is_terminal();
  const auto start = std::chrono::steady_clock::now();
  std::unique_lock lock(mutex_);
  for (double next = redraws ? 0.5 : 5;; next += redraws ? 0.5 : seconds_between_lines) {
    const auto then =
        start + std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(next));
    wake_.wait_until(lock, stop, then, [] { return false; });
    if (stop.stop_requested()) break;
    const float share = share_.load(std::memory_order_relaxed);
    const std::string done = share > 0 ? fmt::format(", {:.0f} % done", 100 * std::min(share, 1.0f)) : std::string();
    const std::string text = fmt::format("{}: {} so far{}", what_, duration(next), done);
    if (redraws)
      draw_bar(text);
    else
      log_note(text);
  }
  if (redraws) draw_bar("");
}

Progress::Progress() : start_(std::chrono::steady_clock::now()), last_line_(start_) {}

double Progress::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

void Progress::update(const integrate::PassProgress& pass, const Outlook& outlook) {
  const double share = outlook.share;
  std::string table;
  if (pass.table.queries > 0) {
    const auto percent = [&](std::uint64_t part) { return 100.0 * double(part) / double(pass.table.queries); };
    table = fmt::format(", {:.1f} % of queries answered by rows, {:.1f} % by converged ones",
                        percent(pass.table.answered_queries), percent(pass.table.converged_queries));
  }
  const std::string left =
      outlook.seconds_left ? duration(*outlook.seconds_left) + " left" : std::string("time left not known yet");
  // The variance of a pixel can be estimated from its second sample on.
  const std::string noise = pass.noise > 0 ? fmt::format("noise {:.2g}", pass.noise) : "noise not known yet";
  const std::string text = fmt::format("{:3.0f} %, pass {}, {}, {}{}", 100 * share, pass.pass + 1, left, noise, table);
  report_progress(share, text);
  if (console_is_terminal()) {
    const int full = std::clamp(static_cast<int>(share * bar_cells), 0, bar_cells);
    draw_bar(fmt::format("[{}{}] {}", std::string(std::size_t(full), '#'),
                         std::string(std::size_t(bar_cells - full), '.'), text));
    return;
  }
  const auto now = std::chrono::steady_clock::now();
  if (std::chrono::duration<double>(now - last_line_).count() < seconds_between_lines) return;
  last_line_ = now;
  log_note(text);
}

void Progress::finish() { draw_bar(""); }

}  // namespace tress::cli
