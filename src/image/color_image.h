// Color pictures for a scene: reads PNG and OpenEXR as linear RGB.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "tress/base/error.h"

namespace tress::image {

/// The most pixels of a color image that is read from an EXR.
inline constexpr std::int64_t most_color_pixels = std::int64_t{1} << 27;
/// The longest side of such an image, in pixels.
inline constexpr int longest_color_side = 1 << 17;

struct ColorImage {
  int width = 0, height = 0;
  std::vector<glm::vec3> pixels;          ///< linear RGB of Rec. 709, row-major, top row first; finite
  std::vector<std::string> remarks = {};  ///< what was chosen, converted and replaced, for the user
};

/// Whether the bytes begin like a PNG.
bool is_png(std::span<const unsigned char> bytes);

/// Reads a PNG (8 or 16 bit; grey becomes RGB, alpha is left out). Values count as sRGB (IEC 61966-2-1), whatever
/// profile the file has; the result is in [0, 1]. Before memory is allocated, the size is checked against 2^26 pixels
/// and against the number of bytes. name: the file to name in errors. Thread-safe.
Result<ColorImage> parse_png(std::span<const unsigned char> bytes, const std::string& name);

/// Reads the color of an EXR: its R, G, B (or red, green, blue), those of its only layer, those of the layer called
/// beauty, combined or rgba, or Y alone as grey. Other channels are ignored. The result is the whole display window,
/// black where it has no data. A window of more than 2^24 pixels is refused if it has more than 64 times as many as the
/// data, more than 4096 for a byte of the file, or more than most_color_pixels; so is a longer side than
/// longest_color_side. Colors of other chromaticities are converted to Rec. 709 (white adapted by
/// Bradford's cones). Infinite values become the largest finite one, and NaN becomes 0. `remarks` names what was done.
Result<ColorImage> read_exr_color(const std::filesystem::path& file);

/// sRGB to linear, both in [0, 1].
float linear_from_srgb(float encoded);

}  // namespace tress::image
