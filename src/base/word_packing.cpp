#include "base/word_packing.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>

namespace tress::inline v0_2 {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::size_t word_bytes = 8, block_words = 64;
constexpr unsigned from_the_top = 8;  ///< added to a code whose zero bytes were at the top, not at the bottom

std::uint64_t word_at(const char* from) {
  std::uint64_t word = 0;
  std::memcpy(&word, from, word_bytes);
  return word;
}

/// The number of bytes that a word of this code keeps.
constexpr unsigned kept_bytes(unsigned code) { return word_bytes - code % from_the_top; }

/// A mask with a bit for each of up to 64 words, set if the word is not zero.
std::uint64_t words_set(const char* from, std::size_t count) {
  std::uint64_t set = 0;
  for (std::size_t i = 0; i < count; ++i) set |= std::uint64_t{word_at(from + word_bytes * i) != 0} << i;
  return set;
}

std::size_t code_bytes(std::uint64_t set) { return (static_cast<std::size_t>(std::popcount(set)) + 1) / 2; }

/// Writes one block and returns its end. There must be room for one word more.
char* pack_block(const char* from, std::size_t count, char* to) {
  const std::uint64_t set = words_set(from, count);
  std::memcpy(to, &set, word_bytes);
  char* codes = to + word_bytes;
  char* out = codes + code_bytes(set);
  unsigned number = 0;
  for (std::uint64_t left = set; left != 0; left &= left - 1, ++number) {
    const std::uint64_t word = word_at(from + word_bytes * static_cast<std::size_t>(std::countr_zero(left)));
    const auto bottom = static_cast<unsigned>(std::countr_zero(word)) / 8,
               top = static_cast<unsigned>(std::countl_zero(word)) / 8;
    const unsigned code = top > bottom ? from_the_top + top : bottom;
    const std::uint64_t kept = top > bottom ? word : word >> (8 * bottom);
    const unsigned before = number % 2 == 0 ? 0 : static_cast<unsigned char>(codes[number / 2]);
    codes[number / 2] = static_cast<char>(before | code << (4 * (number % 2)));
    std::memcpy(out, &kept, word_bytes);
    out += kept_bytes(code);
  }
  return out;
}

/// Reads one block of `count` words and moves `from` past it. False if the block is cut or invalid.
bool unpack_block(std::string_view* from, std::size_t count, char* to) {
  if (from->size() < word_bytes) return false;
  const std::uint64_t set = word_at(from->data());
  if (count < block_words && set >> count != 0) return false;
  const std::size_t codes_end = word_bytes + code_bytes(set);
  if (from->size() < codes_end) return false;
  const std::string_view codes = from->substr(word_bytes, codes_end - word_bytes);
  from->remove_prefix(codes_end);
  unsigned number = 0;
  for (std::uint64_t left = set; left != 0; left &= left - 1, ++number) {
    const unsigned code = static_cast<unsigned char>(codes[number / 2]) >> (4 * (number % 2)) & 15u;
    const std::size_t kept = kept_bytes(code);
    if (code == from_the_top || from->size() < kept) return false;
    std::uint64_t word = 0;
    std::memcpy(&word, from->data(), kept);
    if (code < from_the_top) word <<= 8 * code;
    std::memcpy(to + word_bytes * static_cast<std::size_t>(std::countr_zero(left)), &word, word_bytes);
    from->remove_prefix(kept);
  }
  return true;
}

}  // namespace

void pack_words(std::string_view bytes, std::string* packed) {
  packed->resize(most_packed_bytes(bytes.size()));
  const std::size_t words = bytes.size() / word_bytes;
  char* out = packed->data();
  for (std::size_t word = 0; word < words; word += block_words)
    out = pack_block(bytes.data() + word_bytes * word, std::min(block_words, words - word), out);
  const std::string_view rest = bytes.substr(word_bytes * words);
  out = std::copy(rest.begin(), rest.end(), out);
  packed->resize(static_cast<std::size_t>(out - packed->data()));
}

bool unpack_words(std::string_view packed, std::size_t size, std::string* bytes) {
  const std::size_t words = size / word_bytes;
  if ((words + block_words - 1) / block_words > packed.size() / word_bytes) return false;
  bytes->assign(size, '\0');
  for (std::size_t word = 0; word < words; word += block_words) {
    if (!unpack_block(&packed, std::min(block_words, words - word), bytes->data() + word_bytes * word)) return false;
  }
  if (packed.size() != size % word_bytes) return false;
  std::copy(packed.begin(), packed.end(), bytes->data() + word_bytes * words);
  return true;
}

}  // namespace tress::inline v0_2
