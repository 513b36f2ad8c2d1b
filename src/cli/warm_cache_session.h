// The warm cache file of one render: its four modes, and the messages about them.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "tress/adaptive/cache_folder.h"
#include "tress/adaptive/service.h"

namespace tress::cli {

enum class CacheMode {
  append,   ///< load if there is one, refine, save merged with what is then on disk
  frozen,   ///< load if there is one, never save; use what was loaded without learning
  scratch,  ///< do not load; replace the file at the end without merging
  require,  ///< append, but a missing or refused file is an error before rendering
};
const char* cache_mode_name(CacheMode mode);

/// The name of a warm cache that stands for adaptive::default_cache_folder().
inline constexpr const char* default_cache = "default";
inline bool is_default_cache(const std::filesystem::path& file) { return file == default_cache; }
/// Error if there can be no such folder, or it cannot be written to.
std::optional<Error> check_default_cache();

/// Saves by adaptive::merge_into_cache, so other sessions may save into the file at the same time. Use it from one
/// thread, between passes. Every step logs a note; a refused file, which changes the result, logs a warning.
/// default_cache is a folder with a file for each slice (adaptive::CacheFolder). Its limit is applied after each save.
/// In all modes, the files of the render's slices together stand for the one file. A file that is refused (truncated,
/// corrupted, of another model, of a later format) is never overwritten, except with scratch, whose purpose is to
/// replace it.
class WarmCacheSession {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::minutes save_interval{10};

  WarmCacheSession(std::filesystem::path file, CacheMode mode, std::string model,
                   Clock::duration interval = save_interval);
  /// Sets the limit of default_cache in bytes.
  void set_limit(std::uint64_t bytes) { limit_ = bytes; }

  /// Loads into the service according to the mode, once its slices are known. Error only under `require`.
  std::optional<Error> open(adaptive::Service& service);
  /// Replaces open(): takes the rows of a table of this process, which has read the file. Error if they are refused.
  std::optional<Error> take(adaptive::Service& service, adaptive::RowSource& rows);
  /// Replaces open() if the table comes from a checkpoint: sets the state as after open(). progress: from progress(); a
  /// missing value, or one that is no number, is 0.
  void resume(const nlohmann::json& progress);
  /// The state as an object for the checkpoint.
  nlohmann::json progress() const;
  /// Call it after each pass: adds the cost of learning in this session.
  void add_cost(const adaptive::PassReport& pass);
  /// Saves if the interval has passed since the last time. A failure is a warning; the save at the end tries again.
  void save_if_due(const adaptive::Service& service);
  /// Saves at the end. Error if the file could not be written.
  std::optional<Error> save(const adaptive::Service& service);

  /// The estimated cost of learning the known rows, in seconds of CPU, at the pace of those that this session learned;
  /// empty if it learned too few.
  std::optional<double> cpu_seconds_spared() const;
  /// Logs a note with the number of known rows, if any, and this cost.
  void log_savings() const;
  /// What was loaded and saved, for telemetry, without the file and the mode.
  nlohmann::ordered_json telemetry() const;

  /// What was loaded and saved, and the reason for a refusal or failure.
  const std::string& loaded() const { return loaded_; }  ///< "loaded", "absent", "refused", "not asked"
  const std::string& saved() const { return saved_; }  ///< "saved", "merged", "refused", "frozen", "failed", "not yet"
  const std::string& reason() const { return reason_; }  ///< for a refusal or failure; else empty
  std::uint64_t rows_loaded() const { return rows_loaded_; }
  /// The number of loaded rows that answer by their fit from the first query on, and of the samples (g evaluations, or
  /// paths) from which they were learned.
  std::uint64_t rows_known() const { return rows_known_; }
  std::uint64_t samples_known() const { return samples_known_; }
  std::uint64_t rows_saved() const { return rows_saved_; }
  const std::filesystem::path& file() const { return file_; }
  CacheMode mode() const { return mode_; }

 private:
  std::optional<Error> replace(const adaptive::Service& service);
  std::optional<Error> merge(const adaptive::Service& service);
  void log_saved(const char* outcome, const char* words, const adaptive::CacheContents& contents);
  std::optional<Error> open_folder(adaptive::Service& service);
  std::optional<Error> save_folder(const adaptive::Service& service);
  void count_known(const adaptive::Service& service);
  void refuse(const std::string& reason);

  std::filesystem::path file_;
  std::optional<adaptive::CacheFolder> folder_;  ///< set for default_cache
  std::uint64_t limit_ = std::uint64_t{1} << 30;
  CacheMode mode_;
  std::string model_;
  Clock::duration interval_;
  std::string loaded_ = "not asked", saved_ = "not yet", reason_;
  std::uint64_t rows_loaded_ = 0, rows_saved_ = 0, rows_known_ = 0, samples_known_ = 0;
  double learning_cpu_seconds_ = 0;
  std::uint64_t g_evaluations_ = 0;  ///< number in those seconds
  bool expects_file_ = false;        ///< whether this session has read or made the file
  Clock::time_point last_save_;
};

}  // namespace tress::cli
