#include "live/display_client.h"

#include <algorithm>
#include <new>
#include <utility>

#include "base/cpu_clock.h"
#include "live/viewer_packets.h"

namespace tress::live {

DisplayClient::DisplayClient(Endpoint viewer, std::string name, const Options& options)
    : viewer_(std::move(viewer)),
      name_(std::move(name)),
      options_(options),
      time_(options.cpu_share),
      thread_([this](const std::stop_token& stop) { talk(stop); }) {}

bool DisplayClient::wants_picture() const {
  const std::scoped_lock lock(mutex_);
  return given_ == done_ && time_.is_due();
}

double DisplayClient::cpu_seconds() const {
  const std::scoped_lock lock(mutex_);
  return time_.spent().count();
}

void DisplayClient::show(std::shared_ptr<const image::Picture> picture) {
  {
    const std::scoped_lock lock(mutex_);
    picture_ = std::move(picture);
    ++given_;
  }
  changed_.notify_all();
}

bool DisplayClient::finish(std::shared_ptr<const image::Picture> picture) {
  std::unique_lock lock(mutex_);
  picture_ = std::move(picture);
  ++given_;
  is_last_ = true;
  changed_.notify_all();
  changed_.wait(lock, [&] { return done_ == given_; });
  return last_arrived_;
}

/// Sends pictures until it is stopped. If the viewer is missing or stalled, it is tried again later with the picture of
/// that time.
void DisplayClient::talk(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    changed_.wait_for(lock, stop, options_.retry, [&] { return given_ != done_; });
    if (stop.stop_requested() || !picture_) continue;
    const std::shared_ptr<const image::Picture> picture = picture_;
    const std::uint64_t given = given_;
    const bool is_last = is_last_, is_new = given != done_, is_due = is_new || time_.is_due();
    lock.unlock();
    const double start = thread_cpu_seconds();
    const Outcome outcome = bring(*picture, is_new, is_due, is_last, stop);
    lock.lock();
    if (outcome != Outcome::nothing_to_do) time_.spent(TimeShare::Seconds(thread_cpu_seconds() - start));
    done_ = given;
    if (is_last) {
      last_arrived_ = outcome == Outcome::arrived;
      picture_.reset();
    }
    changed_.notify_all();
  }
}

DisplayClient::Outcome DisplayClient::bring(const image::Picture& picture, bool is_new, bool is_due, bool is_last,
                                            const std::stop_token& stop) {
  try {
    const bool was_open = socket_.is_open();
    if (was_open && !is_new) return Outcome::nothing_to_do;
    if (!was_open) {
      channels_.clear();
      if (!is_last && (!is_due || TimeShare::Clock::now() < next_attempt_)) return Outcome::nothing_to_do;
      if (!socket_.connect(viewer_, std::min<std::chrono::milliseconds>(options_.patience, std::chrono::seconds(1)),
                           stop)) {
        next_attempt_ = TimeShare::Clock::now() + options_.retry;
        return Outcome::not_there;
      }
    }
    const bool arrived = send_changes(picture, is_last ? patience_at_the_end() : options_.patience, stop);
    has_stalled_ = !arrived;
    if (arrived) {
      // Bytes in transit still arrive if the socket is closed in good order.
      if (is_last) socket_.close();
      return Outcome::arrived;
    }
  } catch (const std::bad_alloc&) {
    socket_.close();
  }
  channels_.clear();
  next_attempt_ = TimeShare::Clock::now() + options_.patience;
  return Outcome::stalled;
}

/// A viewer that has stalled before gets at most a hundredth of the time so far.
std::chrono::milliseconds DisplayClient::patience_at_the_end() const {
  if (!has_stalled_) return options_.patience;
  const auto hundredth = std::chrono::duration_cast<std::chrono::milliseconds>(TimeShare::Clock::now() - start_) / 100;
  return std::min(options_.patience, hundredth);
}

bool DisplayClient::create(const image::Picture& picture, std::chrono::milliseconds patience,
                           const std::stop_token& stop) {
  std::vector<std::string> channels;
  for (const image::Channel& channel : picture.channels) channels.push_back(channel.name);
  if (channels == channels_ && picture.width == width_ && picture.height == height_) return true;
  channels_.clear();
  sent_.clear();
  if (!socket_.send(create_image_packet(name_, picture.width, picture.height, channels), patience, stop)) return false;
  channels_ = std::move(channels);
  width_ = picture.width;
  height_ = picture.height;
  return true;
}

/// Sends one packet for each layer and tile. A newer picture does not interrupt it, so that the viewer has a whole one.
bool DisplayClient::send_changes(const image::Picture& picture, std::chrono::milliseconds patience,
                                 const std::stop_token& stop) {
  if (!create(picture, patience, stop)) return false;
  const std::vector<image::Window> tiles = tiles_of(picture.width, picture.height);
  const auto layers = channels_by_layer(picture);
  sent_.resize(layers.size() * tiles.size());
  std::size_t place = 0;
  for (const auto& layer : layers) {
    for (const image::Window& tile : tiles) {
      const std::uint64_t hash = tile_hash(layer, picture.width, tile);
      std::optional<std::uint64_t>& sent = sent_[place++];
      if (sent == hash) continue;
      if (!socket_.send(update_image_packet(name_, layer, picture.width, tile), patience, stop)) return false;
      sent = hash;
    }
  }
  return true;
}

}  // namespace tress::live
