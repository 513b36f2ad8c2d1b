#include "scene/read/grooms/usdz_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

namespace tress::scene {
namespace {

constexpr std::uint32_t entry_mark = 0x04034b50, row_mark = 0x02014b50, end_mark = 0x06054b50;
constexpr std::size_t entry_bytes = 30, row_bytes = 46, end_bytes = 22, most_remark = 65535;

std::uint32_t number_at(std::span<const unsigned char> bytes, std::size_t at, int size) {
  std::uint32_t value = 0;
  for (int i = 0; i < size; ++i) value |= std::uint32_t{bytes[at + static_cast<std::size_t>(i)]} << (8 * i);
  return value;
}

std::string text_at(std::span<const unsigned char> bytes, std::size_t at, std::size_t size) {
  const auto part = bytes.subspan(at, std::min(size, bytes.size() - at));
  return printable({part.begin(), part.end()});
}

bool is_layer(std::string_view name) {
  return name.ends_with(".usd") || name.ends_with(".usda") || name.ends_with(".usdc");
}

}  // namespace

bool is_usdz(std::span<const unsigned char> bytes) {
  return bytes.size() >= entry_bytes && number_at(bytes, 0, 4) == entry_mark &&
         is_layer(text_at(bytes, entry_bytes, number_at(bytes, 26, 2)));
}

/// The table of the entries is near the end of the archive. A record after it gives its place, and may end with a
/// comment.
Result<UsdzFile> read_usdz_file(std::span<const unsigned char> bytes, const std::string& name) {
  const auto fail = [&](std::size_t at, std::string expected, std::string found) {
    return Error{name, fmt::format("byte {}", at), std::move(expected), std::move(found)};
  };
  std::size_t end = bytes.size() < end_bytes ? 0 : bytes.size() - end_bytes + 1;
  const std::size_t first = end > most_remark ? end - most_remark - 1 : 0;
  while (end > first && number_at(bytes, end - 1, 4) != end_mark) --end;
  if (end == first) return fail(bytes.size(), "the table of a zip archive at its end", "none");
  --end;
  struct Row {
    std::string name;
    std::size_t row_at, at;
    std::uint32_t method, size;
  };
  std::vector<Row> entries;
  std::size_t at = number_at(bytes, end + 16, 4);
  const std::uint32_t rows = number_at(bytes, end + 10, 2);
  for (std::uint32_t row = 0; row < rows; ++row) {
    if (at > end || end - at < row_bytes || number_at(bytes, at, 4) != row_mark)
      return fail(std::min(at, bytes.size()), fmt::format("entry {} of {} in the table of the archive", row + 1, rows),
                  "none");
    entries.push_back({text_at(bytes, at + row_bytes, number_at(bytes, at + 28, 2)), at, number_at(bytes, at + 42, 4),
                       number_at(bytes, at + 10, 2), number_at(bytes, at + 24, 4)});
    at += row_bytes + number_at(bytes, at + 28, 2) + number_at(bytes, at + 30, 2) + number_at(bytes, at + 32, 2);
  }
  if (rows == 0) return fail(end, "a layer of USD in the archive", "no entries");
  std::ranges::sort(entries, {}, [](const Row& entry) { return std::pair(entry.at, entry.row_at); });
  UsdzFile file;
  for (const Row& entry : entries) {
    const bool is_first = &entry == entries.data();
    std::optional<Error> fault;
    if (!is_layer(entry.name))
      fault = fail(entry.at, "a layer of USD (.usd, .usda, .usdc) as the first entry", entry.name);
    else if (entry.method != 0)
      fault = fail(entry.row_at, "entries that are stored, as .usdz has them (zip -0)",
                   fmt::format("{}, packed by method {}", entry.name, entry.method));
    else if (entry.at > end || end - entry.at < entry_bytes || number_at(bytes, entry.at, 4) != entry_mark)
      fault = fail(std::min(entry.at, bytes.size()), fmt::format("the entry {}", entry.name), "none");
    else if (const std::size_t data_at =
                 entry.at + entry_bytes + number_at(bytes, entry.at + 26, 2) + number_at(bytes, entry.at + 28, 2);
             data_at > end || entry.size > end - data_at)
      fault = fail(entry.at, fmt::format("{} bytes of {}", entry.size, entry.name),
                   fmt::format("{}", data_at > end ? 0 : end - data_at));
    else
      file.layers.push_back({entry.name, bytes.subspan(data_at, entry.size)});
    if (fault && is_first) return *fault;
    if (fault) file.others.push_back(entry.name);
  }
  return file;
}

}  // namespace tress::scene
