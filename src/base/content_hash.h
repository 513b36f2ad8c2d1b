// Hashes of the contents of texts and files, as sixteen digits: equal contents have equal hashes; different contents
// almost never do.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace tress {

/// XXH3 (64 bits, seed 0). It does not protect against contents that were made to collide.
std::uint64_t content_hash(std::string_view bytes);
/// The hash as 16 lower-case hexadecimal digits.
std::string content_name(std::string_view bytes);
/// The hash of a regular file, which is read in pieces of 1 MB. Empty if the file cannot be read.
std::optional<std::string> file_content_name(const std::filesystem::path& file);

}  // namespace tress
