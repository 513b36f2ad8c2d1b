#include "cli/live_view.h"

#include <fmt/format.h>
#include <unistd.h>

#include <fstream>
#include <utility>

#include "cli/console.h"
#include "cli/live_look.h"
#include "cli/live_table.h"
#include "cli/picture_files.h"
#include "models/catalog.h"

namespace tress::cli {
namespace {

using Json = live::RenderServer::Json;
using Clock = live::TimeShare::Clock;
using namespace std::chrono_literals;

/// The resident memory of this process; 0 if the system does not report it.
double process_bytes() {
  std::ifstream stream("/proc/self/statm");
  double total = 0, resident = 0;
  stream >> total >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

Json pass_json(const integrate::PassProgress& pass) {
  const adaptive::PassReport& table = pass.table;
  const image::Window& window = pass.film->window();
  return {{"pass", pass.pass},
          {"samples", pass.paths_so_far},
          {"pixels", pass.pixels},
          {"image_pixels", double(window.width) * window.height},
          {"seconds", pass.seconds},
          {"cpu_seconds", pass.cpu_seconds},
          {"noise", pass.noise},
          {"converged_query_share", table.queries > 0 ? double(table.converged_queries) / double(table.queries) : 0},
          {"answered_query_share", table.queries > 0 ? double(table.answered_queries) / double(table.queries) : 0},
          {"coarse", table.rows_coarse},
          {"g_evaluations", table.g_evaluations},
          {"learning_cpu_seconds", table.learning_cpu_seconds},
          {"converged", table.rows_converged},
          {"open", table.rows_open},
          {"refused", table.rows_refused},
          {"p50", table.objective_p50},
          {"p99", table.objective_p99},
          {"bias_bound", table.bias_bound},
          {"bytes", table.bytes},
          {"process_bytes", process_bytes()}};
}

}  // namespace

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
  if (settings.serve) {
    auto page = live::RenderServer::start(*settings.serve);
    if (!page) return page.error();
    view->page_ = std::move(*page);
    if (settings.serve_reference) {
      auto picture = image::read_exr(*settings.serve_reference);
      if (!picture) return picture.error();
      view->page_->set_reference(std::make_shared<const image::Picture>(std::move(*picture)));
    }
    log_note(fmt::format("live page: {}", view->page_->url()));
  }
  return view;
}

void LiveView::begin(const scene::Scene& scene, const char* estimator, const adaptive::Service* service) {
  service_ = service;
  passes_shown_ = 0;
  if (!page_) return;
  page_->set_facts({{"facts",
                     {{"scene", scene.source},
                      {"output", settings_.output.string()},
                      {"model", settings_.model},
                      {"estimator", estimator},
                      {"epsilon", fiber::find_model(settings_.model)->epsilon(settings_.table)},
                      {"view", image::view_names()[static_cast<std::size_t>(scene.image.view)]},
                      {"exposure", scene.image.exposure_stops}}}});
}

void LiveView::offer(std::vector<live::RenderServer::Slider> sliders, const Json& color) {
  if (page_) page_->offer(std::move(sliders), color, fault_of_color);
}

live::RenderServer::Look LiveView::take_look() {
  service_ = nullptr;
  at_once_ = pictures_at_once;
  tables_ = live::TimeShare(table_share);
  return page_->take_look();
}

void LiveView::refuse_look(const std::string& message) {
  log_warning(message);
  page_->set_facts({{"said", message}});
}

void LiveView::leave_look(image::Picture picture, int passes) {
  if (passes <= passes_shown_) return;
  keep_asked_layers(settings_, &picture);
  page_->show(std::make_shared<const image::Picture>(std::move(picture)));
}

void LiveView::show_picture(const integrate::PassProgress& pass) {
  const auto start = Clock::now();
  passes_shown_ = pass.pass + 1;
  image::Picture picture = pass.film->picture();
  keep_asked_layers(settings_, &picture);
  const auto shared = std::make_shared<const image::Picture>(std::move(picture));
  if (display_) display_->show(shared);
  if (page_) page_->show(shared);
  if (at_once_ > 0)
    --at_once_;
  else
    copies_.spent(Clock::now() - start);
}

/// Shows the picture as it is to a user who pauses. The render waits then, so this costs it no time.
void LiveView::show_paused_picture(const integrate::PassProgress& pass) {
  if (passes_shown_ == pass.pass + 1) return;
  ++at_once_;
  show_picture(pass);
}

void LiveView::update_page(const integrate::PassProgress& pass, const Outlook& ahead) {
  page_->set_facts(
      {{"progress",
        {{"share", ahead.share}, {"seconds_left", ahead.seconds_left ? Json(*ahead.seconds_left) : Json()}}}});
  page_->add_pass(pass_json(pass));
  if (service_ == nullptr || !page_->is_watched() || !tables_.is_due()) return;
  const auto start = Clock::now();
  page_->set_table(table_json(*service_));
  tables_.spent(Clock::now() - start);
}

void LiveView::serve_requests(const std::function<void()>& save) {
  const live::RenderServer::Asked asked = page_->take_asked();
  if (asked.save) {
    save();
    page_->set_facts({{"said", "saved"}});
  }
  for (const live::RenderServer::RowAsked& row : asked.rows)
    page_->answer_row(row.request,
                      service_ != nullptr ? row_json(*service_, row.slice, row.node) : Json{{"words", "no table"}});
}

bool LiveView::after_pass(const integrate::PassProgress& pass, const Outlook& ahead,
                          const std::atomic<bool>& interrupted, const std::function<void()>& save) {
  const bool is_wanted = (display_ && display_->wants_picture()) || (page_ && page_->is_watched());
  if (is_wanted && (at_once_ > 0 || copies_.is_due())) show_picture(pass);
  if (!page_) return true;
  update_page(pass, ahead);
  serve_requests(save);
  while (page_->is_paused() && !interrupted && !page_->is_look_asked()) {
    show_paused_picture(pass);
    page_->wait_for_request(100ms);
    serve_requests(save);
  }
  return !page_->is_stopped() && !page_->is_look_asked();
}

void LiveView::finish(image::Picture picture) {
  if (!display_ && !page_) return;
  keep_asked_layers(settings_, &picture);
  image::round_as_written(&picture, settings_.precision);
  const auto shared = std::make_shared<const image::Picture>(std::move(picture));
  if (page_) {
    page_->set_facts({{"progress", {{"share", 1}, {"seconds_left", 0}}}, {"said", "done"}});
    page_->show(shared);
    page_->wait_until_seen(2s);
  }
  if (display_ && !display_->finish(shared))
    log_note(fmt::format("--display-server {}: no viewer there that took the picture", *settings_.display_server));
}

}  // namespace tress::cli
