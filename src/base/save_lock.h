// A lock for one saver at a time of a cache file, among threads, processes and the machines of a shared folder.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "base/descriptor.h"
#include "tress/base/error.h"

namespace tress::inline v0_2 {

/// Holds an exclusive flock on `FILE.lock`, which is made and removed with it. The lock is not on the cache, which each
/// save replaces, and not on its folder, which NFS cannot lock and others lock for reasons of their own. The kernel
/// frees it however a session ends, so the lock file of a killed session does not block others.
class SaveLock {
 public:
  /// `file`: the real one, no link; `name`: its name in errors. Waits while another holds the lock. Error if the lock
  /// file cannot be opened. On a file system without locks it succeeds without one, and held() is false.
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

}  // namespace tress::inline v0_2
