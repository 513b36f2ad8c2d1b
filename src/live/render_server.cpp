#include "live/render_server.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <condition_variable>
#include <deque>
#include <limits>
#include <map>
#include <mutex>
#include <ranges>
#include <thread>
#include <utility>

#include "base/cpu_clock.h"
#include "live/bounded_queue.h"
#include "live/time_share.h"
#include "live/web_page.h"

namespace tress::live {
namespace {

using Json = RenderServer::Json;
using Clock = TimeShare::Clock;
using namespace std::chrono_literals;

constexpr std::size_t threads = 3, connections_waiting = 8;
constexpr std::size_t most_rows_asked = 8, most_rows_answered = 16;
constexpr double cpu_share = 0.002;
constexpr auto watched_for = 5s, patience_at_the_end = 3s;
/// Answers may take this much time before the limit applies, for a page that was just opened.
constexpr auto allowance = 60s;

std::optional<std::uint64_t> number_of(const httplib::Request& request, const char* name) {
  const std::string text = request.get_param_value(name);
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Three channels as floats, one after the other; a layer of one channel is repeated three times.
std::optional<std::string> layer_bytes(const image::Picture& picture, const std::string& layer) {
  std::vector<const image::Channel*> found;
  for (const image::Channel& channel : picture.channels) {
    if (image::layer_of(channel.name) == layer && channel.name != "A") found.push_back(&channel);
  }
  if (found.empty()) return std::nullopt;
  std::string bytes;
  for (std::size_t i = 0; i < 3; ++i) {
    const image::Channel& channel = *found[std::min(i, found.size() - 1)];
    bytes.append(reinterpret_cast<const char*>(channel.pixels.data()), sizeof(float) * channel.pixels.size());
  }
  return bytes;
}

Json layers_of(const image::Picture& picture) {
  Json layers = Json::array();
  for (const image::Channel& channel : picture.channels) {
    const std::string layer = image::layer_of(channel.name);
    if (std::find(layers.begin(), layers.end(), layer) == layers.end()) layers.push_back(layer);
  }
  return layers;
}

}  // namespace

struct RenderServer::State {
  struct Shown {
    std::shared_ptr<const image::Picture> picture;
    std::uint64_t version = 0;
  };

  httplib::Server server;
  std::thread listener;
  std::string address;
  int port = 0;
  bool is_loopback = true;

  mutable std::mutex mutex;  ///< guards the members below
  std::condition_variable asked_something;
  Clock::time_point last_asked{};
  Json facts = Json::object();
  std::deque<std::shared_ptr<const Json>> passes;
  std::uint64_t first_pass = 0;
  Shown latest, before, look_before;
  std::shared_ptr<const image::Picture> reference;
  std::shared_ptr<const std::string> table = std::make_shared<const std::string>("{\"slices\":[]}");
  std::uint64_t table_version = 0;
  std::uint64_t fetched = 0;  ///< version of the latest picture that was sent
  Asked asked;
  std::map<std::uint64_t, Json> rows;
  std::uint64_t last_request = 0;
  bool paused = false, stopped = false;
  std::vector<Slider> sliders;
  Json color;
  std::function<std::string(const std::string&)> fault_of_color;
  Look look;
  std::uint64_t looks_asked = 0, looks_taken = 0;
  std::uint64_t first_of_look = 0;  ///< version of the first picture after the last change of the sliders
  std::atomic<bool> is_look_asked{false};
  std::atomic<bool> over{false};
  bool has_ended = false;  ///< whether all threads of the server have ended
  TimeShare time{cpu_share, Clock::now() - allowance};

  /// Whether the Host header names this server, rather than another name that resolves to it (DNS rebinding).
  bool is_own_host(const std::string& host) const {
    const std::string suffix = fmt::format(":{}", port);
    if (!host.ends_with(suffix)) return false;
    const std::string name = host.substr(0, host.size() - suffix.size());
    if (name == address || name == "localhost" || name == "127.0.0.1" || name == "[::1]") return true;
    const bool is_number = std::ranges::all_of(name, [](char c) { return (c >= '0' && c <= '9') || c == '.'; });
    return !is_loopback && is_number;
  }

  bool is_foreign(const httplib::Request& request) const {
    const std::string host = request.get_header_value("Host"), origin = request.get_header_value("Origin");
    if (!is_own_host(host)) return true;
    return !origin.empty() && origin != "http://" + host;
  }

