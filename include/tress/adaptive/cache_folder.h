// A folder of caches of one slice each, which keeps everything that was learned. The caches that were used longest ago
// are removed to make room for others.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tress/adaptive/cache.h"
#include "tress/adaptive/service.h"
#include "tress/base/error.h"

namespace tress::inline v0_2::adaptive {

/// $XDG_CACHE_HOME/tress, else $HOME/.cache/tress. Error if neither is an absolute path.
Result<std::filesystem::path> default_cache_folder();

/// A session's access to the folder. Each file is a whole cache (CACHE_FORMAT.md) of one slice. Its name is a hash of
/// the model's name, the rules of g and the slice, so a service reads and writes only the slices that it has. The
/// modification time of a file is the time when it was last used. Any number of sessions, on any number of machines
/// that share the folder, may use it at once: files are merged as merge_into_cache() does, and one that was removed
/// meanwhile is written anew. One thread, between passes.
class CacheFolder {
 public:
  struct File {
    std::filesystem::path path;
    std::uint64_t bytes = 0;
    std::filesystem::file_time_type used;
  };

  explicit CacheFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}
  const std::filesystem::path& folder() const { return folder_; }

  /// Makes the folder. Error if it cannot be written to.
  std::optional<Error> check() const;

  /// Counts of everything that was read. refused: files that are not caches; they stay as they are and are never
  /// written over.
  struct Loaded {
    CacheContents contents;
    std::uint64_t files = 0;
    std::vector<Error> refused;
  };
  /// Loads the rows of the slices that the service has.
  Loaded load(Service& service);

  /// Counts of the contents of the files of the service's slices. removed: temporary files left by saves that were
  /// killed.
  struct Saved {
    CacheContents contents;
    std::uint64_t files = 0;
    std::vector<Error> refused;
    std::vector<std::filesystem::path> removed;
  };
  /// Merges the service's rows with those in the folder, or replaces those. Files that have not changed since load()
  /// are not written. Error if a file could not be written.
  Result<Saved> save(const Service& service, bool replaces);

  /// All files, the last used first.
  std::vector<File> files() const;

  struct Pruned {
    std::vector<File> removed;
    std::uint64_t files_left = 0, bytes_left = 0;
  };
  /// Removes the files that were used longest ago, until the others have at most this many bytes.
  Result<Pruned> prune(std::uint64_t most_bytes) const;

 private:
  std::filesystem::path file_of(const std::string& model, const SliceDescription& slice) const;

  std::filesystem::path folder_;
  std::map<std::filesystem::path, CacheContents> known_;  ///< contents of files that have not changed since
};

}  // namespace tress::inline v0_2::adaptive
