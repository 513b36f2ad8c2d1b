// Reads the files of a scene: their bytes, and their kind by the first bytes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "tress/base/error.h"

namespace tress::scene {

/// The size of a regular file of 1 to `most_bytes` bytes. `what` completes "expected ...".
Result<std::uintmax_t> input_file_size(const std::filesystem::path& file, const std::string& what,
                                       std::uintmax_t most_bytes);

/// The bytes of a regular file of at most `most_bytes`. `what` completes "expected ...". Never waits on pipes or
/// devices.
Result<std::vector<unsigned char>> read_input_file(const std::filesystem::path& file, const std::string& what,
                                                   std::uintmax_t most_bytes);

/// Unpacks gzip, at most `most_bytes` of it; bytes of another kind are returned unchanged. Fails if they are damaged;
/// `name` is the file for the message.
Result<std::vector<unsigned char>> unpacked(std::vector<unsigned char> bytes, const std::string& name,
                                            std::uintmax_t most_bytes);

/// Whether bytes begin like a gzip file.
bool is_packed(std::span<const unsigned char> bytes);

/// The first bytes of a regular file, at most `bytes` of them.
Result<std::vector<unsigned char>> read_file_start(const std::filesystem::path& file, const std::string& what,
                                                   std::size_t bytes);

/// The number of bytes that kind_of() reads.
constexpr std::size_t bytes_of_kind = 64;

/// The format that the first bytes of a file identify: "an Alembic archive (Ogawa)", "a PNG picture"; empty if it is
/// unknown.
std::string known_kind_of(std::span<const unsigned char> start);

/// The same; without a known mark, a description of the bytes: "a text that begins \"solid\"", "binary data that begins
/// 00 01 02 03". Printable, for messages.
std::string kind_of(std::span<const unsigned char> start);

}  // namespace tress::scene
