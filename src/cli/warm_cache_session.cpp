#include "cli/warm_cache_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <system_error>
#include <utility>
#include <vector>

#include "cli/console.h"
#include "cli/output_files.h"
#include "tress/adaptive/cache.h"

namespace tress::cli {
namespace {

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

std::optional<Error> check_default_cache() {
  const Result<std::filesystem::path> folder = adaptive::default_cache_folder();
  if (!folder) return folder.error();
  return adaptive::CacheFolder(*folder).check();
}

WarmCacheSession::WarmCacheSession(std::filesystem::path file, CacheMode mode, std::string model,
                                   Clock::duration interval)
    : file_(std::move(file)), mode_(mode), model_(std::move(model)), interval_(interval), last_save_(Clock::now()) {
  if (!is_default_cache(file_)) return;
  if (const auto folder = adaptive::default_cache_folder()) folder_.emplace(file_ = *folder);
}

void WarmCacheSession::refuse(const std::string& reason) {
  loaded_ = "refused";
  saved_ = "refused";
  reason_ = reason;
}

std::optional<Error> WarmCacheSession::open(adaptive::Service& service) {
  last_save_ = Clock::now();
  if (mode_ == CacheMode::frozen) saved_ = "frozen";
  if (mode_ == CacheMode::scratch) {
    log_note(fmt::format("warm cache {}: scratch, starting cold; the file is replaced at the end", file_.string()));
    return std::nullopt;
  }
  if (folder_) return open_folder(service);
  if (!is_there(file_)) {
    loaded_ = "absent";
    const Error error{file_.string(), "", "a warm cache", "no such file"};
    if (mode_ == CacheMode::require) return error;
    log_note(fmt::format("warm cache {}: not there yet, starting cold", file_.string()));
    return std::nullopt;
  }
  const Result<std::unique_ptr<adaptive::CacheFile>> cache = adaptive::CacheFile::open(file_, model_);
  std::optional<Error> error;
  adaptive::CacheContents contents;
  if (cache) {
    contents = (*cache)->contents();
    error = service.load(**cache);
    if (error && error->file.empty()) error->file = file_.string();
  } else {
    error = cache.error();
  }
  if (error) {
    refuse(error->message());
    if (mode_ == CacheMode::require) return error;
    log_warning(fmt::format("warm cache {}: refused, starting cold, the file is left as it is: {}", file_.string(),
                            error->message()));
    return std::nullopt;
  }
  loaded_ = "loaded";
  log_left_out(file_, contents);
  expects_file_ = true;
  rows_loaded_ = contents.rows();
  count_known(service);
  log_note(fmt::format("warm cache {}: loaded {} rows, {} of them converged ({})", file_.string(), contents.rows(),
                       contents.converged_rows, cache_mode_name(mode_)));
  return std::nullopt;
}

std::optional<Error> WarmCacheSession::open_folder(adaptive::Service& service) {
  const adaptive::CacheFolder::Loaded found = folder_->load(service);
  for (const Error& refused : found.refused) {
    if (mode_ == CacheMode::require) {
      refuse(refused.message());
      return refused;
    }
    log_warning(fmt::format("warm cache {}: a file is refused, left as it is and not saved into: {}", file_.string(),
                            refused.message()));
  }
  if (found.files == 0) {
    loaded_ = "absent";
    if (mode_ == CacheMode::require)
      return Error{file_.string(), "", "what was learned of a fiber of this scene", "none"};
    log_note(fmt::format("warm cache {}: has no fiber of this scene yet, starting cold", file_.string()));
    return std::nullopt;
  }
  loaded_ = "loaded";
  log_left_out(file_, found.contents);
  rows_loaded_ = found.contents.rows();
  count_known(service);
  log_note(fmt::format("warm cache {}: loaded {} rows, {} of them converged, from {} of {} pages ({})", file_.string(),
                       found.contents.rows(), found.contents.converged_rows, found.files, service.slice_count(),
                       cache_mode_name(mode_)));
  return std::nullopt;
}

std::optional<Error> WarmCacheSession::save_folder(const adaptive::Service& service) {
  if (std::optional<Error> error = folder_->check()) return error;
  const auto saved = folder_->save(service, mode_ == CacheMode::scratch);
  if (!saved) return saved.error();
  log_removed(file_, saved->removed);
  for (const Error& refused : saved->refused)
    log_warning(fmt::format("warm cache {}: not saved into a file that is refused and left as it is: {}",
                            file_.string(), refused.message()));
  log_saved(mode_ == CacheMode::scratch ? "saved" : "merged",
            mode_ == CacheMode::scratch ? "saved" : "merged and saved", saved->contents);
  const auto pruned = folder_->prune(limit_);
  if (!pruned) return pruned.error();
  if (!pruned->removed.empty())
    log_note(
        fmt::format("warm cache {}: removed {} files that were used longest ago, {:.4g} MB are left (--cache-limit)",
                    file_.string(), pruned->removed.size(), double(pruned->bytes_left) / double(1 << 20)));
  return std::nullopt;
}

void WarmCacheSession::count_known(const adaptive::Service& service) {
  std::vector<adaptive::SliceKey> asked;
  for (adaptive::SliceId id = 0; id < service.slice_count(); ++id) asked.push_back(service.slice(id).key);
  const std::unique_ptr<adaptive::RowSource> rows = service.rows();
  while (const adaptive::SliceDescription* slice = rows->next_slice()) {
    if (std::ranges::find(asked, slice->key) == asked.end()) continue;
    while (const adaptive::CachedRow* row = rows->next_row()) {
      if (row->state != adaptive::RowState::converged) continue;
      ++rows_known_;
      samples_known_ += row->count;
    }
  }
}

std::optional<Error> WarmCacheSession::take(adaptive::Service& service, adaptive::RowSource& rows) {
  if (std::optional<Error> error = service.load(rows)) return error;
  loaded_ = "loaded";
  expects_file_ = true;
  rows.rewind();
  while (rows.next_slice() != nullptr) {
    while (rows.next_row() != nullptr) ++rows_loaded_;
  }
  count_known(service);
  log_note(fmt::format("warm cache {}: carried {} rows from the frame before", file_.string(), rows_loaded_));
  return std::nullopt;
}

void WarmCacheSession::resume(const nlohmann::json& progress) {
  const auto number = [&](const char* name) {
    return progress.contains(name) && progress[name].is_number() ? progress[name].get<double>() : 0.0;
  };
  const auto whole = [&](const char* name) { return static_cast<std::uint64_t>(std::clamp(number(name), 0.0, 1e15)); };
  if (progress.contains("cache_loaded") && progress["cache_loaded"].is_string())
    loaded_ = progress["cache_loaded"].get<std::string>();
  rows_loaded_ = whole("cache_rows");
  rows_known_ = whole("cache_rows_known");
  samples_known_ = whole("cache_samples_known");
  learning_cpu_seconds_ = std::clamp(number("learning_cpu_seconds"), 0.0, 1e9);
  g_evaluations_ = whole("g_evaluations");
  expects_file_ = loaded_ == "loaded";
}

nlohmann::json WarmCacheSession::progress() const {
  return {{"cache_loaded", loaded_},
          {"cache_rows", rows_loaded_},
          {"cache_rows_known", rows_known_},
          {"cache_samples_known", samples_known_},
          {"learning_cpu_seconds", learning_cpu_seconds_},
          {"g_evaluations", g_evaluations_}};
}

void WarmCacheSession::add_cost(const adaptive::PassReport& pass) {
  learning_cpu_seconds_ += pass.learning_cpu_seconds;
  g_evaluations_ += pass.g_evaluations;
}

std::optional<double> WarmCacheSession::cpu_seconds_spared() const {
  constexpr std::uint64_t enough = 10000;
  if (g_evaluations_ < enough) return std::nullopt;
  return learning_cpu_seconds_ / static_cast<double>(g_evaluations_) * static_cast<double>(samples_known_);
}

void WarmCacheSession::log_savings() const {
  if (rows_known_ == 0) return;
  const std::optional<double> seconds = cpu_seconds_spared();
  log_note(fmt::format(
      "warm cache {}: {} rows had been learned before, from {} samples{}", file_.string(), rows_known_, samples_known_,
      seconds ? fmt::format("; estimated by the rows learned now, that is {:.2g} s of CPU", *seconds) : std::string()));
}

nlohmann::ordered_json WarmCacheSession::telemetry() const {
  nlohmann::ordered_json fields{{"loaded", loaded_}, {"rows_loaded", rows_loaded_}};
  if (rows_known_ > 0) {
    fields["rows_known"] = rows_known_;
    fields["samples_known"] = samples_known_;
    if (const std::optional<double> seconds = cpu_seconds_spared()) fields["cpu_seconds_spared_estimate"] = *seconds;
  }
  fields["saved"] = saved_;
  fields["rows_saved"] = rows_saved_;
  if (!reason_.empty()) fields["reason"] = reason_;
  return fields;
}

void WarmCacheSession::save_if_due(const adaptive::Service& service) {
  // With scratch, the file is replaced at the end only.
  if (mode_ == CacheMode::scratch || Clock::now() - last_save_ < interval_) return;
  if (const std::optional<Error> error = save(service)) log_warning(error->message());
}

std::optional<Error> WarmCacheSession::save(const adaptive::Service& service) {
  if (mode_ == CacheMode::frozen || loaded_ == "refused") return std::nullopt;
  const std::optional<Error> error = folder_                       ? save_folder(service)
                                     : mode_ == CacheMode::scratch ? replace(service)
                                                                   : merge(service);
  last_save_ = Clock::now();
  if (error) {
    saved_ = "failed";
    reason_ = error->message();
  }
  return error;
}

std::optional<Error> WarmCacheSession::replace(const adaptive::Service& service) {
  const Result<adaptive::CacheSave> save = adaptive::replace_cache(file_, *service.rows());
  if (!save) return save.error();
  log_removed(file_, save->removed);
  log_saved("saved", "saved", save->contents);
  return std::nullopt;
}

std::optional<Error> WarmCacheSession::merge(const adaptive::Service& service) {
  const Result<adaptive::CacheUpdate> update = adaptive::merge_into_cache(file_, *service.rows());
  if (!update) return update.error();
  log_removed(file_, update->removed);
  switch (update->outcome) {
    case adaptive::CacheUpdate::Outcome::refused:
      saved_ = "refused";
      reason_ = update->refusal->message();
      log_warning(fmt::format("warm cache {}: not saved, the file is now refused and left as it is: {}", file_.string(),
                              reason_));
      break;
    case adaptive::CacheUpdate::Outcome::merged:
      log_saved("merged", "merged and saved", update->contents);
      break;
    case adaptive::CacheUpdate::Outcome::created:
      log_saved("saved", expects_file_ ? "the file had gone, saved anew," : "saved", update->contents);
      break;
  }
  return std::nullopt;
}

void WarmCacheSession::log_saved(const char* outcome, const char* words, const adaptive::CacheContents& contents) {
  rows_saved_ = contents.rows();
  saved_ = outcome;
  reason_.clear();
  expects_file_ = true;
  log_note(fmt::format("warm cache {}: {} {} rows, {} of them converged", file_.string(), words, contents.rows(),
                       contents.converged_rows));
}

}  // namespace tress::cli
