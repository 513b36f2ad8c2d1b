// What a text or a file holds, as sixteen digits: equal contents are equal, others differ but for an accident.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace tress {

/// XXH3, 64 bits, seed 0. No protection against those who want two contents to look alike.
std::uint64_t content_hash(std::string_view bytes);
/// As 16 lower-case hexadecimal digits.
std::string content_name(std::string_view bytes);
/// Of a regular file, read in pieces of 1 MB. Unset where it cannot be read.
std::optional<std::string> file_content_name(const std::filesystem::path& file);

}  // namespace tress
