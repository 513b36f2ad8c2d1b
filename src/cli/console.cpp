#include "cli/console.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cstdio>
#include <memory>

namespace tress::cli {
namespace {

bool quiet_ = false;
bool bar_shown_ = false;

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
