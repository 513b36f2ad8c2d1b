// One render's dealings with its checkpoint: a killed render goes on from it, to the same bytes (CHECKPOINT.md).
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

/// What a checkpoint, or a part of a picture, holds beside the sums.
struct SavedRender {
  integrate::RenderState render;
  Identity identity;
  nlohmann::json progress;           ///< an object; what the render tells of itself
  std::optional<std::string> table;  ///< Service::state()
};

/// Reads a checkpoint or part. Error if it is not one, or of another render than `own`, unless that is null: what
/// differs by name. ignored: as differences().
Result<SavedRender> read_saved_render(const std::filesystem::path& file, const Identity* own,
                                      const std::vector<std::string>& ignored = {});

/// One thread, between passes.
class CheckpointSession {
 public:
  using Clock = std::chrono::steady_clock;
  /// A save waits until the time since the last one is this many times what that one took: the share that saving may
  /// cost. The first waits for the interval alone.
  static constexpr int share = 100;

  CheckpointSession(std::filesystem::path file, double interval_seconds, Identity identity);

  /// What is there to go on from; unset if there is no file. Error if the file is there and cannot be used: it is left
  /// as it is.
  Result<std::optional<SavedRender>> open() const;
  bool is_due() const;
  /// Writes the file; where it cannot be written the old file stays and the next save tries again. That is a warning,
  /// once until one is written. service: null without rows. True if it was written.
  bool save(const integrate::PassProgress& pass, const adaptive::Service* service, const nlohmann::json& progress);
  /// What a save, with what else is written beside it, has taken: the next one waits the longer.
  void spent(Clock::duration time) { spent_seconds_ = std::chrono::duration<double>(time).count(); }
  /// The render is done.
  void remove() const;

  const std::filesystem::path& file() const { return file_; }
  const Identity& identity() const { return identity_; }

 private:
  std::filesystem::path file_;
  double interval_seconds_;
  Identity identity_;
  Clock::time_point last_;
  double spent_seconds_ = 0;  ///< by the last save
  bool fails_ = false;        ///< the last save
};

/// The sections that a checkpoint and a part have in common.
std::optional<Error> write_saved_render(const std::filesystem::path& file, const Identity& identity,
                                        const nlohmann::json& progress, const integrate::PassProgress& pass,
                                        const std::string* table);

}  // namespace tress::cli
