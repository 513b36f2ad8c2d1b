// Numbers in fewer bytes, without loss and fast: for sums that are written often and read hardly ever.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace tress {

/// At most so many bytes come of so many.
constexpr std::size_t most_packed_bytes(std::size_t bytes) { return bytes + (bytes / 8 + 64) / 64 * 40 + 16; }

/// The 64-bit words of `bytes` without their zero bytes at one end: words that are zero take a bit, doubles that are
/// sums of floats 5 or 6 bytes, small integers 1 or 2 (src/cli/CHECKPOINT.md has it byte by byte). Replaces `packed`,
/// whose memory is kept. One to two seconds a gigabyte.
void pack_words(std::string_view bytes, std::string* packed);

/// What pack_words() had, of so many bytes. False if `packed` is nothing that it writes for so many; `bytes` is then
/// of no use. Takes no more than 64 times the memory of `packed`.
bool unpack_words(std::string_view packed, std::size_t size, std::string* bytes);

}  // namespace tress
