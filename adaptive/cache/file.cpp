// Cache files: read whole; replaced whole, under a lock.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "base/descriptor.h"
#include "base/save_lock.h"
#include "cache/format.h"
#include "tress/adaptive/cache.h"
#include "tress/base/replace_file.h"

namespace tress::adaptive {
namespace {

namespace fs = std::filesystem;

Error system_error(const fs::path& file, const char* expected) {
  return {file.string(), "", expected, strerror(errno)};
}

/// Puts `image` in the place of `target`, no link, under a lock that the caller holds. `file`: its name in errors.
std::optional<Error> replace(const fs::path& target, const fs::path& file, const TableSnapshot& image) {
  const std::string bytes = encode_cache(image);
  // An image that load_cache would refuse must not take the place of a good file.
  if (const auto readable = decode_cache(bytes, image.model, file.string()); !readable) return readable.error();
  return replace_file(target, bytes, file.string());
}

/// Reads on at the end of `bytes` until they are `size` or the file ends.
bool read_up_to(int descriptor, std::size_t size, std::string* bytes) {
  std::size_t got = bytes->size();
  bytes->resize(size);
  while (got < size) {
    const ssize_t step = ::read(descriptor, bytes->data() + got, size - got);
    if (step < 0 && errno == EINTR) continue;
    if (step < 0) return false;
    if (step == 0) break;
    got += static_cast<std::size_t>(step);
  }
  bytes->resize(got);
  return true;
}

bool is_absent(const fs::path& file) {
  std::error_code error;
  return fs::status(file, error).type() == fs::file_type::not_found;
}

}  // namespace

Result<TableSnapshot> load_cache(const fs::path& file, const std::string& model) {
  const Descriptor opened(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (!opened.is_open()) return system_error(file, "a readable cache file");
  struct stat status{};
  if (::fstat(opened.number(), &status) != 0) return system_error(file, "a readable cache file");
  if (!S_ISREG(status.st_mode)) return Error{file.string(), "", "a regular file", "a folder or a device"};
  // Its first bytes alone, so that no memory is asked for a large file of another kind.
  const auto size = static_cast<std::size_t>(status.st_size);
  std::string bytes;
  if (!read_up_to(opened.number(), std::min(size, format::header_bytes), &bytes) ||
      (bytes.starts_with(format::magic) && !read_up_to(opened.number(), size, &bytes))) {
    return system_error(file, "a readable cache file");
  }
  return decode_cache(bytes, model, file.string());
}

std::optional<Error> save_cache(const fs::path& file, const TableSnapshot& image, std::vector<fs::path>* removed) {
  const fs::path target = behind_links(file);
  SaveLock lock;
  if (std::optional<Error> error = lock.acquire(target, file.string())) return error;
  if (std::optional<Error> error = replace(target, file, image)) return error;
  std::vector<fs::path> leftovers;
  if (lock.held()) leftovers = remove_leftovers(target);
  if (removed != nullptr) *removed = std::move(leftovers);
  return std::nullopt;
}

Result<CacheUpdate> merge_into_cache(const fs::path& file, TableSnapshot image) {
  if (image.model.empty()) return Error{file.string(), "model", "a name", "none"};
  const fs::path target = behind_links(file);
  SaveLock lock;
  if (std::optional<Error> error = lock.acquire(target, file.string())) return *error;
  CacheUpdate update;
  if (is_absent(target)) {
    update.image = std::move(image);
  } else {
    const Result<TableSnapshot> there = load_cache(file, image.model);
    if (!there) {
      update.outcome = CacheUpdate::Outcome::refused;
      update.refusal = there.error();
      return update;
    }
    update.outcome = CacheUpdate::Outcome::merged;
    update.image = merge_caches(image, *there);
  }
  if (std::optional<Error> error = replace(target, file, update.image)) return *error;
  if (lock.held()) update.removed = remove_leftovers(target);
  return update;
}

}  // namespace tress::adaptive
