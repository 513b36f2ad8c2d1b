#include "scene/read/texture_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <system_error>

#include "image/color_image.h"
#include "scene/read/input_files.h"

namespace tress::scene {
namespace {

constexpr std::size_t most_pixels = std::size_t{1} << 26;
constexpr std::uintmax_t most_bytes = std::uintmax_t{1} << 29;
constexpr const char* wanted = "a PNG or EXR picture";

/// The inverse of image::linear_from_srgb().
float srgb_from_linear(float x) { return x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1 / 2.4f) - 0.055f; }

Result<image::ColorImage> read(const std::filesystem::path& file, bool is_encoded) {
  const auto start = read_file_start(file, wanted, bytes_of_kind);
  if (!start) return start.error();
  if (image::is_png(*start)) {
    const auto bytes = read_input_file(file, wanted, most_bytes);
    if (!bytes) return bytes.error();
    auto png = image::parse_png(*bytes, file.string());
    if (png && !is_encoded)
      for (glm::vec3& pixel : png->pixels)
        for (int c = 0; c < 3; ++c) pixel[c] = srgb_from_linear(pixel[c]);
    return png;
  }
  if (known_kind_of(*start).find("OpenEXR") == std::string::npos)
    return Error{file.string(), "", wanted, kind_of(*start)};
  return image::read_exr_color(file);
}

constexpr std::string_view tile_word = "<UDIM>";

Result<Texture> load_picture(const std::filesystem::path& file, std::vector<std::string>* warnings, bool is_encoded) {
  auto image = read(file, is_encoded);
  if (!image) return image.error();
  if (image->pixels.size() > most_pixels)
    return Error{file.string(), "size", fmt::format("at most {} pixels", most_pixels),
                 fmt::format("{} x {}", image->width, image->height)};
  for (const std::string& remark : image->remarks) warnings->push_back(file.string() + ": " + remark);
  std::size_t clamped = 0;
  for (glm::vec3& pixel : image->pixels)
    for (int c = 0; c < 3; ++c) {
      const float share = std::clamp(pixel[c], 0.0f, 1.0f);
      if (share != pixel[c]) ++clamped;
      pixel[c] = share;
    }
  if (clamped)
    warnings->push_back(fmt::format("{}: {} of {} values are outside 0..1 and taken for its ends: an albedo is a share",
                                    file.string(), clamped, 3 * image->pixels.size()));
  return Texture(image->width, image->height, image->pixels);
}

}  // namespace

std::map<int, std::filesystem::path> udim_files(const std::filesystem::path& file) {
  std::map<int, std::filesystem::path> files;
  const std::string name = file.filename().string();
  const std::size_t place = name.rfind(tile_word);
  if (place == name.npos) return files;
  std::error_code unknown;
  for (int tile = first_udim_tile; tile <= last_udim_tile; ++tile) {
    const auto of_tile = file.parent_path() / std::string(name).replace(place, tile_word.size(), std::to_string(tile));
    if (std::filesystem::exists(of_tile, unknown)) files.emplace(tile, of_tile);
  }
  return files;
}

Result<Texture> load_texture(const std::filesystem::path& file, std::vector<std::string>* warnings, bool is_encoded) {
  if (file.filename().string().find(tile_word) == std::string::npos) return load_picture(file, warnings, is_encoded);
  std::map<int, Texture> tiles;
  for (const auto& [number, path] : udim_files(file)) {
    auto tile = load_picture(path, warnings, is_encoded);
    if (!tile) return tile;
    tiles.emplace(number, std::move(*tile));
  }
  if (tiles.empty())
    return Error{file.string(), "",
                 fmt::format("files of tiles, {} to {} in place of {}", first_udim_tile, last_udim_tile, tile_word),
                 "none"};
  return Texture(std::move(tiles));
}

}  // namespace tress::scene
