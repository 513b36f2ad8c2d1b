// A place in a text that is read word by word, for USD and pbrt.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "scene/read/grooms/groom_file.h"
#include "tress/base/error.h"

namespace tress::scene {

/// A text in UTF-8 without a byte order mark; other bytes are unchanged.
std::span<const unsigned char> without_byte_order_mark(std::span<const unsigned char> bytes);

/// Reads on from its place, never beyond the end. It keeps the first failure; afterwards the text is at its end, so
/// that every loop over it ends.
class TextCursor {
 public:
  /// `name` is the file named in errors, which give the line. `text` must outlive the cursor. done_with, if set, is
  /// called with text whose numbers have been read, some megabytes at a time.
  TextCursor(std::span<const unsigned char> text, std::string name, DoneWith done_with = {})
      : bytes_(text),
        text_(reinterpret_cast<const char*>(text.data()), text.size()),
        name_(std::move(name)),
        done_with_(std::move(done_with)) {}

  /// Skips blanks, line ends and comments (# to the end of the line) and returns the next character; 0 at the end.
  char peek();
  bool at_end() { return peek() == 0; }
  /// Takes the character if it is the next one.
  bool take(char c);
  /// Takes the character, or fails.
  bool expect(char c, const char* where);

  /// Takes letters, digits and _ : . ! - from here; empty if there are none.
  std::string_view word();
  /// The next word without taking it.
  std::string_view peek_word();
  /// Takes a text in " or ', or in three of them; returns it without the quotes, with escapes as written. Fails without
  /// one.
  std::string_view quoted();
  /// Takes a finite number, inf or nan. Fails at anything else.
  double number();
  /// Whether a number may begin here.
  bool is_number();

  /// Takes the characters up to and including this one, or to the end if it does not occur.
  std::string_view until(char c);
  /// The cursor's place after blanks, and a way back to it.
  std::size_t at() {
    skip_blanks();
    return at_;
  }
  void go_to(std::size_t at);

  /// Skips a value of any kind: a word, a number, a text, <a path>, @an asset@, or anything in brackets.
  void skip_value();
  /// Skips the characters up to and including this one; false at the end.
  bool skip_past(char c);
  /// Skips a bracket that opens here, if every line in it has only numbers, commas and blanks between matching
  /// brackets. Otherwise it returns false and skips nothing.
  bool skip_numbers();
  /// The number of commas from here to the next of this character, or to the end. Takes nothing.
  std::size_t commas_before(char c) const;

  /// Records the failure with the line of the place, unless there is one already.
  void fail(std::string expected, std::string found);
  /// The same at this place, with the text here as `found`.
  void fail_here(std::string expected);
  const std::string& name() const { return name_; }
  const std::optional<Error>& error() const { return error_; }

 private:
  void skip_blanks();
  std::string here() const;
  void report_done();

  std::span<const unsigned char> bytes_;
  std::string_view text_;
  std::size_t at_ = 0, done_ = 0;
  std::string name_;
  DoneWith done_with_;
  std::optional<Error> error_;
};

}  // namespace tress::scene
