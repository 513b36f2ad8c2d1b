// A place in a text that is read word by word: what USD and pbrt have in common.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "scene/read/grooms/groom_file.h"
#include "tress/base/error.h"

namespace tress::scene {

/// A text in UTF-8 without the mark that some programs begin it with; other bytes as they are.
std::span<const unsigned char> without_byte_order_mark(std::span<const unsigned char> bytes);

/// Reads on from its place, never behind the end. The first failure is kept; afterwards the text is at its end, so that
/// every loop over it ends.
class TextCursor {
 public:
  /// `name` is the file named in errors, which give the line. `text` must outlive the cursor.
  /// done_with, if set, is told of what numbers have passed, some megabytes at a time.
  TextCursor(std::span<const unsigned char> text, std::string name, DoneWith done_with = {})
      : bytes_(text),
        text_(reinterpret_cast<const char*>(text.data()), text.size()),
        name_(std::move(name)),
        done_with_(std::move(done_with)) {}

  /// Behind blanks, line ends and comments (# to the end of the line): the next character, 0 at the end.
  char peek();
  bool at_end() { return peek() == 0; }
  /// Takes the character if it is the next one.
  bool take(char c);
  /// Takes it, or fails.
  bool expect(char c, const char* where);

  /// Letters, digits and _ : . ! - from here; empty where there is none of them.
  std::string_view word();
  /// The next word without taking it.
  std::string_view peek_word();
  /// A text in " or ', or in three of them; without the quotes, escapes as written. Fails where there is none.
  std::string_view quoted();
  /// A finite number, inf or nan. Fails where there is none.
  double number();
  /// Whether a number may begin here.
  bool is_number();

  /// The characters up to this one, which is taken too; all that are left where there is none.
  std::string_view until(char c);
  /// Where the cursor is, behind blanks, and back to such a place.
  std::size_t at() {
    skip_blanks();
    return at_;
  }
  void go_to(std::size_t at);

  /// Passes over a value of any kind: a word, a number, a text, <a path>, @an asset@, or whatever is in brackets.
  void skip_value();
  /// Passes over the characters up to this one and it; false at the end.
  bool skip_past(char c);
  /// Passes over what is in a bracket that opens here; false, and nothing is passed, where no line of it has more than
  /// numbers, commas and blanks between brackets that close each other.
  bool skip_numbers();
  /// How many there are from here to the next of this character, or to the end. Takes nothing.
  std::size_t commas_before(char c) const;

  /// Keeps the failure at the line of the place, unless there is one.
  void fail(std::string expected, std::string found);
  /// The same where what was expected is not here: says what is.
  void fail_here(std::string expected);
  const std::string& name() const { return name_; }
  const std::optional<Error>& error() const { return error_; }

 private:
  void skip_blanks();
  std::string here() const;
  void tell_what_is_done();

  std::span<const unsigned char> bytes_;
  std::string_view text_;
  std::size_t at_ = 0, done_ = 0;
  std::string name_;
  DoneWith done_with_;
  std::optional<Error> error_;
};

}  // namespace tress::scene
