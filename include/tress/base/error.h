// An error in the four parts of every message of tress, and a value-or-error.
#pragma once

#include <string>
#include <utility>
#include <variant>

namespace tress::inline v0_2 {

/// A failure that the user can correct. Libraries return it and never throw it.
struct Error {
  std::string file;      ///< path of the file; empty if no file is involved
  std::string place;     ///< the place in it: "byte 128", "/fibers/0/e", "section rows"; may be empty
  std::string expected;  ///< what should have been there
  std::string found;     ///< what was there

  /// "file: place: expected X, found Y", without the parts that are empty.
  std::string message() const {
    std::string text = file;
    if (!place.empty()) text += (text.empty() ? "" : ": ") + place;
    if (!text.empty()) text += ": ";
    if (!expected.empty()) text += "expected " + expected;
    if (!found.empty()) text += (expected.empty() ? "" : ", ") + std::string("found ") + found;
    return text;
  }
};

/// A T, or the Error that prevented it. Reading the wrong one is a programming mistake and throws.
template <class T>
class Result {
 public:
  Result(T value) : content_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : content_(std::in_place_index<1>, std::move(error)) {}

  bool has_value() const { return content_.index() == 0; }
  explicit operator bool() const { return has_value(); }
  T& value() { return std::get<0>(content_); }
  const T& value() const { return std::get<0>(content_); }
  T& operator*() & { return value(); }
  T&& operator*() && { return std::move(value()); }
  const T& operator*() const& { return value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  const Error& error() const { return std::get<1>(content_); }

 private:
  std::variant<T, Error> content_;
};

}  // namespace tress::inline v0_2
