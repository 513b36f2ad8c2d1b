// A place in a crate, the binary form of USD: numbers, and data packed by LZ4 and by the crate's coding of integers.
#pragma once

#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tress/base/error.h"

namespace tress::scene {

/// Reads on from its place, never beyond the end. It keeps the first failure; afterwards all numbers are 0 and all
/// lists empty.
class CrateCursor {
 public:
  /// `name` is the file named in errors, which give the byte. The bytes must outlive it.
  CrateCursor(std::span<const unsigned char> bytes, std::string name) : bytes_(bytes), name_(std::move(name)) {}

  /// part: what is read there, for errors.
  void go_to(std::uint64_t at, std::string_view part);
  std::uint64_t at() const { return at_; }
  std::uint64_t size() const { return bytes_.size(); }

  template <class T>
  T number() {
    T value{};
    if (const auto bytes = take(sizeof value); !bytes.empty()) std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  }
  std::span<const unsigned char> take(std::uint64_t size);
  /// A number of things that follow, each of this many bytes or more.
  std::uint64_t count(std::uint64_t bytes_each);
  /// The same for `found` packed integers. These can take far less than a byte each, but each describes an entry that
  /// has at least this many bytes elsewhere in the file.
  std::uint64_t packed_count(std::uint64_t found, std::uint64_t bytes_each);
  /// Fails if `found` is more than `most`.
  bool hold(std::uint64_t found, std::uint64_t most, std::string_view what);

  /// A number of bytes, and those bytes unpacked to exactly this size.
  std::vector<unsigned char> unpacked(std::uint64_t size);
  /// Integers by the crate's coding. Int: of 4 or 8 bytes.
  template <class Int>
  std::vector<Int> integers(std::uint64_t count);

  void fail(std::string expected, std::string found);
  /// The same with a prim as its place.
  void fail_at(std::string place, std::string expected, std::string found);
  const std::optional<Error>& error() const { return error_; }

 private:
  std::vector<unsigned char> unpack(std::span<const unsigned char> packed, std::uint64_t most);

  std::span<const unsigned char> bytes_;
  std::string name_;
  std::string_view part_ = "the header";
  std::uint64_t at_ = 0;
  std::optional<Error> error_;
};

}  // namespace tress::scene
