#include "base/section_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <limits>

#include "base/content_hash.h"
#include "base/descriptor.h"
#include "base/file_replacement.h"
#include "base/word_packing.h"
#include "tress/base/replace_file.h"

namespace tress::inline v0_2 {
namespace {

constexpr std::string_view magic{"\x89TRESSK\n", 8};
constexpr std::uint32_t version = 2, most_sections = 64, longest_name = 64;
constexpr std::size_t header_bytes = 16;
/// Pieces are packed, hashed and written while they are in the processor's cache.
constexpr std::size_t piece_bytes = std::size_t{1} << 18;
constexpr std::uint64_t most_of_a_byte = 64;  ///< the most bytes that unpack_words() makes of one

std::string integer(std::uint64_t value, int size) {
  std::string bytes;
  for (int i = 0; i < size; ++i) bytes.push_back(static_cast<char>(value >> (8 * i) & 0xff));
  return bytes;
}

/// Reads a regular file from its beginning, with a count of the bytes that are left.
class Input {
 public:
  explicit Input(const std::filesystem::path& file)
      : name_(file.string()), opened_(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
    struct stat status{};
    if (opened_.number() < 0 || ::fstat(opened_.number(), &status) != 0) {
      error_ = Error{name_, "", "a file that can be read", std::strerror(errno)};
    } else if (!S_ISREG(status.st_mode)) {
      error_ = Error{name_, "", "a regular file", "a folder or a device"};
    } else {
      left_ = static_cast<std::uint64_t>(status.st_size);
    }
  }

  const std::optional<Error>& error() const { return error_; }
  std::uint64_t left() const { return left_; }
  bool fail(const std::string& expected, const std::string& found) {
    if (!error_) error_ = Error{name_, "byte " + std::to_string(at_), expected, found};
    return false;
  }
  bool bytes(std::uint64_t size, std::string* to) {
    if (error_) return false;
    if (size > left_) return fail(std::to_string(size) + " more bytes", std::to_string(left_));
    to->resize(static_cast<std::size_t>(size));
    for (std::size_t done = 0; done < to->size();) {
      const ssize_t step = ::read(opened_.number(), to->data() + done, std::min(to->size() - done, most_at_once));
      if (step < 0 && errno == EINTR) continue;
      if (step <= 0) return fail("bytes that can be read", step < 0 ? std::strerror(errno) : "the end of the file");
      done += static_cast<std::size_t>(step);
    }
    at_ += size;
    left_ -= size;
    return true;
  }
  bool integer(int size, std::uint64_t* value) {
    std::string bytes;
    if (!this->bytes(static_cast<std::uint64_t>(size), &bytes)) return false;
    *value = 0;
    for (int i = 0; i < size; ++i)
      *value |= static_cast<std::uint64_t>(static_cast<unsigned char>(bytes[static_cast<std::size_t>(i)])) << (8 * i);
    return true;
  }

 private:
  static constexpr std::size_t most_at_once = std::size_t{1} << 30;
  std::string name_;
  Descriptor opened_;
  std::optional<Error> error_;
  std::uint64_t at_ = 0, left_ = 0;
};

bool read_piece(Input& in, const std::string& name, std::size_t size, std::string* payload) {
  std::uint64_t stored_size = 0, sum = 0;
  std::string stored, bytes;
  if (!in.integer(4, &stored_size) || !in.integer(8, &sum)) return false;
  if (stored_size > size) return in.fail("at most " + std::to_string(size) + " bytes", std::to_string(stored_size));
  if (!in.bytes(stored_size, &stored)) return false;
  const bool is_packed = stored_size < size;
  if (is_packed && !unpack_words(stored, size, &bytes)) return in.fail("packed words of " + name, "other bytes");
  const std::string& whole = is_packed ? bytes : stored;
  if (content_hash(whole) != sum) return in.fail("section " + name + " as its checksum says", "other bytes");
  *payload += whole;
  return true;
}

bool read_section(Input& in, std::map<std::string, std::string>* sections) {
  std::uint64_t name_size = 0, size = 0;
  std::string name, payload;
  if (!in.integer(4, &name_size)) return false;
  if (name_size == 0 || name_size > longest_name)
    return in.fail("a name of 1 to 64 characters", std::to_string(name_size));
  if (!in.bytes(name_size, &name)) return false;
  if (!std::ranges::all_of(name, [](char c) { return c > ' ' && c <= '~'; }))
    return in.fail("a name in printable ASCII", "another");
  if (!in.integer(8, &size)) return false;
  payload.reserve(static_cast<std::size_t>(std::min(size, most_of_a_byte * in.left())));
  while (payload.size() < size) {
    const std::uint64_t left = size - payload.size();
    if (!read_piece(in, name, static_cast<std::size_t>(std::min<std::uint64_t>(left, piece_bytes)), &payload))
      return false;
  }
  if (!sections->emplace(name, std::move(payload)).second) return in.fail("section " + name + " once", "twice");
  return true;
}

std::optional<Error> write_section(FileReplacement& out, const std::string& name, std::string_view payload) {
  if (auto error = out.write(integer(name.size(), 4) + name + integer(payload.size(), 8))) return error;
  std::string packed;
  for (std::size_t at = 0; at < payload.size(); at += piece_bytes) {
    const std::string_view piece = payload.substr(at, piece_bytes);
    pack_words(piece, &packed);
    const std::string_view stored = packed.size() < piece.size() ? packed : piece;
    if (auto error = out.write(integer(stored.size(), 4) + integer(content_hash(piece), 8))) return error;
    if (auto error = out.write(stored)) return error;
  }
  return std::nullopt;
}

}  // namespace

std::optional<Error> write_sections(const std::filesystem::path& file, const Sections& sections) {
  FileReplacement out;
  const std::filesystem::path target = behind_links(file);
  if (auto error = out.begin(target, file.string())) return error;
  std::string head(magic);
  head += integer(version, 4) + integer(sections.size(), 4);
  if (auto error = out.write(head)) return error;
  for (const auto& [name, payload] : sections) {
    if (auto error = write_section(out, name, payload)) return error;
  }
  if (auto error = out.finish()) return error;
  (void)remove_leftovers(target);
  return std::nullopt;
}

Result<std::map<std::string, std::string>> read_sections(const std::filesystem::path& file) {
  Input in(file);
  std::map<std::string, std::string> sections;
  std::string mark;
  std::uint64_t found = 0, count = 0;
  if (in.error()) return *in.error();
  if (in.left() < header_bytes) in.fail("a header of 16 bytes", std::to_string(in.left()) + " bytes");
  if (in.bytes(magic.size(), &mark) && mark != magic) in.fail("a checkpoint or part of tress", "another file");
  if (in.integer(4, &found) && found != version)
    in.fail("format version " + std::to_string(version), std::to_string(found));
  if (in.integer(4, &count) && count > most_sections) in.fail("at most 64 sections", std::to_string(count));
  for (; !in.error() && count > 0; --count) (void)read_section(in, &sections);
  if (!in.error() && in.left() != 0) in.fail("the end of the file", std::to_string(in.left()) + " more bytes");
  if (in.error()) return *in.error();
  return sections;
}

}  // namespace tress::inline v0_2
