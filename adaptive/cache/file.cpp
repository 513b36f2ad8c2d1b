// Cache files: read whole; written beside the old one, flushed, and put in its place in one step.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <utility>

#include "tress/adaptive/cache.h"

namespace tress::adaptive {
namespace {

namespace fs = std::filesystem;

/// Closes the descriptor at the end of the scope.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }
  bool is_open() const { return number_ >= 0; }
  bool close() { return number_ < 0 || ::close(std::exchange(number_, -1)) == 0; }

 private:
  int number_;
};

Error system_error(const fs::path& file, const char* expected) {
  return {file.string(), "", expected, strerror(errno)};
}

/// A name beside `file` that no other thread or process takes: created exclusively.
Descriptor create_beside(const fs::path& file, fs::path* temporary) {
  static std::atomic<std::uint32_t> serial{0};
  for (int attempt = 0; attempt < 100; ++attempt) {
    *temporary = file;
    *temporary += ".tmp-" + std::to_string(::getpid()) + "-" + std::to_string(serial.fetch_add(1));
    const int number = ::open(temporary->c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (number >= 0 || errno != EEXIST) return Descriptor(number);
  }
  return Descriptor(-1);
}

bool write_all(int descriptor, const std::string& bytes) {
  std::size_t written = 0;
  while (written < bytes.size()) {
    const ssize_t step = ::write(descriptor, bytes.data() + written, bytes.size() - written);
    if (step < 0 && errno == EINTR) continue;
    if (step < 0) return false;
    written += static_cast<std::size_t>(step);
  }
  return true;
}

bool flush_folder(const fs::path& file) {
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  const Descriptor opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!opened.is_open()) return false;
  // Some file systems cannot flush a folder and say EINVAL: the rename is then as durable as they make it.
  return ::fsync(opened.number()) == 0 || errno == EINVAL;
}

}  // namespace

Result<TableImage> load_cache(const fs::path& file, const std::string& model) {
  const Descriptor opened(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (!opened.is_open()) return system_error(file, "a readable cache file");
  struct stat status{};
  if (::fstat(opened.number(), &status) != 0) return system_error(file, "a readable cache file");
  if (!S_ISREG(status.st_mode)) return Error{file.string(), "", "a regular file", "a folder or a device"};
  std::string bytes(static_cast<std::size_t>(status.st_size), '\0');
  std::size_t got = 0;
  while (got < bytes.size()) {
    const ssize_t step = ::read(opened.number(), bytes.data() + got, bytes.size() - got);
    if (step < 0 && errno == EINTR) continue;
    if (step < 0) return system_error(file, "a readable cache file");
    if (step == 0) break;
    got += static_cast<std::size_t>(step);
  }
  bytes.resize(got);
  return decode_cache(bytes, model, file.string());
}

std::optional<Error> save_cache(const fs::path& file, const TableImage& image) {
  const std::string bytes = encode_cache(image);
  // An image that load_cache would refuse must not take the place of a good file.
  if (const auto readable = decode_cache(bytes, image.model, file.string()); !readable) return readable.error();

  // A link stays a link: what it points to is replaced.
  std::error_code ignored;
  const fs::path target = fs::is_symlink(file, ignored) ? fs::weakly_canonical(file, ignored) : file;
  fs::path temporary;
  Descriptor opened = create_beside(target, &temporary);
  if (!opened.is_open()) return system_error(file, "a folder that can be written to");
  const bool renamed = write_all(opened.number(), bytes) && ::fsync(opened.number()) == 0 && opened.close() &&
                       ::rename(temporary.c_str(), target.c_str()) == 0;
  if (!renamed) {
    const Error error = system_error(file, "room for the cache");
    ::unlink(temporary.c_str());
    return error;
  }
  if (!flush_folder(target)) return system_error(file, "a folder that can be flushed");
  return std::nullopt;
}

}  // namespace tress::adaptive
