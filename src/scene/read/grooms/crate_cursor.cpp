#include "scene/read/grooms/crate_cursor.h"

#include <fmt/format.h>
#include <lz4.h>

#include <algorithm>
#include <type_traits>
#include <utility>

namespace tress::scene {
namespace {

/// The largest expansion by LZ4: a match of any length takes a byte for each 255 bytes.
constexpr std::uint64_t most_of_lz4 = 255;

}  // namespace

void CrateCursor::go_to(std::uint64_t at, std::string_view part) {
  if (error_) return;
  part_ = part;
  at_ = std::min<std::uint64_t>(at, bytes_.size());
  if (at > bytes_.size())
    fail(fmt::format("a place in the file, of {} bytes", bytes_.size()), fmt::format("byte {}", at));
}

std::span<const unsigned char> CrateCursor::take(std::uint64_t size) {
  if (error_) return {};
  if (size > bytes_.size() - at_) {
    fail(fmt::format("{} bytes", size), fmt::format("the end of the file after {}", bytes_.size() - at_));
    return {};
  }
  const auto taken = bytes_.subspan(static_cast<std::size_t>(at_), static_cast<std::size_t>(size));
  at_ += size;
  return taken;
}

bool CrateCursor::hold(std::uint64_t found, std::uint64_t most, std::string_view what) {
  if (!error_ && found > most) fail(fmt::format("at most {} {}", most, what), fmt::format("{}", found));
  return !error_;
}

std::uint64_t CrateCursor::count(std::uint64_t bytes_each) {
  const auto found = number<std::uint64_t>();
  return hold(found, (bytes_.size() - at_) / bytes_each, "of them, as the bytes allow") ? found : 0;
}

std::uint64_t CrateCursor::packed_count(std::uint64_t found, std::uint64_t bytes_each) {
  return hold(found, bytes_.size() / bytes_each, "of them, as the bytes allow") ? found : 0;
}

std::vector<unsigned char> CrateCursor::unpack(std::span<const unsigned char> packed, std::uint64_t most) {
  std::vector<unsigned char> out(static_cast<std::size_t>(std::min(most, most_of_lz4 * packed.size())));
  std::size_t made = 0;
  const auto add = [&](std::span<const unsigned char> block) {
    const auto room = std::min<std::size_t>(out.size() - made, LZ4_MAX_INPUT_SIZE);
    const int size = block.size() > LZ4_MAX_INPUT_SIZE
                         ? -1
                         : LZ4_decompress_safe(reinterpret_cast<const char*>(block.data()),
                                               reinterpret_cast<char*>(out.data() + made),
                                               static_cast<int>(block.size()), static_cast<int>(room));
    if (size < 0) return fail(fmt::format("data of LZ4 that make at most {} bytes", room), "others");
    made += static_cast<std::size_t>(size);
  };
  // The first byte is the number of blocks, each behind its size in 4 bytes; 0: one block, without its size.
  const std::size_t blocks = packed.empty() ? 0 : packed[0];
  if (!packed.empty()) packed = packed.subspan(1);
  if (blocks == 0 && !packed.empty()) add(packed);
  for (std::size_t i = 0; i < blocks && !error_; ++i) {
    std::uint32_t size = 0;
    if (packed.size() >= sizeof size) std::memcpy(&size, packed.data(), sizeof size);
    if (packed.size() < sizeof size || size > packed.size() - sizeof size) {
      fail("a block of LZ4 within its data", fmt::format("one of {} bytes", size));
      break;
    }
    add(packed.subspan(sizeof size, size));
    packed = packed.subspan(sizeof size + size);
  }
  out.resize(error_ ? 0 : made);
  return out;
}

std::vector<unsigned char> CrateCursor::unpacked(std::uint64_t size) {
  std::vector<unsigned char> out = unpack(take(number<std::uint64_t>()), size);
  if (!error_ && out.size() != size) fail(fmt::format("{} bytes unpacked", size), fmt::format("{}", out.size()));
  if (error_) out.clear();
  return out;
}

/// The coding: the most common difference between neighbors, 2 bits for the size of each, and those that are not the
/// common one.
template <class Int>
std::vector<Int> CrateCursor::integers(std::uint64_t count) {
  using Unsigned = std::make_unsigned_t<Int>;
  constexpr std::size_t smallest = sizeof(Int) / 4;  // bytes of the differences with code 1; doubled for 2, and for 3
  std::vector<Int> out;
  const auto packed = take(number<std::uint64_t>());
  if (error_ || count == 0) return out;
  const std::uint64_t head = sizeof(Int) + (count + 3) / 4;
  const std::vector<unsigned char> coded = unpack(packed, head + count * sizeof(Int));
  if (error_ || coded.size() < head) {
    fail(fmt::format("{} bytes or more for {} integers", head, count), fmt::format("{}", coded.size()));
    return out;
  }
  Unsigned common = 0, current = 0;
  std::memcpy(&common, coded.data(), sizeof common);
  auto at = static_cast<std::size_t>(head);
  out.resize(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < out.size(); ++i) {
    const unsigned code = coded[sizeof(Int) + i / 4] >> (2 * (i % 4)) & 3u;
    Unsigned difference = common;
    if (code > 0) {
      const std::size_t size = smallest << (code - 1);
      if (coded.size() - at < size) {
        fail(fmt::format("{} integers", count), fmt::format("the end of their data after {}", i));
        out.clear();
        return out;
      }
      difference = coded[at + size - 1] & 0x80 ? static_cast<Unsigned>(-1) : 0;  // the sign
      std::memcpy(&difference, coded.data() + at, size);
      at += size;
    }
    current += difference;
    out[i] = static_cast<Int>(current);
  }
  return out;
}

template std::vector<std::uint32_t> CrateCursor::integers(std::uint64_t);
template std::vector<std::int32_t> CrateCursor::integers(std::uint64_t);
template std::vector<std::int64_t> CrateCursor::integers(std::uint64_t);

void CrateCursor::fail(std::string expected, std::string found) {
  fail_at(fmt::format("byte {} ({})", at_, part_), std::move(expected), std::move(found));
}

void CrateCursor::fail_at(std::string place, std::string expected, std::string found) {
  if (!error_) error_ = Error{name_, place.substr(0, 256), std::move(expected), std::move(found)};
  at_ = bytes_.size();
}

}  // namespace tress::scene
