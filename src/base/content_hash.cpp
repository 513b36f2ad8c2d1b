#include "base/content_hash.h"

#include <xxhash.h>

#include <fstream>
#include <system_error>

namespace tress::inline v0_2 {

struct ContentHash::State {
  XXH3_state_t hash;
};

ContentHash::ContentHash() : state_(std::make_unique<State>()) { XXH3_64bits_reset(&state_->hash); }
ContentHash::~ContentHash() = default;
void ContentHash::add(std::string_view bytes) { XXH3_64bits_update(&state_->hash, bytes.data(), bytes.size()); }
std::uint64_t ContentHash::value() const { return XXH3_64bits_digest(&state_->hash); }

std::string hexadecimal(std::uint64_t value) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string text(16, '0');
  for (std::size_t i = 0; i < text.size(); ++i) text[text.size() - 1 - i] = digits[value >> (4 * i) & 15];
  return text;
}

std::uint64_t content_hash(std::string_view bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

std::string content_name(std::string_view bytes) { return hexadecimal(content_hash(bytes)); }

std::optional<std::string> file_content_name(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return std::nullopt;
  std::ifstream in(file, std::ios::binary);
  if (!in) return std::nullopt;
  ContentHash hash;
  std::string piece(std::size_t{1} << 20, '\0');
  while (in.read(piece.data(), static_cast<std::streamsize>(piece.size())) || in.gcount() > 0)
    hash.add(std::string_view(piece).substr(0, static_cast<std::size_t>(in.gcount())));
  if (!in.eof()) return std::nullopt;
  return hexadecimal(hash.value());
}

}  // namespace tress::inline v0_2
