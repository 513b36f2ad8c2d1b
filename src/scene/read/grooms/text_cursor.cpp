#include "scene/read/grooms/text_cursor.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <limits>
#include <system_error>

namespace tress::scene {

std::span<const unsigned char> without_byte_order_mark(std::span<const unsigned char> bytes) {
  const bool has_mark = bytes.size() >= 3 && bytes[0] == 0xef && bytes[1] == 0xbb && bytes[2] == 0xbf;
  return has_mark ? bytes.subspan(3) : bytes;
}
namespace {

bool is_of_word(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == ':' ||
         c == '.' || c == '!' || c == '-' || c == '+' || static_cast<unsigned char>(c) >= 0x80;  // UTF-8
}

char closing(char open) { return open == '(' ? ')' : open == '[' ? ']' : '}'; }

}  // namespace

void TextCursor::skip_blanks() {
  while (at_ < text_.size()) {
    const char c = text_[at_];
    if (c == '#') {
      const std::size_t end = text_.find('\n', at_);
      at_ = end == std::string_view::npos ? text_.size() : end + 1;
    } else if (c == ' ' || c == '\n' || c == '\t' || c == '\r') {
      ++at_;
    } else {
      return;
    }
  }
}

char TextCursor::peek() {
  skip_blanks();
  return at_ < text_.size() ? text_[at_] : '\0';
}

bool TextCursor::take(char c) {
  if (peek() != c || at_ == text_.size()) return false;
  ++at_;
  return true;
}

bool TextCursor::expect(char c, const char* where) {
  if (take(c)) return true;
  fail_here(fmt::format("\"{}\" {}", c, where));
  return false;
}

std::string_view TextCursor::word() {
  const std::string_view word = peek_word();
  at_ += word.size();
  return word;
}

std::string_view TextCursor::peek_word() {
  skip_blanks();
  std::size_t end = at_;
  while (end < text_.size() && is_of_word(text_[end])) ++end;
  return text_.substr(at_, end - at_);
}

std::string_view TextCursor::quoted() {
  const char quote = peek();
  if (quote != '"' && quote != '\'') {
    fail_here("a text in quotes");
    return {};
  }
  const std::string_view rest = text_.substr(at_);
  const std::size_t marks = rest.size() >= 3 && rest[1] == quote && rest[2] == quote ? 3 : 1;
  std::size_t run = 0;
  for (std::size_t i = marks; i < rest.size(); ++i) {
    if (rest[i] == '\\') {
      ++i;
      run = 0;
      continue;
    }
    run = rest[i] == quote ? run + 1 : 0;
    if (run < marks) continue;
    at_ += i + 1;
    return rest.substr(marks, i + 1 - 2 * marks);
  }
  fail("a text that ends", "the end of the file");
  return {};
}

bool TextCursor::is_number() {
  const char c = peek();
  return (c >= '0' && c <= '9') || c == '-' || c == '+' || c == '.' || c == 'i' || c == 'n';
}

double TextCursor::number() {
  skip_blanks();
  if (at_ < text_.size() && text_[at_] == '+') ++at_;
  double value = 0;
  const char* begin = text_.data() + at_;
  const auto [end, fault] = std::from_chars(begin, text_.data() + text_.size(), value);
  if (end == begin || fault == std::errc::invalid_argument) {
    fail_here("a number");
    return 0;
  }
  if (fault == std::errc::result_out_of_range) {
    const std::string_view digits(begin, static_cast<std::size_t>(end - begin));
    const bool is_small = digits.find("e-") != digits.npos || digits.find("E-") != digits.npos;
    value = is_small ? 0 : std::numeric_limits<double>::infinity();
  }
  at_ += static_cast<std::size_t>(end - begin);
  if (at_ - done_ >= done_block) report_done();
  return value;
}

void TextCursor::report_done() {
  if (done_with_) done_with_(bytes_.subspan(done_, at_ - done_));
  done_ = at_;
}

std::string_view TextCursor::until(char c) {
  const std::size_t begin = at_;
  const bool is_there = skip_past(c);
  return text_.substr(begin, at_ - begin - (is_there ? 1 : 0));
}

void TextCursor::go_to(std::size_t at) { at_ = error_ ? text_.size() : at, done_ = at_; }

bool TextCursor::skip_numbers() {
  int depth = 0;
  std::size_t reported = done_;
  for (std::size_t at = at_; at < text_.size(); ++at) {
    const char c = text_[at];
    if (c == '[') {
      if (++depth > 1) return false;
    } else if (c == '(') {
      if (++depth > 4) return false;
    } else if (c == ')') {
      if (--depth < 1) return false;
    } else if (c == ']') {
      if (depth != 1) return false;
      at_ = at + 1;
      return true;
    } else if (!((c >= '0' && c <= '9') || c == ',' || c == ' ' || c == '.' || c == '-' || c == '\n' || c == 'e' ||
                 c == '+' || c == '\r' || c == '\t' || c == 'E')) {
      return false;
    }
    if (done_with_ && at - reported >= done_block) {
      done_with_(bytes_.subspan(reported, at - reported));
      reported = at;
    }
  }
  return false;
}

bool TextCursor::skip_past(char c) {
  const std::size_t end = text_.find(c, at_);
  at_ = end == std::string_view::npos ? text_.size() : end + 1;
  return end != std::string_view::npos;
}

std::size_t TextCursor::commas_before(char c) const {
  std::size_t commas = 0;
  for (std::size_t at = at_; at < text_.size(); at += done_block) {
    const std::string_view block = text_.substr(at, done_block), part = block.substr(0, block.find(c));
    commas += static_cast<std::size_t>(std::count(part.begin(), part.end(), ','));
    if (part.size() < block.size()) break;
    if (done_with_) done_with_(bytes_.subspan(at, block.size()));
  }
  return commas;
}

void TextCursor::skip_value() {
  std::string open;  // the closing marks that are still expected
  do {
    const char c = peek();
    if (c == 0) return fail_here(open.empty() ? "a value" : fmt::format("\"{}\"", open.back()));
    if (c == '[' && skip_numbers()) {
      continue;
    } else if (c == '(' || c == '[' || c == '{') {
      ++at_;
      if (open.size() >= 64) return fail("at most 64 brackets in one another", "more");
      open += closing(c);
    } else if (c == ')' || c == ']' || c == '}') {
      if (open.empty() || open.back() != c)
        return fail_here(open.empty() ? "a value" : fmt::format("\"{}\"", open.back()));
      ++at_;
      open.pop_back();
    } else if (c == '"' || c == '\'') {
      quoted();
    } else if (c == '@') {
      std::size_t marks = text_.substr(at_).starts_with("@@@") ? 3 : 1;
      for (at_ += marks; marks > 0 && skip_past('@'); --marks) continue;
    } else if (c == '<') {
      skip_past('>');
    } else if (is_of_word(c)) {
      word();
    } else if (!open.empty() && (c == ',' || c == '=' || c == ';')) {
      ++at_;
    } else {
      return fail_here("a value");
    }
  } while (!open.empty() && !error_);
}

std::string TextCursor::here() const {
  if (at_ >= text_.size()) return "the end of the file";
  std::string shown;
  for (const char c : text_.substr(at_, 20)) {
    if (c == '\n' || c == '\r') break;
    shown += c >= ' ' && c <= '~' ? c : '?';
  }
  return "\"" + shown + "\"";
}

void TextCursor::fail_here(std::string expected) {
  skip_blanks();
  fail(std::move(expected), here());
}

void TextCursor::fail(std::string expected, std::string found) {
  if (!error_) {
    const auto line = 1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(at_), '\n');
    error_ = Error{name_, fmt::format("line {}", line), std::move(expected), std::move(found)};
  }
  at_ = text_.size();
}

}  // namespace tress::scene
