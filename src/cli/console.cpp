#include "cli/console.h"

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <memory>

namespace tress::cli {
namespace {

bool quiet_ = false;
bool bar_shown_ = false;
bool openjd_ = false;
std::size_t pictures_done_ = 0, pictures_ = 1;

spdlog::logger& logger() {
  static const std::shared_ptr<spdlog::logger> instance = [] {
    auto made = std::make_shared<spdlog::logger>("tress", std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
    made->set_pattern("%^tress:%$ %v");
    made->flush_on(spdlog::level::info);
    return made;
  }();
  return *instance;
}

void clear_bar() {
  if (!bar_shown_) return;
  std::fputs("\r\033[K", stderr);
  std::fflush(stderr);
  bar_shown_ = false;
}

/// Prints the text as one line, whatever it contains.
void print_openjd(const char* name, std::string text) {
  for (char& c : text) c = c == '\n' || c == '\r' ? ' ' : c;
  std::fprintf(stdout, "openjd_%s: %s\n", name, text.c_str());
  std::fflush(stdout);
}

}  // namespace

void quiet_console() { quiet_ = true; }

bool console_is_terminal() { return isatty(STDERR_FILENO) == 1; }

void log_note(const std::string& text) {
  if (quiet_) return;
  clear_bar();
  logger().info("{}", text);
}

void log_warning(const std::string& text) {
  clear_bar();
  logger().warn("warning: {}", text);
}

void log_error(const std::string& text) {
  clear_bar();
  logger().error("error: {}", text);
  if (openjd_) print_openjd("fail", text);
}

void use_openjd_lines() { openjd_ = true; }

void begin_picture(std::size_t done, std::size_t count) {
  pictures_done_ = done;
  pictures_ = std::max<std::size_t>(count, 1);
}

void report_progress(double share, const std::string& text) {
  if (!openjd_) return;
  const double all = (double(pictures_done_) + std::clamp(share, 0.0, 1.0)) / double(pictures_);
  print_openjd("progress", fmt::format("{:.1f}", 100 * std::min(all, 1.0)));
  print_openjd("status", text);
}

void draw_bar(const std::string& text) {
  if (quiet_ || !console_is_terminal()) return;
  clear_bar();
  if (text.empty()) return;
  std::fputs(text.c_str(), stderr);
  std::fflush(stderr);
  bar_shown_ = true;
}

}  // namespace tress::cli
