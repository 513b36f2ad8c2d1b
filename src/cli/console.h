// What the user is told on standard error: notes, warnings, errors and the bar. Results go to standard output instead.
#pragma once

#include <string>

namespace tress::cli {

/// Sets up the logger on stderr. quiet: notes and the bar are dropped; warnings, errors and said() stay.
/// Called once, by run(), before anything is said. One thread at a time for everything here.
void open_console(bool quiet);
bool console_is_quiet();
/// Whether stderr is a terminal, so that a line may be redrawn.
bool console_is_terminal();

void note(const std::string& text);
void warn(const std::string& text);
void fail(const std::string& text);
/// A line that --quiet does not drop: what happened to the warm cache.
void said(const std::string& text);

/// Redraws the last line of a terminal; removed by the next line said, or by an empty text. Nothing elsewhere.
void draw_bar(const std::string& text);

}  // namespace tress::cli
