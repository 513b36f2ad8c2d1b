#include "scene/read/input_files.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <fstream>
#include <string_view>
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

/// Reads the first min(size, wanted) bytes; an error if the file is larger than `most_bytes`.
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

bool is_packed(std::span<const unsigned char> bytes) {
  return bytes.size() > 2 && bytes[0] == 0x1f && bytes[1] == 0x8b;
}

Result<std::vector<unsigned char>> unpacked(std::vector<unsigned char> bytes, const std::string& name,
                                            std::uintmax_t most_bytes) {
  if (!is_packed(bytes)) return bytes;
  constexpr std::size_t block = std::size_t{1} << 20, most_at_once = std::size_t{1} << 30;
  constexpr int window_of_gzip = 15 + 32;
  z_stream stream{};
  if (inflateInit2(&stream, window_of_gzip) != Z_OK) return Error{name, "", "memory to unpack it", "none"};
  std::vector<unsigned char> out;
  std::size_t at = 0;
  int state = Z_OK;
  bool goes_on = true;
  while (goes_on) {
    const std::size_t before = out.size();
    out.resize(before + block);
    stream.next_in = bytes.data() + at;
    stream.avail_in = static_cast<uInt>(std::min(bytes.size() - at, most_at_once));
    stream.next_out = out.data() + before;
    stream.avail_out = static_cast<uInt>(block);
    state = inflate(&stream, Z_NO_FLUSH);
    at = static_cast<std::size_t>(stream.next_in - bytes.data());
    out.resize(out.size() - stream.avail_out);
    const bool is_next = state == Z_STREAM_END && is_packed(std::span(bytes).subspan(at));  // another member follows
    if (is_next) inflateReset(&stream);
    goes_on = (is_next || (state == Z_OK && (out.size() > before || at < bytes.size()))) && out.size() <= most_bytes;
  }
  inflateEnd(&stream);
  if (out.size() > most_bytes)
    return Error{name, "", fmt::format("at most {} bytes once it is unpacked", most_bytes), "more"};
  if (state != Z_STREAM_END)
    return Error{name, fmt::format("byte {}", at), "data packed by gzip", "damaged ones, or the end of the file"};
  return out;
}

Result<std::vector<unsigned char>> read_file_start(const std::filesystem::path& file, const std::string& what,
                                                   std::size_t bytes) {
  return read(file, what, bytes, UINTMAX_MAX);
}

namespace {

using namespace std::string_view_literals;

struct Mark {
  std::string_view bytes, kind;
};

constexpr std::array marks{
    Mark{"HAIR"sv, "a .hair groom"},
    Mark{"Ogawa"sv, "an Alembic archive (Ogawa)"},
    Mark{"\x89HDF\r\n\x1a\n"sv, "an HDF5 file, as old Alembic archives are"},
    Mark{"PXR-USDC"sv, "a binary USD file"},
    Mark{"#usda "sv, "a USD text"},
    Mark{"glTF"sv, "a binary glTF file"},
    Mark{"Kaydara FBX Binary"sv, "a binary FBX file"},
    Mark{"BLENDER"sv, "a Blender file"},
    Mark{"//Maya"sv, "a Maya text"},
    Mark{"ply\n"sv, "a PLY file"},
    Mark{"\x1f\x8b"sv, "data packed by gzip"},
    Mark{"PK\x03\x04"sv, "a zip archive"},
    Mark{"BZh"sv, "data packed by bzip2"},
    Mark{"\xfd"
         "7zXZ\0"sv,
         "data packed by xz"},
    Mark{"\x28\xb5\x2f\xfd"sv, "data packed by zstd"},
    Mark{"\xff\xfe"sv, "a text in UTF-16, where UTF-8 is read"},
    Mark{"\xfe\xff"sv, "a text in UTF-16, where UTF-8 is read"},
    Mark{"\x89PNG\r\n\x1a\n"sv, "a PNG picture"},
    Mark{"\xff\xd8\xff"sv, "a JPEG picture"},
    Mark{"\x76\x2f\x31\x01"sv, "an OpenEXR picture"},
    Mark{"#?RADIANCE"sv, "a Radiance (HDR) picture"},
    Mark{"#?RGBE"sv, "a Radiance (HDR) picture"},
    Mark{"II*\0"sv, "a TIFF picture"},
    Mark{"MM\0*"sv, "a TIFF picture"},
    Mark{"%PDF"sv, "a PDF document"},
    Mark{"<?xml"sv, "an XML document"},
    Mark{"\x7f"
         "ELF"sv,
         "a program (ELF)"},
};

bool is_printable(unsigned char c) { return c >= ' ' && c <= '~'; }

}  // namespace

std::string known_kind_of(std::span<const unsigned char> start) {
  const std::string_view text(reinterpret_cast<const char*>(start.data()), start.size());
  const auto found = std::ranges::find_if(marks, [&](const Mark& mark) { return text.starts_with(mark.bytes); });
  return found == marks.end() ? "" : std::string(found->kind);
}

std::string kind_of(std::span<const unsigned char> start) {
  if (start.empty()) return "an empty file";
  if (std::string known = known_kind_of(start); !known.empty()) return known;
  start = start.first(std::min(start.size(), bytes_of_kind));
  const auto is_text = [](unsigned char c) {
    return is_printable(c) || c == '\n' || c == '\r' || c == '\t' || c >= 128;
  };
  if (std::ranges::all_of(start, is_text)) {
    std::string word;
    for (unsigned char c : start.first(std::min<std::size_t>(start.size(), 20))) {
      if (c == '\n' || c == '\r') break;
      word += is_printable(c) ? static_cast<char>(c) : '?';
    }
    return fmt::format("a text that begins \"{}\"", word);
  }
  std::string bytes;
  for (unsigned char c : start.first(std::min<std::size_t>(start.size(), 4))) bytes += fmt::format(" {:02x}", c);
  return "binary data that begins" + bytes;
}

}  // namespace tress::scene
