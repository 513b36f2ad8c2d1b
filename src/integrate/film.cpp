#include "integrate/film.h"

#include <limits>
#include <string>

namespace tress::integrate {
namespace {

constexpr std::size_t nowhere = std::numeric_limits<std::size_t>::max();

}  // namespace

PathSums& PathSums::operator+=(const PathSums& other) {
  for (int lobe = 0; lobe < fiber::lobe_count; ++lobe) lobes[lobe] += other.lobes[lobe];
  background += other.background;
  coverage += other.coverage;
  samples += other.samples;
  queries += other.queries;
  exact_queries += other.exact_queries;
  return *this;
}

Film::Film(int width, int height)
    : width_(width), height_(height), pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {}

/// For each pixel the sampled one that stands for it: breadth first from all sampled pixels at once.
std::vector<std::size_t> Film::nearest_sampled() const {
  std::vector<std::size_t> source(pixels_.size(), nowhere);
  std::vector<std::size_t> queue;
  queue.reserve(pixels_.size());
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    if (pixels_[i].samples == 0) continue;
    source[i] = i;
    queue.push_back(i);
  }
  const auto width = static_cast<std::size_t>(width_);
  for (std::size_t head = 0; head < queue.size() && queue.size() < pixels_.size(); ++head) {
    const std::size_t here = queue[head];
    const auto reach = [&](bool inside, std::size_t neighbour) {
      if (!inside || source[neighbour] != nowhere) return;
      source[neighbour] = source[here];
      queue.push_back(neighbour);
    };
    reach(here % width > 0, here - 1);
    reach(here % width + 1 < width, here + 1);
    reach(here >= width, here - width);
    reach(here + width < pixels_.size(), here + width);
  }
  return source;
}

image::Picture Film::picture() const {
  image::Picture picture;
  picture.width = width_;
  picture.height = height_;
  const auto add = [&](const std::string& name) {
    picture.channels.push_back({name, std::vector<float>(pixels_.size(), 0.0f)});
  };
  for (const char* name : {"R", "G", "B", "A"}) add(name);
  constexpr int layer_count = fiber::lobe_count + 1;
  for (int layer = 0; layer < layer_count; ++layer) {
    const std::string name = layer < fiber::lobe_count ? fiber::lobe_names[layer] : "background";
    for (const char* color : {".R", ".G", ".B"}) add(name + color);
  }
  add("ais.exact");
  std::vector<image::Channel>& channels = picture.channels;
  const std::vector<std::size_t> source = nearest_sampled();
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    if (source[i] == nowhere) continue;
    const PathSums& sums = pixels_[source[i]];
    const auto count = static_cast<float>(sums.samples);
    channels[3].pixels[i] = sums.coverage / count;
    for (int layer = 0; layer < layer_count; ++layer) {
      const glm::vec3& sum = layer < fiber::lobe_count ? sums.lobes[layer] : sums.background;
      for (int color = 0; color < 3; ++color) {
        const float mean = sum[color] / count;
        channels[4 + 3 * layer + color].pixels[i] = mean;
        channels[color].pixels[i] += mean;
      }
    }
    if (sums.queries > 0) {
      channels.back().pixels[i] = static_cast<float>(sums.exact_queries) / static_cast<float>(sums.queries);
    }
  }
  return picture;
}

double Film::samples_per_pixel() const {
  double total = 0;
  for (const PathSums& pixel : pixels_) total += pixel.samples;
  return pixels_.empty() ? 0 : total / static_cast<double>(pixels_.size());
}

std::uint64_t Film::queries() const {
  std::uint64_t total = 0;
  for (const PathSums& pixel : pixels_) total += pixel.queries;
  return total;
}

std::uint64_t Film::exact_queries() const {
  std::uint64_t total = 0;
  for (const PathSums& pixel : pixels_) total += pixel.exact_queries;
  return total;
}

}  // namespace tress::integrate
