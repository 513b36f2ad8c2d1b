#include <fmt/format.h>

#include <utility>

#include "image/color_image.h"
#include "scene/read/input_files.h"

namespace tress::scene {
namespace {

constexpr std::size_t most_pixels = image::most_color_pixels;
constexpr std::uintmax_t most_hdr_bytes = std::uintmax_t{1} << 30;
constexpr float largest_radiance = 1e12f;  ///< its sums and products stay finite in 32 bits

Result<HdrPicture> read_hdr_map(const std::filesystem::path& file) {
  const auto bytes = read_input_file(file, "an HDR picture", most_hdr_bytes);
  if (!bytes) return bytes.error();
  return parse_hdr_file(*bytes, file.string(), most_pixels);
}

Result<HdrPicture> read_exr_map(const std::filesystem::path& file) {
  auto image = image::read_exr_color(file);
  if (!image) return image.error();
  return HdrPicture{image->width, image->height, std::move(image->pixels), std::move(image->remarks)};
}

}  // namespace

Result<Environment> make_environment(HdrPicture map, const std::string& name, double rotate_rad, float scale,
                                     std::vector<std::string>* warnings) {
  const auto width = static_cast<std::size_t>(map.width), count = map.pixels.size();
  for (const std::string& remark : map.remarks) warnings->push_back(name + ": " + remark);
  std::size_t negative = 0;
  for (std::size_t i = 0; i < count; ++i)
    for (int c = 0; c < 3; ++c) {
      float& x = map.pixels[i][c];
      if (!(x <= largest_radiance))
        return Error{name, fmt::format("channel {}, pixel ({}, {})", "RGB"[c], i % width, i / width),
                     fmt::format("a radiance of at most {:g}", largest_radiance), fmt::format("{:g}", x)};
      if (x < 0) ++negative;
      if (!(x > 0)) x = 0;
    }
  if (negative)
    warnings->push_back(fmt::format("{}: {} of {} values are negative and taken for 0", name, negative, 3 * count));
  if (map.width != 2 * map.height)
    warnings->push_back(
        fmt::format("{}: {} x {} is stretched over the sphere; a latitude-longitude map is twice as "
                    "wide as high",
                    name, map.width, map.height));
  return Environment(map.width, map.height, std::move(map.pixels), rotate_rad, scale);
}

Result<Environment> load_environment(const std::filesystem::path& file, double rotate_rad, float scale,
                                     std::vector<std::string>* warnings) {
  const auto start = read_file_start(file, "an EXR or HDR picture", 16);
  if (!start) return start.error();
  if (const std::string kind = known_kind_of(*start);
      !kind.empty() && kind.find("OpenEXR") == kind.npos && kind.find("Radiance") == kind.npos)
    return Error{file.string(), "", "an EXR or HDR picture", kind};
  auto map = is_hdr_file(*start) ? read_hdr_map(file) : read_exr_map(file);
  if (!map) return map.error();
  return make_environment(std::move(*map), file.string(), rotate_rad, scale, warnings);
}

}  // namespace tress::scene
