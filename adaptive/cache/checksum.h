// XXH3 (64 bits, seed 0) of bytes that come piece by piece.
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>

namespace tress::adaptive::format {

class Checksum {
 public:
  Checksum();
  ~Checksum();
  Checksum(const Checksum&) = delete;
  Checksum& operator=(const Checksum&) = delete;

  void add(std::string_view bytes);
  /// The checksum of all bytes so far.
  std::uint64_t value() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tress::adaptive::format