  template <class Answer>
  auto timed(Answer answer) {
    return [this, answer](const httplib::Request& request, httplib::Response& response) {
      const double start = thread_cpu_seconds();
      answer(request, response);
      const std::scoped_lock lock(mutex);
      time.spent(TimeShare::Seconds(thread_cpu_seconds() - start));
    };
  }

  void send_status(const httplib::Request& request, httplib::Response& response) {
    const std::uint64_t since = number_of(request, "since").value_or(0);
    std::vector<std::shared_ptr<const Json>> sent;
    Json status;
    {
      const std::scoped_lock lock(mutex);
      last_asked = Clock::now();
      status = facts;
      const std::uint64_t from = std::clamp(since, first_pass, first_pass + passes.size());
      status["first"] = from;
      for (std::uint64_t i = from; i < first_pass + passes.size(); ++i) sent.push_back(passes[i - first_pass]);
      status["picture"] = latest.version;
      status["before"] = before.version;
      status["reference"] = reference != nullptr;
      if (latest.picture) {
        status["width"] = latest.picture->width;
        status["height"] = latest.picture->height;
        status["layers"] = layers_of(*latest.picture);
      }
      status["table"] = table_version;
      status["paused"] = paused;
      status["stopped"] = stopped;
      status["look"] = looks_taken;
      status["look_asked"] = looks_asked;
      status["first_of_look"] = first_of_look;
      status["look_before"] = look_before.version;
      if (since == 0) {
        status["sliders"] = slider_list();
        status["color"] = color;
      }
    }
    asked_something.notify_all();
    status["passes"] = Json::array();
    for (const auto& pass : sent) status["passes"].push_back(*pass);
    response.set_content(status.dump(-1, ' ', true, Json::error_handler_t::replace), "application/json");
  }

  Json slider_list() const {
    Json list = Json::array();
    for (const Slider& slider : sliders)
      list.push_back({{"name", slider.name},
                      {"label", slider.label},
                      {"least", slider.least},
                      {"most", slider.most},
                      {"step", slider.step},
                      {"value", slider.value}});
    return list;
  }

  void send_picture(const httplib::Request& request, httplib::Response& response) {
    const std::string which = request.get_param_value("which");
    Shown shown;
    {
      const std::scoped_lock lock(mutex);
      shown = which == "before"      ? before
              : which == "look"      ? look_before
              : which == "reference" ? Shown{reference, 1}
                                     : latest;
    }
    const auto bytes = shown.picture ? layer_bytes(*shown.picture, request.get_param_value("layer")) : std::nullopt;
    if (!bytes) {
      response.status = 404;
      return;
    }
    response.set_header("X-Size", fmt::format("{}x{}", shown.picture->width, shown.picture->height));
    response.set_header("X-Version", std::to_string(shown.version));
    response.set_content(*bytes, "application/octet-stream");
    {
      const std::scoped_lock lock(mutex);
      if (shown.version == latest.version) fetched = shown.version;
    }
    asked_something.notify_all();
  }

  void send_row(const httplib::Request& request, httplib::Response& response) {
    const auto number = number_of(request, "request");
    const std::scoped_lock lock(mutex);
    const auto found = number ? rows.find(*number) : rows.end();
    if (found == rows.end())
      response.status = 204;
    else
      response.set_content(found->second.dump(), "application/json");
  }

  /// Takes a change of sliders and of the color as JSON. Returns what is wrong with it; if empty, the change waits for
  /// take_look().
  std::string ask_look(const Json& words) {
    if (sliders.empty()) return "look: expected a render that offers sliders, found none";
    if (!words.contains("values") || !words["values"].is_object() || words["values"].size() > sliders.size())
      return "values: expected an object of sliders and numbers";
    Look asked_look;
    for (const auto& [name, value] : words["values"].items()) {
      const auto slider = std::ranges::find(sliders, name, &Slider::name);
      if (slider == sliders.end())
        return fmt::format("{}: expected one of {}", name,
                           fmt::join(sliders | std::views::transform(&Slider::name), ", "));
      const double x = value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
      if (!(x >= slider->least && x <= slider->most))
        return fmt::format("{}: expected {}..{}, found {}", name, slider->least, slider->most,
                           value.dump(-1, ' ', true, Json::error_handler_t::replace).substr(0, 40));
      asked_look.values[name] = x;
    }
    if (words.contains("color")) {
      asked_look.color = words["color"].dump(-1, ' ', true, Json::error_handler_t::replace);
      if (std::string wrong = fault_of_color(asked_look.color); !wrong.empty()) return wrong;
    }
    look = std::move(asked_look);
    ++looks_asked;
    is_look_asked = true;
    paused = false;
    return {};
  }

