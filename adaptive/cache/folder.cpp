// A folder of caches with one slice each.
#include <algorithm>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/save_lock.h"
#include "tress/adaptive/cache_folder.h"
#include "tress/base/replace_file.h"

namespace tress::inline v0_2::adaptive {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view ending = ".cache";
constexpr std::size_t name_digits = 16;

/// Whether the name is 16 hexadecimal digits and the ending.
bool is_ours(const std::string& name) {
  return name.size() == name_digits + ending.size() && name.ends_with(ending) &&
         name.find_first_not_of("0123456789abcdef") == name_digits;
}

/// Marks the file as used now. If this fails, only the order in which files are removed changes.
void mark_used(const fs::path& file) {
  std::error_code ignored;
  fs::last_write_time(file, fs::file_time_type::clock::now(), ignored);
}

void add(CacheContents* all, const CacheContents& one) {
  all->bytes += one.bytes;
  all->slices += one.slices;
  all->open_rows += one.open_rows;
  all->converged_rows += one.converged_rows;
  all->knot_rows += one.knot_rows;
  all->ribbon_rows += one.ribbon_rows;
}

bool is_there(const fs::path& file) {
  std::error_code error;
  return fs::status(file, error).type() != fs::file_type::not_found;
}

}  // namespace

Result<fs::path> default_cache_folder() {
  const auto absolute = [](const char* name) {
    const char* text = std::getenv(name);
    const fs::path path = text != nullptr ? text : "";
    return path.is_absolute() ? path : fs::path();
  };
  if (const fs::path caches = absolute("XDG_CACHE_HOME"); !caches.empty()) return caches / "tress";
  if (const fs::path home = absolute("HOME"); !home.empty()) return home / ".cache" / "tress";
  return Error{"default", "", "$XDG_CACHE_HOME or $HOME to be the path of a folder", "neither"};
}

fs::path CacheFolder::file_of(const std::string& model, const SliceDescription& slice) const {
  return folder_ / (cache_hash(TableSnapshot{model, {{slice, {}}}}) + std::string(ending));
}

std::optional<Error> CacheFolder::check() const {
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) return Error{folder_.string(), "", "a folder, or a place where one can be made", error.message()};
  return check_replaceable(folder_ / ("0" + std::string(ending)));
}

CacheFolder::Loaded CacheFolder::load(Service& service) {
  Loaded loaded;
  const std::string model = service.rows()->model();
  for (SliceId id = 0; id < service.slice_count(); ++id) {
    const fs::path file = file_of(model, service.slice(id));
    if (!is_there(file)) continue;
    const auto cache = CacheFile::open(file, model);
    std::optional<Error> error = cache ? service.load(**cache) : std::optional<Error>(cache.error());
    if (error) {
      if (error->file.empty()) error->file = file.string();
      loaded.refused.push_back(*error);
      continue;
    }
    mark_used(file);
    add(&loaded.contents, (*cache)->contents());
    ++loaded.files;
    known_[file] = (*cache)->contents();
  }
  return loaded;
}

Result<CacheFolder::Saved> CacheFolder::save(const Service& service, bool replaces) {
  Saved saved;
  const std::unique_ptr<RowSource> rows = service.rows();
  while (const SliceDescription* slice = rows->next_slice()) {
    TableSnapshot one{rows->model(), {{*slice, {}}}};
    while (const CachedRow* row = rows->next_row()) one.slices.front().rows.push_back(*row);
    if (one.slices.front().rows.empty()) continue;
    const fs::path file = file_of(one.model, *slice);
    const auto known = known_.find(file);
    const bool is_known = known != known_.end() && known->second.hash == cache_hash(one) && is_there(file);
    CacheContents contents;
    if (is_known) {
      mark_used(file);
      contents = known->second;
    } else {
      CacheSave done;
      SnapshotRows source(one);
      if (replaces) {
        Result<CacheSave> replaced = replace_cache(file, source);
        if (!replaced) return replaced.error();
        done = std::move(*replaced);
      } else {
        Result<CacheUpdate> merged = merge_into_cache(file, source);
        if (!merged) return merged.error();
        if (merged->refusal) {
          saved.refused.push_back(*merged->refusal);
          continue;
        }
        done = std::move(*merged);
      }
      contents = done.contents;
      saved.removed.insert(saved.removed.end(), done.removed.begin(), done.removed.end());
      known_[file] = contents;
    }
    add(&saved.contents, contents);
    ++saved.files;
  }
  return saved;
}

std::vector<CacheFolder::File> CacheFolder::files() const {
  std::vector<File> found;
  std::error_code error;
  for (fs::directory_iterator entry(folder_, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code gone;
    if (!is_ours(entry->path().filename().string()) || !entry->is_regular_file(gone)) continue;
    File file{entry->path(), entry->file_size(gone), {}};
    if (!gone) file.used = entry->last_write_time(gone);
    if (!gone) found.push_back(std::move(file));
  }
  std::ranges::sort(found,
                    [](const File& a, const File& b) { return a.used != b.used ? a.used > b.used : a.path < b.path; });
  return found;
}

Result<CacheFolder::Pruned> CacheFolder::prune(std::uint64_t most_bytes) const {
  Pruned pruned;
  for (const File& file : files()) {
    if (pruned.bytes_left + file.bytes <= most_bytes && pruned.removed.empty()) {
      pruned.bytes_left += file.bytes;
      ++pruned.files_left;
      continue;
    }
    // Another process that saves this file meanwhile holds the lock, or waits for it and then writes the file anew.
    SaveLock lock;
    if (std::optional<Error> error = lock.acquire(file.path, file.path.string())) return *error;
    std::error_code gone;
    const bool is_as_listed = fs::last_write_time(file.path, gone) == file.used && !gone;
    if (is_as_listed && fs::remove(file.path, gone)) {
      pruned.removed.push_back(file);
    } else if (gone && gone != std::errc::no_such_file_or_directory) {
      return Error{file.path.string(), "", "a file that can be removed", gone.message()};
    } else if (is_there(file.path)) {
      pruned.bytes_left += file.bytes;
      ++pruned.files_left;
    }
  }
  return pruned;
}

}  // namespace tress::inline v0_2::adaptive
