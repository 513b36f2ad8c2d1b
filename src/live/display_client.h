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

/// A thread of its own talks to the viewer: no call here waits for one but finish(). It connects when the viewer is
/// there, however late, and again when it has been gone; only tiles that have changed since are sent. A viewer that
/// takes nothing for `patience` is left alone for a while. Beside the picture that is shown it keeps 8 bytes a tile and
/// layer, and one packet.
class DisplayClient {
 public:
  struct Options {
    double cpu_share = 0.003;                  ///< of the time since construction, for the thread of its own
    std::chrono::milliseconds patience{3000};  ///< with a viewer that takes nothing
    std::chrono::milliseconds retry{500};      ///< between two attempts to reach one
  };
  /// name: what the viewer calls the picture.
  DisplayClient(Endpoint viewer, std::string name) : DisplayClient(std::move(viewer), std::move(name), Options{}) {}
  DisplayClient(Endpoint viewer, std::string name, const Options& options);
  /// Gives up at once.
  ~DisplayClient() = default;

  /// Whether a picture shown now would go out: the one before has, and the share of time allows it. Any thread.
  bool wants_picture() const;
  /// Takes the place of one that waits. All pictures have the same size and channels, or the viewer begins anew.
  void show(std::shared_ptr<const image::Picture> picture);
  /// The last one, whatever its time; waits until the viewer has it. True if it has all of it; false if there is none,
  /// or it has stalled.
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
  mutable std::mutex mutex_;  ///< of the next six
  std::condition_variable_any changed_;
  std::shared_ptr<const image::Picture> picture_;  ///< the latest
  std::uint64_t given_ = 0, done_ = 0;             ///< pictures: shown here, and sent or given up
  bool is_last_ = false, last_arrived_ = false;
  TimeShare time_;
  ViewerSocket socket_;                             ///< of the thread, as the rest
  std::vector<std::optional<std::uint64_t>> sent_;  ///< hash of what the viewer has, by layer, then tile
  std::vector<std::string> channels_;               ///< of the image that the viewer has; none: it has none
  int width_ = 0, height_ = 0;
  bool has_stalled_ = false;  ///< when something was last sent
  TimeShare::Clock::time_point next_attempt_{};
  std::jthread thread_;  ///< last: it ends before all it uses
};

}  // namespace tress::live
