#include "image/picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "image/view_transform.h"
#include "tress/base/replace_file.h"

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#include <stb_image_write.h>

namespace tress::image {

const Channel* Picture::find(const std::string& name) const {
  for (const auto& channel : channels)
    if (channel.name == name) return &channel;
  return nullptr;
}

std::string layer_of(const std::string& channel) {
  const std::size_t dot = channel.rfind('.');
  if (dot != std::string::npos) return channel.substr(0, dot);
  const bool of_beauty = channel == "R" || channel == "G" || channel == "B" || channel == "A";
  return of_beauty ? "beauty" : channel;
}

namespace {

/// Whether the layer has this name or belongs to the numbered set of this name.
bool is_of(const std::string& layer, const std::string& name) {
  if (!layer.starts_with(name)) return false;
  const std::string number = layer.substr(name.size());
  return number.empty() || (number.size() == 2 && number.find_first_not_of("0123456789") == std::string::npos);
}

bool has_layer(const Picture& picture, const std::string& name) {
  return std::any_of(picture.channels.begin(), picture.channels.end(),
                     [&](const Channel& channel) { return is_of(layer_of(channel.name), name); });
}

}  // namespace

void keep_layers(const std::vector<std::string>& layers, Picture* picture) {
  std::erase_if(picture->channels, [&](const Channel& channel) {
    const std::string layer = layer_of(channel.name);
    return layer != "beauty" &&
           std::none_of(layers.begin(), layers.end(), [&](const std::string& name) { return is_of(layer, name); });
  });
  std::vector<std::string> gone;  // "cryptomatte/KEY/" of the mattes without layers
  for (const auto& [key, value] : picture->metadata) {
    if (key.starts_with("cryptomatte/") && key.ends_with("/name") && !has_layer(*picture, value))
      gone.push_back(key.substr(0, key.rfind('/') + 1));
  }
  for (const std::string& prefix : gone)
    std::erase_if(picture->metadata, [&](const auto& entry) { return entry.first.starts_with(prefix); });
}

namespace {

/// The window of the pixels that two windows share.
Window overlap(const Window& a, const Window& b) {
  const int left = std::max(a.left, b.left), top = std::max(a.top, b.top);
  return {left, top, std::max(0, std::min(a.left + a.width, b.left + b.width) - left),
          std::max(0, std::min(a.top + a.height, b.top + b.height) - top)};
}

/// The pixels of a row of `window`, which must lie in the picture.
const float* row_of(const Picture& picture, const Channel& channel, const Window& window, int row) {
  return channel.pixels.data() +
         static_cast<std::size_t>(window.top + row - picture.top) * static_cast<std::size_t>(picture.width) +
         static_cast<std::size_t>(window.left - picture.left);
}

bool is_whole(const Picture& picture, const Channel& channel) {
  return channel.pixels.size() == static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
}

bool same_bits(const Picture& a, const Picture& b, const Window& window) {
  if (a.channels.size() != b.channels.size()) return false;
  return std::all_of(a.channels.begin(), a.channels.end(), [&](const Channel& channel) {
    const Channel* other = b.find(channel.name);
    if (!other || !is_whole(a, channel) || !is_whole(b, *other)) return false;
    for (int row = 0; row < window.height; ++row) {
      if (std::memcmp(row_of(a, channel, window, row), row_of(b, *other, window, row),
                      static_cast<std::size_t>(window.width) * sizeof(float)) != 0)
        return false;
    }
    return true;
  });
}

std::string size_words(const Window& whole) { return fmt::format("{} x {}", whole.width, whole.height); }

}  // namespace

Result<Difference> compare(const Picture& a, const Picture& b, const std::string& name_a, const std::string& name_b) {
  if (a.whole() != b.whole())
    return Error{name_b, "size", size_words(a.whole()) + " as in " + name_a, size_words(b.whole())};
  const Window common = overlap(a.window(), b.window());
  if (common.width == 0 || common.height == 0)
    return Error{name_b, "data window", "pixels that " + name_a + " has too", "none"};
  Difference difference;
  const char* const rgb[3] = {"R", "G", "B"};
  const double pixels = static_cast<double>(common.width) * common.height;
  for (std::size_t c = 0; c < 3; ++c) {
    const Channel* in_a = a.find(rgb[c]);
    const Channel* in_b = b.find(rgb[c]);
    if (!in_a || !is_whole(a, *in_a)) return Error{name_a, "channels", "R, G and B", std::string("no ") + rgb[c]};
    if (!in_b || !is_whole(b, *in_b)) return Error{name_b, "channels", "R, G and B", std::string("no ") + rgb[c]};
    double mean_a = 0;
    for (int row = 0; row < common.height; ++row) {
      const float* before = row_of(a, *in_a, common, row);
      for (int i = 0; i < common.width; ++i) mean_a += before[i];
    }
    mean_a /= pixels;
    double relative = 0, absolute = 0, bias = 0;
    const double floor = std::max(1e-2 * mean_a * mean_a, 1e-30);
    for (int row = 0; row < common.height; ++row) {
      const float* before = row_of(a, *in_a, common, row);
      const float* after = row_of(b, *in_b, common, row);
      for (int i = 0; i < common.width; ++i) {
        const double value = before[i];
        const double step = after[i] - value;
        relative += step * step / (value * value + floor);
        absolute += std::abs(step);
        bias += step;
        difference.largest = std::max(difference.largest, std::abs(step));
      }
    }
    difference.rel_mse += relative / (3 * pixels);
    difference.mae += absolute / (3 * pixels);
    difference.bias[c] = bias / pixels;
  }
  difference.identical = same_bits(a, b, common);
  return difference;
}

// Writes previews with 8 bits.
namespace {

constexpr float mid_grey = 0.18f;

/// Rounds a value in [0, 1] to 8 bits.
std::uint8_t in_8_bits(float value) { return static_cast<std::uint8_t>(std::lround(255 * value)); }

void append_bytes(void* context, void* data, int size) {
  static_cast<std::string*>(context)->append(static_cast<const char*>(data), static_cast<std::size_t>(size));
}

}  // namespace

std::optional<Error> write_png(const std::filesystem::path& file, const Picture& picture, const Preview& preview) {
  const auto pixels =
      static_cast<std::size_t>(std::max(picture.width, 0)) * static_cast<std::size_t>(std::max(picture.height, 0));
  std::string layer = std::string(preview.layer) + ".";
  if (picture.find(layer + "R") == nullptr) layer.clear();
  const Channel* rgb[3] = {picture.find(layer + "R"), picture.find(layer + "G"), picture.find(layer + "B")};
  for (const Channel* channel : rgb)
    if (!channel || channel->pixels.size() != pixels || pixels == 0)
      return Error{file.string(), "channels", "R, G and B of every pixel", "a picture without them"};
  // An opaque preview shows the background of the picture, or mid-grey if it has none.
  const Channel* alpha = preview.alpha || !picture.find("background.R") ? picture.find("A") : nullptr;
  const bool keeps_alpha = preview.alpha && alpha;
  const std::size_t bytes_per_pixel = keeps_alpha ? 4 : 3;
  const auto exposure = static_cast<float>(std::exp2(preview.exposure_stops));
  std::vector<std::uint8_t> bytes;
  bytes.reserve(pixels * bytes_per_pixel);
  for (std::size_t i = 0; i < pixels; ++i) {
    const float covered = alpha ? std::clamp(alpha->pixels[i], 0.0f, 1.0f) : 1.0f;
    const float behind = keeps_alpha ? 0.0f : mid_grey * (1 - covered);
    const float scale = keeps_alpha && covered > 0 ? exposure / covered : exposure;
    const glm::vec3 color(rgb[0]->pixels[i], rgb[1]->pixels[i], rgb[2]->pixels[i]);
    const glm::vec3 shown = displayed(preview.view, scale * color + behind);
    for (int c = 0; c < 3; ++c) bytes.push_back(in_8_bits(shown[c]));
    if (keeps_alpha) bytes.push_back(in_8_bits(covered));
  }
  std::string encoded;
  const int channels = static_cast<int>(bytes_per_pixel);
  if (!stbi_write_png_to_func(append_bytes, &encoded, picture.width, picture.height, channels, bytes.data(),
                              picture.width * channels))
    return Error{file.string(), "", "memory for the PNG encoder", "none left"};
  return replace_file(file, encoded);
}

}  // namespace tress::image
