// What the user is told on standard error: notes, warnings, errors and the bar. Results go to standard output instead.
#pragma once

#include <string>

namespace tress::cli {

/// From now on notes and the bar are dropped; errors stay, and warnings: what changes the result. One thread at a time
/// for everything here.
void quiet_console();
/// Whether stderr is a terminal, so that a line may be redrawn.
bool console_is_terminal();

void log_note(const std::string& text);
void log_warning(const std::string& text);
void log_error(const std::string& text);

/// Redraws the last line of a terminal; removed by the next line said, or by an empty text. Nothing elsewhere.
void draw_bar(const std::string& text);

}  // namespace tress::cli
