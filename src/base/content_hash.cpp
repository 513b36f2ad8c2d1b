#include "base/content_hash.h"

#include <xxhash.h>

#include <fstream>
#include <memory>
#include <system_error>

namespace tress {
namespace {

std::string hexadecimal(std::uint64_t value) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string text(16, '0');
  for (std::size_t i = 0; i < text.size(); ++i) text[text.size() - 1 - i] = digits[value >> (4 * i) & 15];
  return text;
}

}  // namespace

std::uint64_t content_hash(std::string_view bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

std::string content_name(std::string_view bytes) { return hexadecimal(content_hash(bytes)); }

std::optional<std::string> file_content_name(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return std::nullopt;
  std::ifstream in(file, std::ios::binary);
  const std::unique_ptr<XXH3_state_t, XXH_errorcode (*)(XXH3_state_t*)> state(XXH3_createState(), XXH3_freeState);
  if (!in || !state) return std::nullopt;
  XXH3_64bits_reset(state.get());
  std::string piece(std::size_t{1} << 20, '\0');
  while (in.read(piece.data(), static_cast<std::streamsize>(piece.size())) || in.gcount() > 0)
    XXH3_64bits_update(state.get(), piece.data(), static_cast<std::size_t>(in.gcount()));
  if (!in.eof()) return std::nullopt;
  return hexadecimal(XXH3_64bits_digest(state.get()));
}

}  // namespace tress
