#include "live/viewer_socket.h"

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <utility>

namespace tress::live {
namespace {

/// Host and port of HOST:PORT; both empty for any other text.
std::pair<std::string, std::string> parted(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) return {};
  std::string host = text.substr(0, colon), port = text.substr(colon + 1);
  if (host.size() >= 2 && host.front() == '[' && host.back() == ']')
    host = host.substr(1, host.size() - 2);
  else if (host.find(':') != std::string::npos)
    return {};
  const bool is_number =
      !port.empty() && port.size() <= 5 && std::ranges::all_of(port, [](char c) { return c >= '0' && c <= '9'; });
  if (host.empty() || !is_number || std::stoi(port) < 1 || std::stoi(port) > 65535) return {};
  return {host, port};
}

}  // namespace

Result<Endpoint> find_endpoint(const std::string& text) {
  const auto [host, port] = parted(text);
  if (host.empty()) return Error{"", "", "HOST:PORT, port 1 to 65535", text};
  addrinfo wanted{};
  wanted.ai_family = AF_UNSPEC;
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int status = getaddrinfo(host.c_str(), port.c_str(), &wanted, &found); status != 0)
    return Error{"", "", "a host that is known", host + ": " + gai_strerror(status)};
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> list(found, &freeaddrinfo);
  Endpoint endpoint;
  endpoint.name = text;
  for (const addrinfo* address = found; address != nullptr; address = address->ai_next) {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(address->ai_addr);
    endpoint.addresses.push_back({address->ai_family, {bytes, bytes + address->ai_addrlen}});
  }
  return endpoint;
}

void ViewerSocket::close() {
  if (file_ >= 0) ::close(file_);
  file_ = -1;
}

/// Waits in steps, so that `stop` is seen soon.
bool ViewerSocket::wait_to_write(Clock::time_point end, const std::stop_token& stop) const {
  constexpr int step_ms = 20;
  while (!stop.stop_requested()) {
    pollfd waiting{file_, POLLOUT, 0};
    const int count = poll(&waiting, 1, step_ms);
    if (count > 0) return (waiting.revents & (POLLERR | POLLHUP | POLLNVAL)) == 0;
    if (count < 0 && errno != EINTR) return false;
    if (Clock::now() >= end) return false;
  }
  return false;
}

bool ViewerSocket::connect(const Endpoint& endpoint, std::chrono::milliseconds patience, const std::stop_token& stop) {
  for (const Endpoint::Address& address : endpoint.addresses) {
    close();
    file_ = socket(address.family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (file_ < 0) continue;
    const int on = 1;
    setsockopt(file_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    sockaddr_storage where{};
    std::memcpy(&where, address.bytes.data(), std::min(address.bytes.size(), sizeof where));
    const int status =
        ::connect(file_, reinterpret_cast<const sockaddr*>(&where), static_cast<socklen_t>(address.bytes.size()));
    if (status == 0) return true;
    if (errno == EINPROGRESS && wait_to_write(Clock::now() + patience, stop)) {
      int error = 0;
      socklen_t size = sizeof error;
      if (getsockopt(file_, SOL_SOCKET, SO_ERROR, &error, &size) == 0 && error == 0) return true;
    }
  }
  close();
  return false;
}

bool ViewerSocket::send(std::string_view bytes, std::chrono::milliseconds patience, const std::stop_token& stop) {
  const Clock::time_point end = Clock::now() + patience;
  while (!bytes.empty() && file_ >= 0) {
    const ssize_t sent = ::send(file_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent > 0)
      bytes.remove_prefix(static_cast<std::size_t>(sent));
    else if (sent < 0 && errno != EINTR && errno != EAGAIN && errno != EWOULDBLOCK)
      close();
    else if (!wait_to_write(end, stop))
      close();
  }
  return file_ >= 0;
}

bool ViewerSocket::is_open() {
  if (file_ < 0) return false;
  char bytes[256];
  for (;;) {
    const ssize_t count = recv(file_, bytes, sizeof bytes, MSG_DONTWAIT);
    if (count > 0) continue;  // a viewer sends nothing by the protocol: anything it sends is dropped
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return true;
    close();
    return false;
  }
}

}  // namespace tress::live