  void take_control(const httplib::Request& request, httplib::Response& response) {
    const Json words = Json::parse(request.body, nullptr, false);
    const std::string what =
        words.is_object() && words.contains("do") && words["do"].is_string() ? words["do"] : Json("");
    Json answer = Json::object();
    {
      const std::scoped_lock lock(mutex);
      if (what == "pause" || what == "resume")
        paused = what == "pause";
      else if (what == "save")
        asked.save = true;
      else if (what == "stop")
        stopped = true;
      else if (what == "row" && words.contains("slice") && words["slice"].is_number_unsigned() &&
               words.contains("node") && words["node"].is_number_unsigned() && asked.rows.size() < most_rows_asked) {
        constexpr std::uint64_t most = 0xffffffff;
        asked.rows.push_back({++last_request,
                              static_cast<std::uint32_t>(std::min(words["slice"].get<std::uint64_t>(), most)),
                              static_cast<std::uint32_t>(std::min(words["node"].get<std::uint64_t>(), most))});
        answer["request"] = last_request;
      } else if (what == "look") {
        if (const std::string wrong = ask_look(words); !wrong.empty()) {
          answer["error"] = wrong;
          response.status = 400;
        } else
          answer["look"] = looks_asked;
      } else
        response.status = 400;
    }
    asked_something.notify_all();
    response.set_content(answer.dump(), "application/json");
  }

