// A place in a text that is read word by word: what USD and pbrt have in common.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "tress/base/error.h"

namespace tress::scene {

/// Reads on from its place, never behind the end. The first failure is kept; afterwards the text is at its end, so that
/// every loop over it ends.
class TextCursor {
 public:
  /// `name` is the file named in errors, which give the line. `text` must outlive the cursor.
  TextCursor(std::span<const unsigned char> text, std::string name)
      : text_(reinterpret_cast<const char*>(text.data()), text.size()), name_(std::move(name)) {}

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

  /// Passes over a value of any kind: a word, a number, a text, <a path>, @an asset@, or whatever is in brackets.
  void skip_value();
  /// Passes over the characters up to this one and it; false at the end.
  bool skip_past(char c);

  /// Keeps the failure at the line of the place, unless there is one.
  void fail(std::string expected, std::string found);
  /// The same where what was expected is not here: says what is.
  void fail_here(std::string expected);
  const std::string& name() const { return name_; }
  const std::optional<Error>& error() const { return error_; }

 private:
  void skip_blanks();
  std::string here() const;

  std::string_view text_;
  std::size_t at_ = 0;
  std::string name_;
  std::optional<Error> error_;
};

}  // namespace tress::scene
