// Radiance pictures (.hdr, RGBE).
#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "tress/base/error.h"

namespace tress::scene {

struct HdrPicture {
  int width = 0, height = 0;
  std::vector<glm::vec3> pixels;  ///< row-major, top row first; finite, >= 0
};

/// Whether the bytes begin as such a file does.
bool is_hdr_file(std::span<const unsigned char> bytes);

/// Parses the bytes of an RGBE file whose scan lines run left to right from the top (-Y +X), run-length encoded by
/// component or flat. A value is mantissa * 2^(exponent - 136); an EXPOSURE in the header is not applied. The size is
/// held against `most_pixels` and against the number of bytes before memory is taken; a file that ends early is an
/// error. `name` is the file named in errors, which give the byte.
Result<HdrPicture> parse_hdr_file(std::span<const unsigned char> bytes, const std::string& name,
                                  std::size_t most_pixels);

}  // namespace tress::scene
