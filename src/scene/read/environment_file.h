// Radiance pictures (.hdr, RGBE), and environments from them and from OpenEXR.
#pragma once

#include <cstddef>
#include <filesystem>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "scene/model/environment.h"
#include "tress/base/error.h"

namespace tress::scene {

struct HdrPicture {
  int width = 0, height = 0;
  std::vector<glm::vec3> pixels;          ///< row-major, top row first; finite, >= 0
  std::vector<std::string> remarks = {};  ///< conversions and repairs
};

/// Whether the bytes begin like such a file.
bool is_hdr_file(std::span<const unsigned char> bytes);

/// Parses the bytes of an RGBE file whose scan lines run left to right from the top (-Y +X), run-length encoded by
/// component or flat. A value is mantissa * 2^(exponent - 136). Values are divided by the EXPOSUREs and COLORCORRs of
/// the header, because they are the radiance times these. The size is checked against `most_pixels` and against the
/// number of bytes before memory is allocated; a file that ends early is an error. `name` is the file named in errors,
/// which give the byte.
Result<HdrPicture> parse_hdr_file(std::span<const unsigned char> bytes, const std::string& name,
                                  std::size_t most_pixels);

/// Makes an environment of a latitude-longitude map, top row up, with as many pixels as its sides require. Radiance is
/// at most 1e12. Negative values become 0, with a warning; NaN and infinity are errors. A map that is not twice as wide
/// as high is a warning too. `name` is the file named in errors.
Result<Environment> make_environment(HdrPicture map, const std::string& name, double rotate_rad, float scale,
                                     std::vector<std::string>* warnings);

/// Loads a latitude-longitude map, top row up: OpenEXR with R, G, B, or RGBE (.hdr), detected by its first bytes, not
/// by its name. At most 2^27 pixels; otherwise as make_environment().
Result<Environment> load_environment(const std::filesystem::path& file, double rotate_rad, float scale,
                                     std::vector<std::string>* warnings);

}  // namespace tress::scene
