// Packs numbers into fewer bytes, fast and without loss, for sums that are written often and hardly ever read.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace tress::inline v0_2 {

/// The largest packed size of this many bytes.
constexpr std::size_t most_packed_bytes(std::size_t bytes) { return bytes + (bytes / 8 + 64) / 64 * 40 + 16; }

/// Packs the 64-bit words of `bytes` without their zero bytes at one end. A word that is zero takes a bit, a double
/// that is a sum of floats 5 or 6 bytes, a small integer 1 or 2 (src/cli/CHECKPOINT.md defines every byte). Replaces
/// `packed`, whose memory is kept. Takes one to two seconds per gigabyte.
void pack_words(std::string_view bytes, std::string* packed);

/// Unpacks the output of pack_words() for this many bytes. False if `packed` is no such output for this size; `bytes`
/// must then not be used. Takes no more than 64 times the memory of `packed`.
bool unpack_words(std::string_view packed, std::size_t size, std::string* bytes);

}  // namespace tress::inline v0_2