  void set_routes();
};

void RenderServer::State::set_routes() {
  using httplib::Request;
  using httplib::Response;
  server.new_task_queue = [this] { return new BoundedQueue(threads, connections_waiting, over); };
  server.set_read_timeout(3s);
  server.set_write_timeout(3s);
  server.set_keep_alive_timeout(2);
  server.set_keep_alive_max_count(64);
  server.set_payload_max_length(4096);
  server.set_tcp_nodelay(true);
  server.set_default_headers(
      {{"Cache-Control", "no-store"}, {"X-Content-Type-Options", "nosniff"}, {"X-Frame-Options", "DENY"}});
  server.set_pre_routing_handler([this](const Request& request, Response& response) {
    const bool is_post = request.method == "POST";
    int refused = 0;
    // A form of another page can post here, but it cannot send JSON without a preflight request.
    if (is_foreign(request) || (is_post && request.get_header_value("Content-Type") != "application/json"))
      refused = 403;
    else if (const std::scoped_lock lock(mutex); over || (!is_post && !time.is_due()))
      refused = 503;
    if (refused == 0) return httplib::Server::HandlerResponse::Unhandled;
    response.status = refused;
    response.set_header("Connection", "close");
    return httplib::Server::HandlerResponse::Handled;
  });
  server.Get("/", timed([](const Request&, Response& response) {
               static const std::string page = whole_page("live.html", Json::object());
               response.set_content(page, "text/html; charset=utf-8");
             }));
  server.Get("/status", timed([this](const auto& request, auto& response) { send_status(request, response); }));
  server.Get("/picture", timed([this](const auto& request, auto& response) { send_picture(request, response); }));
  server.Get("/table", timed([this](const Request&, Response& response) {
               std::shared_ptr<const std::string> text;
               {
                 const std::scoped_lock lock(mutex);
                 text = table;
               }
               response.set_content(*text, "application/json");
             }));
  server.Get("/row", timed([this](const auto& request, auto& response) { send_row(request, response); }));
  server.Post("/control", timed([this](const auto& request, auto& response) { take_control(request, response); }));
}

RenderServer::RenderServer() : state_(std::make_shared<State>()) {}

/// A client that sends its request byte by byte can hold a thread for hours; such a thread is left to the end of the
/// process.
RenderServer::~RenderServer() {
  state_->over = true;
  state_->server.stop();
  if (!state_->listener.joinable()) return;
  std::unique_lock lock(state_->mutex);
  const bool has_ended = state_->asked_something.wait_for(lock, patience_at_the_end, [&] { return state_->has_ended; });
  lock.unlock();
  if (has_ended)
    state_->listener.join();
  else
    state_->listener.detach();
}

Result<std::unique_ptr<RenderServer>> RenderServer::start(const std::string& address) {
  std::string host = address, port_text;
  if (const std::size_t colon = host.rfind(':'); colon != std::string::npos) {
    port_text = host.substr(colon + 1);
    host.resize(colon);
  }
  if (host.empty()) host = "127.0.0.1";
  int port = 0;
  const auto [end, error] = std::from_chars(port_text.data(), port_text.data() + port_text.size(), port);
  const bool is_number = port_text.empty() || (error == std::errc() && end == port_text.data() + port_text.size());
  if (!is_number || port < 0 || port > 65535) return Error{"", "--serve", "ADDRESS:PORT, port 0 to 65535", address};
  std::unique_ptr<RenderServer> server(new RenderServer);
  State& state = *server->state_;
  state.set_routes();
  state.address = host;
  state.is_loopback = host == "127.0.0.1" || host == "localhost";
  state.port = port == 0 ? state.server.bind_to_any_port(host) : state.server.bind_to_port(host, port) ? port : -1;
  if (state.port <= 0) return Error{"", "--serve", "an address and a port that are free", address};
  state.listener = std::thread([shared = server->state_] {
    shared->server.listen_after_bind();
    const std::scoped_lock lock(shared->mutex);
    shared->has_ended = true;
    shared->asked_something.notify_all();
  });
  // A stop() before the server runs would be lost.
  while (!state.server.is_running()) std::this_thread::sleep_for(1ms);
  return server;
}

std::string RenderServer::url() const { return fmt::format("http://{}:{}/", state_->address, state_->port); }

bool RenderServer::is_watched() const {
  const std::scoped_lock lock(state_->mutex);
  return Clock::now() - state_->last_asked < watched_for;
}

void RenderServer::set_facts(const Json& facts) {
  const std::scoped_lock lock(state_->mutex);
  state_->facts.update(facts);
}

void RenderServer::add_pass(Json pass) {
  const std::scoped_lock lock(state_->mutex);
  state_->passes.push_back(std::make_shared<const Json>(std::move(pass)));
  if (state_->passes.size() <= most_passes) return;
  state_->passes.pop_front();
  ++state_->first_pass;
}

void RenderServer::show(std::shared_ptr<const image::Picture> picture) {
  const std::scoped_lock lock(state_->mutex);
  state_->before = std::exchange(state_->latest, {std::move(picture), state_->latest.version + 1});
}

void RenderServer::set_reference(std::shared_ptr<const image::Picture> picture) {
  const std::scoped_lock lock(state_->mutex);
  state_->reference = std::move(picture);
}

void RenderServer::set_table(Json table) {
  auto text = std::make_shared<const std::string>(table.dump(-1, ' ', true, Json::error_handler_t::replace));
  const std::scoped_lock lock(state_->mutex);
  state_->table = std::move(text);
  ++state_->table_version;
}

void RenderServer::answer_row(std::uint64_t request, Json row) {
  const std::scoped_lock lock(state_->mutex);
  state_->rows[request] = std::move(row);
  if (state_->rows.size() > most_rows_answered) state_->rows.erase(state_->rows.begin());
}

RenderServer::Asked RenderServer::take_asked() {
  const std::scoped_lock lock(state_->mutex);
  return std::exchange(state_->asked, {});
}

void RenderServer::offer(std::vector<Slider> sliders, const Json& color,
                         std::function<std::string(const std::string&)> fault_of_color) {
  const std::scoped_lock lock(state_->mutex);
  state_->sliders = std::move(sliders);
  state_->color = color;
  state_->fault_of_color = std::move(fault_of_color);
}

bool RenderServer::is_look_asked() const { return state_->is_look_asked; }

RenderServer::Look RenderServer::take_look() {
  const std::scoped_lock lock(state_->mutex);
  state_->is_look_asked = false;
  state_->looks_taken = state_->looks_asked;
  state_->first_of_look = state_->latest.version + 1;
  state_->look_before = state_->latest;
  state_->first_pass += state_->passes.size();
  state_->passes.clear();
  return state_->look;
}

bool RenderServer::is_paused() const {
  const std::scoped_lock lock(state_->mutex);
  return state_->paused && !state_->stopped;
}

bool RenderServer::is_stopped() const {
  const std::scoped_lock lock(state_->mutex);
  return state_->stopped;
}

void RenderServer::wait_for_request(std::chrono::milliseconds patience) {
  std::unique_lock lock(state_->mutex);
  state_->asked_something.wait_for(lock, patience);
}

void RenderServer::wait_until_seen(std::chrono::milliseconds patience) {
  std::unique_lock lock(state_->mutex);
  if (Clock::now() - state_->last_asked >= watched_for) return;
  state_->asked_something.wait_for(lock, patience, [&] { return state_->fetched >= state_->latest.version; });
}

double RenderServer::cpu_seconds() const {
  const std::scoped_lock lock(state_->mutex);
  return state_->time.spent().count();
}

}  // namespace tress::live
