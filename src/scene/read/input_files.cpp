#include "scene/read/input_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <system_error>

namespace tress::scene {

Result<std::uintmax_t> input_file_size(const std::filesystem::path& file, const std::string& what,
                                       std::uintmax_t most_bytes) {
  const auto error = [&](std::string found) { return Error{file.string(), "", what, std::move(found)}; };
  std::error_code code;
  const auto status = std::filesystem::status(file, code);
  if (!std::filesystem::exists(status)) return error("no such file");
  if (std::filesystem::is_directory(status)) return error("a directory");
  if (!std::filesystem::is_regular_file(status)) return error("something that is not a regular file");
  const auto size = std::filesystem::file_size(file, code);
  if (code) return error(code.message());
  if (size == 0) return error("an empty file");
  if (size > most_bytes) return error(fmt::format("{} bytes, more than {}", size, most_bytes));
  return size;
}

namespace {

/// The first min(size, wanted) bytes; an error where the file is larger than `most_bytes`.
Result<std::vector<unsigned char>> read(const std::filesystem::path& file, const std::string& what,
                                        std::uintmax_t wanted, std::uintmax_t most_bytes) {
  const auto error = [&](std::string found) { return Error{file.string(), "", what, std::move(found)}; };
  const auto size = input_file_size(file, what, most_bytes);
  if (!size) return size.error();
  std::vector<unsigned char> bytes(std::min(*size, wanted));
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return error("a file that cannot be opened");
  stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (static_cast<std::size_t>(stream.gcount()) != bytes.size()) return error("a file that cannot be read to its end");
  return bytes;
}

}  // namespace

Result<std::vector<unsigned char>> read_input_file(const std::filesystem::path& file, const std::string& what,
                                                   std::uintmax_t most_bytes) {
  return read(file, what, UINTMAX_MAX, most_bytes);
}

Result<std::vector<unsigned char>> read_file_start(const std::filesystem::path& file, const std::string& what,
                                                   std::size_t bytes) {
  return read(file, what, bytes, UINTMAX_MAX);
}

}  // namespace tress::scene
