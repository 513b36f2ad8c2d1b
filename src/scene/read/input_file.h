// Whole files into memory, with the reasons why not.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tress/base/error.h"

namespace tress::scene {

/// The bytes of a regular file of at most `most_bytes`. `what` completes "expected ...". Never waits on pipes or
/// devices.
Result<std::vector<unsigned char>> read_input_file(const std::filesystem::path& file, const std::string& what,
                                                   std::uintmax_t most_bytes);

/// The first bytes of a regular file, at most `bytes` of them.
Result<std::vector<unsigned char>> read_file_start(const std::filesystem::path& file, const std::string& what,
                                                   std::size_t bytes);

}  // namespace tress::scene
