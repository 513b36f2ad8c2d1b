#include "image/picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace tress::image {

const Channel* Picture::find(const std::string& name) const {
  for (const auto& channel : channels)
    if (channel.name == name) return &channel;
  return nullptr;
}

namespace {

bool same_bits(const Picture& a, const Picture& b) {
  if (a.channels.size() != b.channels.size()) return false;
  return std::all_of(a.channels.begin(), a.channels.end(), [&](const Channel& channel) {
    const Channel* other = b.find(channel.name);
    return other && other->pixels.size() == channel.pixels.size() &&
           std::memcmp(other->pixels.data(), channel.pixels.data(), channel.pixels.size() * sizeof(float)) == 0;
  });
}

}  // namespace

Result<Difference> compare(const Picture& a, const Picture& b, const std::string& name_a, const std::string& name_b) {
  if (a.width != b.width || a.height != b.height)
    return Error{name_b, "size", fmt::format("{} x {} as in {}", a.width, a.height, name_a),
                 fmt::format("{} x {}", b.width, b.height)};
  Difference difference;
  const char* const rgb[3] = {"R", "G", "B"};
  const auto pixels = static_cast<std::size_t>(a.width) * static_cast<std::size_t>(a.height);
  for (std::size_t c = 0; c < 3; ++c) {
    const Channel* in_a = a.find(rgb[c]);
    const Channel* in_b = b.find(rgb[c]);
    for (const auto& [channel, name] : {std::pair{in_a, name_a}, std::pair{in_b, name_b}})
      if (!channel || channel->pixels.size() != pixels || pixels == 0)
        return Error{name, "channels", "R, G and B", std::string("no ") + rgb[c]};
    double mean_a = 0;
    for (float x : in_a->pixels) mean_a += x;
    mean_a /= static_cast<double>(pixels);
    double relative = 0, absolute = 0, bias = 0;
    const double floor = std::max(1e-2 * mean_a * mean_a, 1e-30);
    for (std::size_t i = 0; i < pixels; ++i) {
      const double before = in_a->pixels[i];
      const double step = in_b->pixels[i] - before;
      relative += step * step / (before * before + floor);
      absolute += std::abs(step);
      bias += step;
      difference.largest = std::max(difference.largest, std::abs(step));
    }
    difference.rel_mse += relative / static_cast<double>(3 * pixels);
    difference.mae += absolute / static_cast<double>(3 * pixels);
    difference.bias[c] = bias / static_cast<double>(pixels);
  }
  difference.identical = same_bits(a, b);
  return difference;
}

}  // namespace tress::image
