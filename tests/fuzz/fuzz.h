// What the fuzz targets share. Each is one file: an entry point of input from outside, given any bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>

namespace tress::fuzz {

inline std::span<const unsigned char> bytes_of(const std::uint8_t* data, std::size_t size) { return {data, size}; }

/// Ends the program, which libFuzzer reports with the input: a claim that must hold for every input does not.
inline void require(bool holds) {
  if (!holds) std::abort();
}

/// A refusal must say something: which file, and what is wrong with it.
template <typename R>
void require_message(const R& refused, const std::string& file) {
  require(refused.error().message().find(file) != std::string::npos);
}

}  // namespace tress::fuzz
