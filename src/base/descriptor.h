#pragma once

#include <unistd.h>

#include <utility>

namespace tress::inline v0_2 {

/// Closes a POSIX file descriptor at the end of the scope.
class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  int number() const { return number_; }
  bool is_open() const { return number_ >= 0; }
  bool close() { return number_ < 0 || ::close(std::exchange(number_, -1)) == 0; }
  /// Closes the descriptor that it had and takes over another.
  void reset(int number) {
    close();
    number_ = number;
  }

 private:
  int number_;
};

}  // namespace tress::inline v0_2
