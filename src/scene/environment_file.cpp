#include "scene/environment_file.h"

#include <fmt/format.h>

#include "image/picture.h"

namespace tress::scene {
namespace {

constexpr std::size_t most_pixels = std::size_t{1} << 27;
constexpr float largest_radiance = 1e12f;  ///< its sums and products stay finite in 32 bits

}  // namespace

Result<Environment> load_environment(const std::filesystem::path& file, double rotate_rad, float scale,
                                     std::vector<std::string>* warnings) {
  auto read = image::read_exr(file);
  if (!read) return read.error();
  const image::Picture& picture = *read;
  const auto width = static_cast<std::size_t>(picture.width), count = width * static_cast<std::size_t>(picture.height);
  if (count > most_pixels)
    return Error{file.string(), "size", fmt::format("at most {} pixels", most_pixels), fmt::format("{}", count)};
  std::vector<glm::vec3> pixels(count);
  const char* const names[3] = {"R", "G", "B"};
  std::size_t negative = 0;
  for (int c = 0; c < 3; ++c) {
    const image::Channel* channel = picture.find(names[c]);
    if (!channel) return Error{file.string(), "channels", "R, G and B", std::string("no ") + names[c]};
    for (std::size_t i = 0; i < count; ++i) {
      const float x = channel->pixels[i];
      if (x > largest_radiance)
        return Error{file.string(), fmt::format("channel {}, pixel ({}, {})", names[c], i % width, i / width),
                     fmt::format("a radiance of at most {:g}", largest_radiance), fmt::format("{:g}", x)};
      if (x < 0) ++negative;
      pixels[i][c] = x > 0 ? x : 0.0f;
    }
  }
  if (negative)
    warnings->push_back(
        fmt::format("{}: {} of {} values are negative and taken for 0", file.string(), negative, 3 * count));
  return Environment(picture.width, picture.height, std::move(pixels), rotate_rad, scale);
}

}  // namespace tress::scene
