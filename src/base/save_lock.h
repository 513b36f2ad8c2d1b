// One saver at a time for a cache file: among threads, processes and the machines of a shared folder.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "base/descriptor.h"
#include "tress/base/error.h"

namespace tress {

/// Holds an exclusive flock on `FILE.lock`, made for it and removed with it. Not on the cache, which each save
/// replaces; not on its folder, which NFS cannot lock and others lock for reasons of their own. The kernel frees it
/// however a session ends: a lock file that a killed session left locks nobody out.
class SaveLock {
 public:
  /// `file`: the real one, no link; `name`: what errors call it. Waits as long as another holds it.
  /// Error if the lock file cannot be opened. On a file system without locks there is none, and held() is false.
  std::optional<Error> acquire(const std::filesystem::path& file, const std::string& name);
  bool held() const { return held_; }

  SaveLock() = default;
  ~SaveLock();
  SaveLock(const SaveLock&) = delete;
  SaveLock& operator=(const SaveLock&) = delete;

 private:
  bool is_still_there() const;

  std::filesystem::path path_;
  Descriptor opened_;
  bool held_ = false;
};

}  // namespace tress
