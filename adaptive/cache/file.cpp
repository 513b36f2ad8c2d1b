// Cache files: they are read row by row, and replaced as a whole under a lock.
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
#include "base/file_replacement.h"
#include "base/save_lock.h"
#include "cache/byte_source.h"
#include "cache/format.h"
#include "cache/reader.h"
#include "tress/adaptive/cache.h"
#include "tress/base/replace_file.h"

namespace tress::inline v0_2::adaptive {
namespace {

namespace fs = std::filesystem;

Error system_error(const fs::path& file, const char* expected) {
  return {file.string(), "", expected, strerror(errno)};
}

std::size_t size_of(int descriptor) {
  struct stat status{};
  return ::fstat(descriptor, &status) == 0 ? static_cast<std::size_t>(status.st_size) : 0;
}

/// Replaces `target`, which is no link, by a file of the rows. The caller holds the lock. `file`: its name in errors.
Result<CacheContents> replace(const fs::path& target, const fs::path& file, RowSource& rows) {
  FileReplacement out;
  std::optional<Error> error = out.begin(target, file.string());
  if (error) return *error;
  if (!format::write_cache(rows, [&](std::string_view bytes) { return !(error = out.write(bytes)); })) {
    if (!error) error = rows.failure();
    if (error) return *error;
    return Error{file.string(), "", "rows that stay as they are while they are saved", "others"};
  }
  // A file that load_cache would refuse must not replace a good one.
  const FileBytes written(out.descriptor(), size_of(out.descriptor()));
  CacheReader reader(written, file.string());
  if (!reader.check(rows.model())) return reader.error();
  error = out.finish();
  if (error) return *error;
  return reader.contents();
}

bool is_absent(const fs::path& file) {
  std::error_code error;
  return fs::status(file, error).type() == fs::file_type::not_found;
}

}  // namespace

struct CacheFile::Opened {
  Opened(int number, std::size_t size, const std::string& name)
      : descriptor(number), bytes(number, size), reader(bytes, name) {}
  Descriptor descriptor;
  FileBytes bytes;
  CacheReader reader;
};

CacheFile::CacheFile(std::unique_ptr<Opened> opened) : opened_(std::move(opened)) {}
CacheFile::~CacheFile() = default;

Result<std::unique_ptr<CacheFile>> CacheFile::open(const fs::path& file, const std::string& model) {
  const int number = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (number < 0) return system_error(file, "a readable cache file");
  struct stat status{};
  const bool has_size = ::fstat(number, &status) == 0;
  auto opened =
      std::make_unique<Opened>(number, has_size ? static_cast<std::size_t>(status.st_size) : 0, file.string());
  if (!has_size) return system_error(file, "a readable cache file");
  if (!S_ISREG(status.st_mode)) return Error{file.string(), "", "a regular file", "a folder or a device"};
  if (!opened->reader.check(model)) return opened->reader.error();
  return std::unique_ptr<CacheFile>(new CacheFile(std::move(opened)));
}

const CacheContents& CacheFile::contents() const { return opened_->reader.contents(); }
const std::string& CacheFile::model() const { return opened_->reader.model(); }
void CacheFile::rewind() { opened_->reader.rewind(); }
const SliceDescription* CacheFile::next_slice() { return opened_->reader.next_slice(); }
const CachedRow* CacheFile::next_row() { return opened_->reader.next_row(); }
std::optional<Error> CacheFile::failure() const { return opened_->reader.failure(); }

Result<TableSnapshot> load_cache(const fs::path& file, const std::string& model) {
  const Result<std::unique_ptr<CacheFile>> opened = CacheFile::open(file, model);
  if (!opened) return opened.error();
  TableSnapshot table = collect(**opened);
  if (const std::optional<Error> error = (*opened)->failure()) return *error;
  return table;
}

Result<CacheSave> replace_cache(const fs::path& file, RowSource& rows) {
  const fs::path target = behind_links(file);
  SaveLock lock;
  if (std::optional<Error> error = lock.acquire(target, file.string())) return *error;
  const Result<CacheContents> saved = replace(target, file, rows);
  if (!saved) return saved.error();
  return CacheSave{*saved, lock.held() ? remove_leftovers(target) : std::vector<fs::path>{}};
}

std::optional<Error> save_cache(const fs::path& file, const TableSnapshot& image) {
  SnapshotRows rows(image);
  const Result<CacheSave> saved = replace_cache(file, rows);
  return saved ? std::nullopt : std::optional<Error>(saved.error());
}

Result<CacheUpdate> merge_into_cache(const fs::path& file, RowSource& rows) {
  if (rows.model().empty()) return Error{file.string(), "model", "a name", "none"};
  const fs::path target = behind_links(file);
  SaveLock lock;
  if (std::optional<Error> error = lock.acquire(target, file.string())) return *error;
  CacheUpdate update;
  const auto save = [&](RowSource& all) -> std::optional<Error> {
    const Result<CacheContents> saved = replace(target, file, all);
    if (!saved) return saved.error();
    update.contents = *saved;
    return std::nullopt;
  };
  if (is_absent(target)) {
    if (std::optional<Error> error = save(rows)) return *error;
  } else {
    const Result<std::unique_ptr<CacheFile>> there = CacheFile::open(file, rows.model());
    if (!there) {
      update.outcome = CacheUpdate::Outcome::refused;
      update.refusal = there.error();
      return update;
    }
    update.outcome = CacheUpdate::Outcome::merged;
    MergedRows both(rows, **there);
    if (std::optional<Error> error = save(both)) return *error;
  }
  if (lock.held()) update.removed = remove_leftovers(target);
  return update;
}

Result<CacheUpdate> merge_into_cache(const fs::path& file, const TableSnapshot& image) {
  SnapshotRows rows(image);
  return merge_into_cache(file, rows);
}

}  // namespace tress::inline v0_2::adaptive
