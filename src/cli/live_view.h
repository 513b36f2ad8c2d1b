// What watches a render while it runs: an observer of its passes.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/render_settings.h"
#include "integrate/renderer.h"
#include "live/display_client.h"

namespace tress::cli {

/// Nothing if nobody watches. One thread at a time.
class LiveView {
 public:
  /// Error if the viewer's host is unknown. One that is not there is looked for while the render runs.
  static Result<std::unique_ptr<LiveView>> open(const RenderSettings& settings);

  /// Shows the picture so far, if a viewer has seen the last one and the time for it is there.
  void after_pass(const integrate::PassProgress& pass);
  /// Shows the picture as it is in its file; waits until it is there, or the viewer has taken nothing for a while.
  void finish(image::Picture picture);

 private:
  explicit LiveView(const RenderSettings& settings) : settings_(settings) {}

  /// Of the render's time, for copies of the picture that its threads wait for. The viewer's own thread has as much.
  static constexpr double copying_share = 0.005;

  const RenderSettings& settings_;
  std::optional<live::DisplayClient> display_;
  live::TimeShare copies_{copying_share};
};

}  // namespace tress::cli
