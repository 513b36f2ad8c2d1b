// What the user is told on standard error: notes, warnings, errors and the bar. Results go to standard output instead.
#pragma once

#include <cstddef>
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

/// From now on progress and errors are told on standard output too, in the lines that Open Job Description reads
/// (`openjd_progress`, `openjd_status`, `openjd_fail`; its "How Jobs Are Run").
void use_openjd_lines();
/// Of `count` pictures, `done` are finished: tell_progress() is of the next one.
void begin_picture(std::size_t done, std::size_t count);
/// share: of this picture, 0..1. Nothing unless it is asked for.
void tell_progress(double share, const std::string& text);

/// Redraws the last line of a terminal; removed by the next line said, or by an empty text. Nothing elsewhere.
void draw_bar(const std::string& text);

}  // namespace tress::cli
