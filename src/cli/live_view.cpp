#include "cli/live_view.h"

#include <fmt/format.h>

#include "cli/console.h"

namespace tress::cli {

Result<std::unique_ptr<LiveView>> LiveView::open(const RenderSettings& settings) {
  std::unique_ptr<LiveView> view(new LiveView(settings));
  if (settings.display_server) {
    auto viewer = live::find_endpoint(*settings.display_server);
    if (!viewer) {
      Error error = viewer.error();
      error.place = "--display-server";
      return error;
    }
    view->display_.emplace(std::move(*viewer), settings.output.string());
  }
  return view;
}

void LiveView::after_pass(const integrate::PassProgress& pass) {
  if (!display_ || !display_->wants_picture() || !copies_.is_due()) return;
  const auto start = live::TimeShare::Clock::now();
  image::Picture picture = pass.film->picture();
  if (settings_.layers) image::keep_layers(*settings_.layers, &picture);
  display_->show(std::make_shared<const image::Picture>(std::move(picture)));
  copies_.spent(live::TimeShare::Clock::now() - start);
}

void LiveView::finish(image::Picture picture) {
  if (!display_) return;
  if (settings_.layers) image::keep_layers(*settings_.layers, &picture);
  image::round_as_written(&picture, settings_.precision);
  if (!display_->finish(std::make_shared<const image::Picture>(std::move(picture))))
    log_note(fmt::format("--display-server {}: no viewer there that took the picture", *settings_.display_server));
}

}  // namespace tress::cli
