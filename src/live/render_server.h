// The live page: serves what a render tells it, and takes what the page asks of the render.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "image/picture.h"
#include "tress/base/error.h"

namespace tress::live {

/// Threads of its own answer; they see copies alone, so that no client is waited for. Memory: four pictures, the last
/// most_passes passes, one table, a few requests. Connections beyond a few wait outside the program, and clients that
/// ask too often, or are stalled, are refused and dropped. Requests that name another host, or come from a page of
/// another origin, are refused. Thread-safety: all calls from one thread.
class RenderServer {
 public:
  using Json = nlohmann::ordered_json;

  static constexpr std::size_t most_passes = 4096;

  /// address: "ADDRESS:PORT", "ADDRESS", ":PORT" or empty; 127.0.0.1 unless told, port 0 or none: a free one.
  /// Error if it cannot listen there.
  static Result<std::unique_ptr<RenderServer>> start(const std::string& address);
  ~RenderServer();

  /// "http://127.0.0.1:40123/".
  std::string url() const;
  /// Whether a page has asked within some seconds: without one nothing needs to be copied.
  bool is_watched() const;

  /// What the page has besides the passes, by key: laid over what was told before.
  void tell(const Json& facts);
  void add_pass(Json pass);
  void show(std::shared_ptr<const image::Picture> picture);
  /// A picture that the page can lay beside, "reference": once.
  void set_reference(std::shared_ptr<const image::Picture> picture);
  void set_table(Json table);
  /// Answer to a row that was asked.
  void answer_row(std::uint64_t request, Json row);

  struct RowAsked {
    std::uint64_t request = 0;
    std::uint32_t slice = 0, node = 0;
  };
  /// What the page has asked for since the last call.
  struct Asked {
    bool save = false;
    std::vector<RowAsked> rows;
  };
  Asked take_asked();

  /// What the page can change of the picture, which then begins anew.
  struct Slider {
    std::string name, label;
    double least = 0, most = 1, step = 0.01;
    double value = 0;  ///< where it stands before it is moved
  };
  /// Once; without it no change is taken.
  void offer_sliders(std::vector<Slider> sliders);
  using Look = std::map<std::string, double>;  ///< by the names of those that were moved
  /// Whether a change waits. Any thread.
  bool is_look_asked() const;
  /// The last change, every value in the range of its slider. The passes of the page begin anew, and the picture is
  /// kept for it as that of the look before.
  Look take_look();

  bool is_paused() const;
  bool is_stopped() const;
  /// Returns at the next request of a page, or after that time.
  void wait_for_request(std::chrono::milliseconds patience);

  /// Returns when a page has fetched the last picture, no page asks, or after that time.
  void wait_until_seen(std::chrono::milliseconds patience);

  /// CPU time that answers have taken in all, seconds.
  double cpu_seconds() const;

 private:
  RenderServer();
  struct State;
  std::shared_ptr<State> state_;  ///< of the threads too
};

}  // namespace tress::live
