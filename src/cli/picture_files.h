// What a picture says of itself in its header, and where its files go when they cannot go where they should.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "cli/render_identity.h"
#include "cli/render_settings.h"
#include "image/picture.h"

namespace tress::cli {

/// Into the header: what was asked for, and what was rendered with it.
void describe_request(const RenderSettings& settings, const scene::Scene& scene, const Identity& identity,
                      image::Picture* picture);

/// Leaves the layers that were asked for.
void keep_asked_layers(const RenderSettings& settings, image::Picture* picture);

/// The files of one render. What cannot be written is told.
class PictureFiles {
 public:
  using Write = std::function<std::optional<Error>(const std::filesystem::path&)>;

  /// Where it is written: to `file`, or, told, to one of the other places; unset: nowhere.
  std::optional<std::filesystem::path> write(const std::filesystem::path& file, const Write& to);
  /// An error of a file that has no other place.
  void tell(const std::optional<Error>& error);
  /// Whether a file is not where it should be.
  bool failed() const { return failed_; }

 private:
  bool failed_ = false;
};

}  // namespace tress::cli
