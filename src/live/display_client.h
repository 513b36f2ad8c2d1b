// Shows the progressive picture in a viewer that speaks tev's protocol.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "image/picture.h"
#include "live/time_share.h"
#include "live/viewer_socket.h"

namespace tress::live {

/// A thread of its own talks to the viewer; only finish() waits for it. It connects as soon as the viewer is there, and
/// again after it was gone; only tiles that have changed are sent. A viewer that takes nothing for `patience` is left
/// alone for a while. Besides the shown picture it keeps 8 bytes for each tile and layer, and one packet.
class DisplayClient {
 public:
  struct Options {
    double cpu_share = 0.003;                  ///< share of the time since construction that its thread may use
    std::chrono::milliseconds patience{3000};  ///< time to wait for a viewer that takes nothing
    std::chrono::milliseconds retry{500};      ///< time between two attempts to connect
  };
  /// name: the picture's name in the viewer.
  DisplayClient(Endpoint viewer, std::string name) : DisplayClient(std::move(viewer), std::move(name), Options{}) {}
  DisplayClient(Endpoint viewer, std::string name, const Options& options);
  /// Stops at once.
  ~DisplayClient() = default;

  /// Whether a picture shown now would be sent: the previous one is done, and the share of time allows another. Any
  /// thread.
  bool wants_picture() const;
  /// Replaces a picture that still waits. If a picture has another size or other channels, the viewer starts with a new
  /// image.
  void show(std::shared_ptr<const image::Picture> picture);
  /// Sends the last picture, whatever its time, and waits until the viewer has it. True if it has all of it; false if
  /// there is no viewer, or it has stalled.
  bool finish(std::shared_ptr<const image::Picture> picture);

  /// CPU time of the thread so far, seconds. Any thread.
  double cpu_seconds() const;

 private:
  enum class Outcome { arrived, stalled, not_there, nothing_to_do };

  void talk(const std::stop_token& stop);
  Outcome bring(const image::Picture& picture, bool is_new, bool is_due, bool is_last, const std::stop_token& stop);
  std::chrono::milliseconds patience_at_the_end() const;
  bool send_changes(const image::Picture& picture, std::chrono::milliseconds patience, const std::stop_token& stop);
  bool create(const image::Picture& picture, std::chrono::milliseconds patience, const std::stop_token& stop);

  const Endpoint viewer_;
  const std::string name_;
  const Options options_;
  const TimeShare::Clock::time_point start_ = TimeShare::Clock::now();
  mutable std::mutex mutex_;  ///< guards the next six
  std::condition_variable_any changed_;
  std::shared_ptr<const image::Picture> picture_;  ///< the latest
  std::uint64_t given_ = 0, done_ = 0;             ///< numbers of pictures: shown here, and sent or dropped
  bool is_last_ = false, last_arrived_ = false;
  TimeShare time_;
  ViewerSocket socket_;                             ///< used by the thread only, as the rest
  std::vector<std::optional<std::uint64_t>> sent_;  ///< hash of the pixels that the viewer has, by layer, then by tile
  std::vector<std::string> channels_;               ///< channels of the viewer's image; empty without one
  int width_ = 0, height_ = 0;
  bool has_stalled_ = false;  ///< whether the last attempt to send stalled
  TimeShare::Clock::time_point next_attempt_{};
  std::jthread thread_;  ///< declared last, so that it ends before everything that it uses
};

}  // namespace tress::live
