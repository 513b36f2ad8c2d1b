// Layered pictures: memory, OpenEXR, PNG preview, comparison. The only folder that includes OpenEXR.
#pragma once

#include <array>
#include <filesystem>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tress/adaptive/error.h"

namespace tress::image {

struct Channel {
  std::string name;           ///< "R", "TT.G", "ais.exact"
  std::vector<float> pixels;  ///< row-major, top row first
};

struct Picture {
  int width = 0, height = 0;
  std::vector<Channel> channels;
  std::map<std::string, std::string> metadata;  ///< header strings
  const Channel* find(const std::string& name) const;
};

/// Scanline, one part, ZIP, 32-bit float. Written to a temporary file and renamed. All values must be finite
/// (asserted).
std::optional<Error> write_exr(const std::filesystem::path& file, const Picture& picture);
/// Any EXR of one or more float or half channels, at most 2^28 pixels. Rejects NaN, truncated and foreign files.
Result<Picture> read_exr(const std::filesystem::path& file);
/// 8 bit sRGB of R, G, B over a mid-grey or the picture's own background, exposure such that nothing is guessed:
/// a filmic-free clamp. Atomic like write_exr.
std::optional<Error> write_png(const std::filesystem::path& file, const Picture& picture);

/// B against A over their common R, G, B (and only if sizes agree).
struct Difference {
  double rel_mse = 0;            ///< mean of (b-a)^2 / (a^2 + 1e-2 * mean(a)^2), per channel then mean
  double mae = 0;                ///< mean |b-a|
  std::array<double, 3> bias{};  ///< mean of b - a
  double largest = 0;            ///< max |b-a|
  bool identical = false;        ///< every channel of both, bit for bit
};
Result<Difference> compare(const Picture& a, const Picture& b, const std::string& name_a, const std::string& name_b);

}  // namespace tress::image
