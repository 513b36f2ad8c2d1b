// Hashes of the contents of texts and files, as sixteen digits: equal contents have equal hashes; different contents
// almost never do.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace tress::inline v0_2 {

/// XXH3 (64 bits, seed 0). It does not protect against contents that were made to collide.
std::uint64_t content_hash(std::string_view bytes);
/// 16 lower-case hexadecimal digits.
std::string hexadecimal(std::uint64_t value);
/// The hash in hexadecimal digits.
std::string content_name(std::string_view bytes);

/// The hash of bytes that come piece by piece.
class ContentHash {
 public:
  ContentHash();
  ~ContentHash();
  ContentHash(const ContentHash&) = delete;
  ContentHash& operator=(const ContentHash&) = delete;

  void add(std::string_view bytes);
  /// content_hash() of all bytes so far.
  std::uint64_t value() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The hash of a regular file, which is read in pieces of 1 MB. Empty if the file cannot be read.
std::optional<std::string> file_content_name(const std::filesystem::path& file);

}  // namespace tress::inline v0_2
