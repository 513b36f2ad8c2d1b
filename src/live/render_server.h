// The live page: serves the state of a render, and passes the page's requests to it.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "image/picture.h"
#include "tress/base/error.h"

namespace tress::live {

/// Its own threads answer; they use copies only, so a render never waits for a client. Memory: four pictures, the last
/// most_passes passes, one table, a few requests. Connections beyond a few wait outside the program, and clients that
/// ask too often or stall are refused and dropped. Requests that name another host, or come from a page of another
/// origin, are refused. Thread-safety: all calls from one thread.
class RenderServer {
 public:
  using Json = nlohmann::ordered_json;

  static constexpr std::size_t most_passes = 4096;

  /// address: "ADDRESS:PORT", "ADDRESS", ":PORT" or empty; the default address is 127.0.0.1, and port 0 or none means a
  /// free one. Error if it cannot listen there.
  static Result<std::unique_ptr<RenderServer>> start(const std::string& address);
  ~RenderServer();

  /// The address as "http://127.0.0.1:40123/".
  std::string url() const;
  /// Whether a page has sent a request within the last seconds: without one nothing needs to be copied.
  bool is_watched() const;

  /// Sets facts of the page besides the passes, by key; earlier facts of the same key are replaced.
  void set_facts(const Json& facts);
  void add_pass(Json pass);
  void show(std::shared_ptr<const image::Picture> picture);
  /// A picture for comparison on the page, "reference". Call it once.
  void set_reference(std::shared_ptr<const image::Picture> picture);
  void set_table(Json table);
  /// Answers the request for a row.
  void answer_row(std::uint64_t request, Json row);

  struct RowAsked {
    std::uint64_t request = 0;
    std::uint32_t slice = 0, node = 0;
  };
  /// The requests of the page since the last call.
  struct Asked {
    bool save = false;
    std::vector<RowAsked> rows;
  };
  Asked take_asked();

  /// A parameter of the picture that the page can change; the render then starts anew.
  struct Slider {
    std::string name, label;
    double least = 0, most = 1, step = 0.01;
    double value = 0;  ///< initial position
  };
  /// Call it once; without sliders, no change is accepted. color: of the hair, as a scene file has it. fault_of_color:
  /// what is wrong with another one as a text of JSON, or empty; called by any thread.
  void offer(std::vector<Slider> sliders, const Json& color,
             std::function<std::string(const std::string&)> fault_of_color);
  struct Look {
    std::map<std::string, double> values;  ///< by the names of the sliders that were moved
    std::string color;                     ///< JSON; empty: unchanged
  };
  /// Whether a change waits for take_look(). Any thread.
  bool is_look_asked() const;
  /// Returns the last change; every value is in the range of its slider. The page's list of passes is cleared, and the
  /// last picture is kept as the one before the change.
  Look take_look();

  bool is_paused() const;
  bool is_stopped() const;
  /// Returns at the next request of a page, or after that time.
  void wait_for_request(std::chrono::milliseconds patience);

  /// Returns when a page has fetched the last picture, when no page sends requests, or after that time.
  void wait_until_seen(std::chrono::milliseconds patience);

  /// CPU time of all answers so far, seconds.
  double cpu_seconds() const;

 private:
  RenderServer();
  struct State;
  std::shared_ptr<State> state_;  ///< shared with the threads
};

}  // namespace tress::live
