// Messages to the user on standard error: notes, warnings, errors and the progress bar. Results go to standard output
// instead.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace tress::cli {

/// What makes the noun behind a number plural: "s", or nothing behind 1.
constexpr const char* plural(std::uint64_t number) { return number == 1 ? "" : "s"; }

/// Drops notes and the bar from now on. Errors stay, and so do warnings, which concern the result. One thread at a time
/// for everything here.
void quiet_console();
/// Whether stderr is a terminal, where a line can be redrawn.
bool console_is_terminal();

void log_note(const std::string& text);
void log_warning(const std::string& text);
void log_error(const std::string& text);

/// Also reports progress and errors on standard output from now on, in the lines that Open Job Description reads
/// (`openjd_progress`, `openjd_status`, `openjd_fail`; its "How Jobs Are Run").
void use_openjd_lines();
/// Sets that `done` of `count` pictures are finished; report_progress() then concerns the next one.
void begin_picture(std::size_t done, std::size_t count);
/// Reports progress if it was requested. share: of this picture, 0..1.
void report_progress(double share, const std::string& text);

/// Redraws the last line of a terminal; the next message, or an empty text, removes it. Does nothing elsewhere.
void draw_bar(const std::string& text);

}  // namespace tress::cli
