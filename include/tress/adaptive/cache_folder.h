// One place for all that was ever learned: a folder of caches, each of one slice, of which those that were used longest
// ago make room for others.
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

namespace tress::adaptive {

/// $XDG_CACHE_HOME/tress, else $HOME/.cache/tress. Error where neither is an absolute path.
Result<std::filesystem::path> default_cache_folder();

/// A session's dealings with the folder. Each file is a whole cache (CACHE_FORMAT.md) of one slice; its name is a hash
/// of the model's name, the rules of g and the slice, so that a service reads and writes the slices that it has and no
/// others. When a file was used is its time of modification. Any number of sessions, on any number of machines that
/// share the folder, may use it at once: files are joined as merge_into_cache() does, and one that was removed
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

  /// Makes the folder. Error if nothing can be written there.
  std::optional<Error> check() const;

  /// What was read: counts of all of it. refused: files that are not caches, which stay as they are and are never
  /// written over.
  struct Loaded {
    CacheContents contents;
    std::uint64_t files = 0;
    std::vector<Error> refused;
  };
  /// The rows of the slices that the service has.
  Loaded load(Service& service);

  /// What the files of the service's slices hold now. removed: temporary files that killed saves had left.
  struct Saved {
    CacheContents contents;
    std::uint64_t files = 0;
    std::vector<Error> refused;
    std::vector<std::filesystem::path> removed;
  };
  /// The service's rows joined with what is there, or in its place. What has not changed since load() is not written.
  /// Error if a file could not be written.
  Result<Saved> save(const Service& service, bool replaces);

  /// All of them, that which was used last first.
  std::vector<File> files() const;

  struct Pruned {
    std::vector<File> removed;
    std::uint64_t files_left = 0, bytes_left = 0;
  };
  /// Removes those that were used longest ago, until the others have no more bytes than this.
  Result<Pruned> prune(std::uint64_t most_bytes) const;

 private:
  std::filesystem::path file_of(const std::string& model, const SliceDescription& slice) const;

  std::filesystem::path folder_;
  std::map<std::filesystem::path, CacheContents> known_;  ///< of files that are as they were read or written
};

}  // namespace tress::adaptive
