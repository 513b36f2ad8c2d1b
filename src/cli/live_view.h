// What watches a render while it runs: an observer of its passes.
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

/// Viewers and the live page. Nothing if nobody watches. One thread at a time.
class LiveView {
 public:
  /// Error if the viewer's host is unknown, the page cannot be served, or its reference picture cannot be read. A
  /// viewer that is not there is looked for while the render runs.
  static Result<std::unique_ptr<LiveView>> open(const RenderSettings& settings);

  /// Before the first pass. service: null: no rows are asked; outlives the render.
  void begin(const scene::Scene& scene, const char* estimator, const adaptive::Service* service);
  /// Once, before the first begin(): what the page may change.
  void offer_sliders(std::vector<live::RenderServer::Slider> sliders);
  /// Whether the page has asked for another look. Any thread.
  bool is_look_asked() const { return page_ != nullptr && page_->is_look_asked(); }
  /// The picture of the look that ends, of so many passes: shown if the page has an older one, which would else be what
  /// the next look is held against.
  void leave_look(image::Picture picture, int passes);
  /// Which one; begin() must follow, with the service that there is then.
  live::RenderServer::Look take_look();
  /// Tells the page why the scene cannot have the look that it asked for.
  void refuse_look(const std::string& message);

  /// Shows the pass, and the picture so far if somebody has seen the last one and the time for it is there, or the page
  /// has paused the render; stays as long as it has and nobody has `interrupted` it. save: writes the picture so far.
  /// False: the page asked to stop, or for another look.
  bool after_pass(const integrate::PassProgress& pass, const Outlook& ahead, const std::atomic<bool>& interrupted,
                  const std::function<void()>& save);
  /// Shows the picture as it is in its file; waits until it is there, or the viewer has taken nothing for a while.
  void finish(image::Picture picture);

 private:
  explicit LiveView(const RenderSettings& settings) : settings_(settings) {}
  void show_picture(const integrate::PassProgress& pass);
  void show_paused_picture(const integrate::PassProgress& pass);
  void tell_page(const integrate::PassProgress& pass, const Outlook& ahead);
  void serve_requests(const std::function<void()>& save);

  /// Of the render's time each, for copies of the picture and the table that its threads wait for. The threads of
  /// viewers and pages have as much.
  static constexpr double copying_share = 0.004, table_share = 0.001;

  /// Pictures after a change of the look that are shown at once, beside that share: until some samples a pixel are
  /// there.
  static constexpr int pictures_at_once = 6;

  const RenderSettings& settings_;
  const adaptive::Service* service_ = nullptr;
  std::unique_ptr<live::RenderServer> page_;
  std::optional<live::DisplayClient> display_;
  int at_once_ = 0;       ///< pictures that are still shown at once
  int passes_shown_ = 0;  ///< of the picture that was shown last, in this look
  live::TimeShare copies_{copying_share}, tables_{table_share};
};

}  // namespace tress::cli
