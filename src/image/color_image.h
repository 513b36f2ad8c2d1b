// Pictures of color that a scene is made of: PNG and OpenEXR as linear RGB.
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "tress/base/error.h"

namespace tress::image {

struct ColorImage {
  int width = 0, height = 0;
  std::vector<glm::vec3> pixels;          ///< linear RGB of Rec. 709, row-major, top row first; finite
  std::vector<std::string> remarks = {};  ///< what was chosen, converted and mended
};

/// Whether the bytes begin as a PNG does.
bool is_png(std::span<const unsigned char> bytes);

/// A PNG (8 or 16 bit; grey becomes RGB, alpha is left out). Values are those of sRGB (IEC 61966-2-1),
/// whatever profile the file has; the result is in [0, 1]. The size is held against 2^26 pixels and against the number
/// of bytes before memory is taken. `name` is the file named in errors. Thread-safe.
Result<ColorImage> parse_png(std::span<const unsigned char> bytes, const std::string& name);

/// The color of an EXR: its R, G, B (or red, green, blue), those of its layer, of several the one called beauty,
/// combined or rgba, or Y alone as grey. Of other channels nothing matters. The whole display window, black where it
/// has no data. Colors of other chromaticities become those of Rec. 709 (white adapted by Bradford's cones); values
/// that are not finite become the largest that is, NaN 0. All of this is remarked.
Result<ColorImage> read_exr_color(const std::filesystem::path& file);

/// sRGB to linear, both in [0, 1].
float linear_from_srgb(float encoded);

}  // namespace tress::image
