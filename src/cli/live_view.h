// The viewers of a running render: an observer of its passes.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/progress.h"
#include "cli/render_settings.h"
#include "integrate/renderer.h"
#include "live/display_client.h"
#include "live/render_server.h"

namespace tress::cli {

/// Viewers and the live page. Does nothing without a viewer. One thread at a time.
class LiveView {
 public:
  /// Error if the viewer's host is unknown, the page cannot be served, or its reference picture cannot be read. If the
  /// viewer is not running yet, the render goes on and tries to connect again.
  static Result<std::unique_ptr<LiveView>> open(const RenderSettings& settings);

  /// Call it before the first pass. service: null without rows; it must outlive the render.
  void begin(const scene::Scene& scene, const char* estimator, const adaptive::Service* service);
  /// Sets what the page may change. Call it once, before the first begin().
  void offer(std::vector<live::RenderServer::Slider> sliders, const live::RenderServer::Json& color);
  /// Whether the page has requested another look. Any thread.
  bool is_look_asked() const { return page_ != nullptr && page_->is_look_asked(); }
  /// Shows the picture of the look that ends, after `passes` passes, if the page has only an older one. Otherwise the
  /// page would compare the next look with that one.
  void leave_look(image::Picture picture, int passes);
  /// Returns the requested look; begin() must follow, with the service of that time.
  live::RenderServer::Look take_look();
  /// Reports to the page why the scene cannot have the look that it requested.
  void refuse_look(const std::string& message);

  /// Shows the pass. Also shows the picture so far, if a viewer has received the last one and the share of time allows
  /// it, or if the page has paused the render. During a pause it waits unless `interrupted`. save: writes the picture
  /// so far. Returns false if the page requests a stop or another look.
  bool after_pass(const integrate::PassProgress& pass, const Outlook& ahead, const std::atomic<bool>& interrupted,
                  const std::function<void()>& save);
  /// Shows the final picture; waits until it has arrived, or until the viewer has taken nothing for a while.
  void finish(image::Picture picture);

 private:
  explicit LiveView(const RenderSettings& settings) : settings_(settings) {}
  void show_picture(const integrate::PassProgress& pass);
  void show_paused_picture(const integrate::PassProgress& pass);
  void update_page(const integrate::PassProgress& pass, const Outlook& ahead);
  void serve_requests(const std::function<void()>& save);

  /// Shares of the render's time for copies of the picture and of the table, for which its threads wait. The threads of
  /// viewers and pages may use as much again.
  static constexpr double copying_share = 0.004, table_share = 0.001;

  /// Number of pictures that are shown at once after a change of the look, in addition to that share, until there are
  /// some samples per pixel.
  static constexpr int pictures_at_once = 6;

  const RenderSettings& settings_;
  const adaptive::Service* service_ = nullptr;
  std::unique_ptr<live::RenderServer> page_;
  std::optional<live::DisplayClient> display_;
  int at_once_ = 0;       ///< number of pictures that may still be shown at once
  int passes_shown_ = 0;  ///< number of passes in the last picture shown, in this look
  live::TimeShare copies_{copying_share}, tables_{table_share};
};

}  // namespace tress::cli
