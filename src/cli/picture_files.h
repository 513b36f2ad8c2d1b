// Writes a picture's description into its header, and finds other places for files that cannot be written.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "cli/render_identity.h"
#include "cli/render_settings.h"
#include "image/picture.h"

namespace tress::cli {

/// Writes into the header what was requested, and the values that the render used for it.
void describe_request(const RenderSettings& settings, const scene::Scene& scene, const Identity& identity,
                      image::Picture* picture);

/// Keeps only the requested layers.
void keep_asked_layers(const RenderSettings& settings, image::Picture* picture);

/// The files of one render. Files that cannot be written are reported.
class PictureFiles {
 public:
  using Write = std::function<std::optional<Error>(const std::filesystem::path&)>;

  /// Writes to `file`, or, with a message, to one of the other places. Returns the place; empty if all fail.
  std::optional<std::filesystem::path> write(const std::filesystem::path& file, const Write& to);
  /// Logs the error, if there is one, and sets failed().
  void check(const std::optional<Error>& error);
  /// Whether a file could not be written to its own place.
  bool failed() const { return failed_; }

 private:
  bool failed_ = false;
};

}  // namespace tress::cli
