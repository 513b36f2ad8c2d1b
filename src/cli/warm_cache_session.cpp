#include "cli/warm_cache_session.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "cli/console.h"
#include "tress/adaptive/cache.h"

namespace tress::cli {
namespace {

/// Holds an advisory lock on the folder of a file, so that two sessions do not both read, merge and replace it.
/// The folder, because the file itself is replaced by each save. Where the file system has no locks (some network
/// ones) there is none: a save is then still whole, but may miss what another session saves at the same moment.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& file) {
    const std::filesystem::path parent = file.parent_path();
    descriptor_ = ::open(parent.empty() ? "." : parent.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor_ < 0) return;
    while (flock(descriptor_, LOCK_EX) != 0 && errno == EINTR) {
    }
  }
  ~FolderLock() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_ = -1;
};

struct RowCounts {
  std::uint64_t rows = 0, converged = 0;
};

RowCounts count_rows(const adaptive::TableImage& image) {
  RowCounts counts;
  for (const adaptive::CachedPage& page : image.pages) {
    counts.rows += page.rows.size();
    for (const adaptive::CachedRow& row : page.rows) counts.converged += row.state == adaptive::RowState::converged;
  }
  return counts;
}

bool is_there(const std::filesystem::path& file) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  return status.type() != std::filesystem::file_type::not_found;
}

}  // namespace

const char* cache_mode_name(CacheMode mode) {
  switch (mode) {
    case CacheMode::append:
      return "append";
    case CacheMode::frozen:
      return "frozen";
    case CacheMode::scratch:
      return "scratch";
    case CacheMode::require:
      return "require";
  }
  return "append";
}

WarmCacheSession::WarmCacheSession(std::filesystem::path file, CacheMode mode, std::string model)
    : file_(std::move(file)), mode_(mode), model_(std::move(model)), last_save_(std::chrono::steady_clock::now()) {}

void WarmCacheSession::refuse(const std::string& reason) {
  loaded_ = "refused";
  saved_ = "refused";
  reason_ = reason;
}

std::optional<Error> WarmCacheSession::open(adaptive::Service& service) {
  last_save_ = std::chrono::steady_clock::now();
  if (mode_ == CacheMode::frozen) saved_ = "frozen";
  if (mode_ == CacheMode::scratch) {
    said(fmt::format("warm cache {}: scratch, starting cold; the file is replaced at the end", file_.string()));
    return std::nullopt;
  }
  if (!is_there(file_)) {
    loaded_ = "absent";
    const Error error{file_.string(), "", "a warm cache", "no such file"};
    if (mode_ == CacheMode::require) return error;
    said(fmt::format("warm cache {}: not there yet, starting cold", file_.string()));
    return std::nullopt;
  }
  Result<adaptive::TableImage> image = adaptive::load_cache(file_, model_);
  std::optional<Error> error;
  RowCounts counts;
  if (image) {
    counts = count_rows(*image);
    error = service.load(std::move(*image));
    if (error && error->file.empty()) error->file = file_.string();
  } else {
    error = image.error();
  }
  if (error) {
    refuse(error->message());
    if (mode_ == CacheMode::require) return error;
    said(fmt::format("warm cache {}: refused, starting cold, the file is left as it is: {}", file_.string(),
                     error->message()));
    return std::nullopt;
  }
  loaded_ = "loaded";
  rows_loaded_ = counts.rows;
  said(fmt::format("warm cache {}: loaded {} rows, {} of them converged ({})", file_.string(), counts.rows,
                   counts.converged, cache_mode_name(mode_)));
  return std::nullopt;
}

void WarmCacheSession::save_if_due(const adaptive::Service& service) {
  // Scratch replaces the file at the end only.
  if (mode_ == CacheMode::scratch || std::chrono::steady_clock::now() - last_save_ < save_interval) return;
  if (const std::optional<Error> error = save(service)) warn(error->message());
}

std::optional<Error> WarmCacheSession::save(const adaptive::Service& service) {
  if (mode_ == CacheMode::frozen || loaded_ == "refused") return std::nullopt;
  const std::optional<Error> error = save_now(service);
  last_save_ = std::chrono::steady_clock::now();
  if (error) {
    saved_ = "failed";
    reason_ = error->message();
  }
  return error;
}

std::optional<Error> WarmCacheSession::save_now(const adaptive::Service& service) {
  adaptive::TableImage image = service.snapshot();
  const FolderLock lock(file_);
  bool merged = false;
  if (mode_ != CacheMode::scratch && is_there(file_)) {
    const Result<adaptive::TableImage> on_disk = adaptive::load_cache(file_, model_);
    if (!on_disk) {
      saved_ = "refused";
      reason_ = on_disk.error().message();
      said(fmt::format("warm cache {}: not saved, the file is now refused and left as it is: {}", file_.string(),
                       reason_));
      return std::nullopt;
    }
    image = adaptive::merge_caches(image, *on_disk);
    merged = true;
  }
  if (std::optional<Error> error = adaptive::save_cache(file_, image)) return error;
  const RowCounts counts = count_rows(image);
  rows_saved_ = counts.rows;
  saved_ = merged ? "merged" : "saved";
  said(fmt::format("warm cache {}: {} {} rows, {} of them converged", file_.string(),
                   merged ? "merged and saved" : "saved", counts.rows, counts.converged));
  return std::nullopt;
}

}  // namespace tress::cli
