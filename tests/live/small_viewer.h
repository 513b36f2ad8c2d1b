// A viewer that speaks tev's protocol: it keeps the images that it is sent, and counts.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstring>
#include <map>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

namespace tress::test {

class SmallViewer {
 public:
  struct Image {
    int width = 0, height = 0;
    std::map<std::string, std::vector<float>> channels;
  };
  /// What the viewer does with its connections.
  enum class Manner { reads, stalls };

  /// port: 0 for any.
  explicit SmallViewer(std::uint16_t port = 0, Manner manner = Manner::reads) : manner_(manner) {
    listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const int on = 1;
    setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port);
    is_listening_ =
        bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0 && listen(listener_, 4) == 0;
    socklen_t size = sizeof address;
    getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
    thread_ = std::jthread([this](const std::stop_token& stop) { serve(stop); });
  }
  ~SmallViewer() {
    thread_.request_stop();
    thread_.join();
    close(listener_);
  }

  bool is_listening() const { return is_listening_; }
  std::uint16_t port() const { return port_; }
  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

  Image image(const std::string& name) const {
    const std::scoped_lock lock(mutex_);
    const auto found = images_.find(name);
    return found == images_.end() ? Image{} : found->second;
  }
  int created() const { return counted(created_); }
  int updates() const { return counted(updates_); }
  /// Packets that no viewer would take: of another type, for an image or channel that is not there, out of it, or
  /// longer or shorter than they say.
  int bad() const { return counted(bad_); }

  /// Whether `done` becomes true within some seconds.
  template <class Done>
  static bool wait_until(Done&& done) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (!done()) {
      if (std::chrono::steady_clock::now() > end) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return true;
  }

 private:
  int counted(const int& number) const {
    const std::scoped_lock lock(mutex_);
    return number;
  }

  void serve(const std::stop_token& stop) {
    std::vector<int> stalled;
    while (!stop.stop_requested()) {
      pollfd waiting{listener_, POLLIN, 0};
      if (poll(&waiting, 1, 5) <= 0) continue;
      const int file = accept(listener_, nullptr, nullptr);
      if (file < 0) continue;
      if (manner_ == Manner::stalls) {
        stalled.push_back(file);
        continue;
      }
      while (!stop.stop_requested() && take_packet(file, stop)) continue;
      close(file);
    }
    for (const int file : stalled) close(file);
  }

  static bool read_all(int file, char* bytes, std::size_t size, const std::stop_token& stop) {
    while (size > 0) {
      pollfd waiting{file, POLLIN, 0};
      if (stop.stop_requested()) return false;
      if (poll(&waiting, 1, 5) <= 0) continue;
      const ssize_t count = recv(file, bytes, size, 0);
      if (count <= 0) return false;
      bytes += count;
      size -= static_cast<std::size_t>(count);
    }
    return true;
  }

  struct Reader {
    std::string bytes;
    std::size_t at = 0;
    bool good = true;

    std::int32_t number() {
      std::int32_t value = 0;
      copy(&value, sizeof value);
      return value;
    }
    std::string text() {
      const std::size_t end = bytes.find('\0', at);
      good = good && end != std::string::npos;
      if (!good) return {};
      std::string text = bytes.substr(at, end - at);
      at = end + 1;
      return text;
    }
    void copy(void* to, std::size_t size) {
      good = good && size <= bytes.size() - at;
      if (!good) return;
      std::memcpy(to, bytes.data() + at, size);
      at += size;
    }
    std::vector<std::string> texts() {
      std::vector<std::string> all;
      for (std::int32_t left = number(); good && left > 0; --left) all.push_back(text());
      return all;
    }
  };

  bool take_packet(int file, const std::stop_token& stop) {
    std::uint32_t size = 0;
    if (!read_all(file, reinterpret_cast<char*>(&size), sizeof size, stop)) return false;
    Reader packet{std::string(size < 6 || size > (1u << 24) ? 0 : size - 4, '\0')};
    if (packet.bytes.empty() || !read_all(file, packet.bytes.data(), packet.bytes.size(), stop)) return false;
    const char type = packet.bytes[0];
    packet.at = 2;
    const std::scoped_lock lock(mutex_);
    if (!(type == 4 ? create(packet) : type == 5 ? update(packet) : false) || packet.at != packet.bytes.size()) ++bad_;
    return true;
  }

  bool create(Reader& packet) {
    const std::string name = packet.text();
    Image image;
    image.width = packet.number();
    image.height = packet.number();
    for (const std::string& channel : packet.texts())
      image.channels[channel].resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
    images_[name] = std::move(image);
    ++created_;
    return packet.good;
  }

  bool update(Reader& packet) {
    const std::string name = packet.text();
    const std::vector<std::string> channels = packet.texts();
    const int x = packet.number(), y = packet.number(), w = packet.number(), h = packet.number();
    const auto found = images_.find(name);
    if (!packet.good || found == images_.end()) return false;
    Image& image = found->second;
    if (x < 0 || y < 0 || w < 1 || h < 1 || x + w > image.width || y + h > image.height) return false;
    for (const std::string& channel : channels) {
      const auto pixels = image.channels.find(channel);
      if (pixels == image.channels.end()) return false;
      for (int row = y; row < y + h; ++row)
        packet.copy(&pixels->second[static_cast<std::size_t>(row * image.width + x)],
                    sizeof(float) * static_cast<std::size_t>(w));
    }
    ++updates_;
    return packet.good;
  }

  Manner manner_;
  int listener_ = -1;
  bool is_listening_ = false;
  std::uint16_t port_ = 0;
  mutable std::mutex mutex_;
  std::map<std::string, Image> images_;
  int created_ = 0, updates_ = 0, bad_ = 0;
  std::jthread thread_;
};

}  // namespace tress::test
