// A connection to a viewer that may be gone, late or stalled: no call waits longer than it is allowed to.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "tress/base/error.h"

namespace tress::live {

/// The address of a viewer: the numeric addresses of a host, in the order in which they are tried.
struct Endpoint {
  struct Address {
    int family = 0;
    std::vector<std::uint8_t> bytes;  ///< a sockaddr of the system
  };
  std::string name;  ///< as it was given
  std::vector<Address> addresses;
};

/// Parses HOST:PORT or [IPV6]:PORT. Asks the system for the host's addresses, which may take any time. Error if the
/// text is not HOST:PORT, or the host is unknown.
Result<Endpoint> find_endpoint(const std::string& text);

/// Use it from one thread. Only `stop` may be called from another; it ends every wait at once.
class ViewerSocket {
 public:
  ViewerSocket() = default;
  ~ViewerSocket() { close(); }
  ViewerSocket(const ViewerSocket&) = delete;
  ViewerSocket& operator=(const ViewerSocket&) = delete;

  /// Connects within that time for each address. Returns whether it is connected.
  bool connect(const Endpoint& endpoint, std::chrono::milliseconds patience, const std::stop_token& stop);
  /// Returns whether all bytes were taken within that time. If not, or if the viewer is gone, the socket is closed.
  bool send(std::string_view bytes, std::chrono::milliseconds patience, const std::stop_token& stop);
  /// False once the other side has closed; the socket is then closed too.
  bool is_open();
  void close();

 private:
  using Clock = std::chrono::steady_clock;
  bool wait_to_write(Clock::time_point end, const std::stop_token& stop) const;

  int file_ = -1;
};

}  // namespace tress::live
