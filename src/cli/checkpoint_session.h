// The checkpoint of one render: a killed render continues from it, to the same bytes (CHECKPOINT.md).
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "cli/render_identity.h"
#include "integrate/renderer.h"
#include "tress/adaptive/service.h"

namespace tress::cli {

/// The data of a checkpoint, or of a part of a picture, besides the sums.
struct SavedRender {
  integrate::RenderState render;
  Identity identity;
  nlohmann::json progress;           ///< an object with the render's own progress
  std::optional<std::string> table;  ///< Service::state()
};

/// Reads a checkpoint or part. Error if the file is another kind, or belongs to a render that differs from `own`
/// (unless that is null); the error names what differs. ignored: as in differences().
Result<SavedRender> read_saved_render(const std::filesystem::path& file, const Identity* own,
                                      const std::vector<std::string>& ignored = {});

/// Use it from one thread, between passes.
class CheckpointSession {
 public:
  using Clock = std::chrono::steady_clock;
  /// After a save, the next one waits at least this many times as long as the save took, which limits the cost of
  /// saving. The first save waits for the interval alone.
  static constexpr int share = 100;

  CheckpointSession(std::filesystem::path file, double interval_seconds, Identity identity);

  /// Reads the checkpoint to continue from; empty if there is no file. Error if the file exists and cannot be used; it
  /// is left unchanged.
  Result<std::optional<SavedRender>> open() const;
  bool is_due() const;
  /// Writes the file. If that fails the old file stays, a warning is logged once until a save succeeds, and the next
  /// save tries again. service: null without rows. True if it was written.
  bool save(const integrate::PassProgress& pass, const adaptive::Service* service, const nlohmann::json& progress);
  /// Sets the duration of the last save, with all files that were written beside it; the next save waits accordingly.
  void spent(Clock::duration time) { spent_seconds_ = std::chrono::duration<double>(time).count(); }
  /// Removes the file, because the render is done.
  void remove() const;

  const std::filesystem::path& file() const { return file_; }
  const Identity& identity() const { return identity_; }

 private:
  std::filesystem::path file_;
  double interval_seconds_;
  Identity identity_;
  Clock::time_point last_;
  double spent_seconds_ = 0;  ///< duration of the last save
  bool fails_ = false;        ///< whether the last save failed
};

/// Writes the sections that a checkpoint and a part have in common.
std::optional<Error> write_saved_render(const std::filesystem::path& file, const Identity& identity,
                                        const nlohmann::json& progress, const integrate::PassProgress& pass,
                                        const std::string* table);

}  // namespace tress::cli
