#include "integrate/film.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>

#include "base/color.h"

namespace tress::integrate {
namespace {

constexpr std::size_t any_matte_bits = std::size_t{1} << 32;

/// Sum of the path's layers that beauty has. It is in doubles, as the means are that it is compared with, so that sums
/// of parts agree with one render.
glm::dvec3 beauty_of_path(const PathSums& path, Ground ground) {
  glm::dvec3 sum(0.0);
  for (std::size_t layer = 0; layer < beauty_layers(ground); ++layer) sum += glm::dvec3(path.layers[layer]);
  return sum;
}

/// Whether A counts the path.
bool is_opaque(const PathSums& path, Ground ground) {
  return (path.coverage > 0 || path.sees_light || ground == Ground::backdrop) && !path.held_out;
}

/// The depth of the path in a deep picture.
float depth_of(const PathSums& path) {
  constexpr float farthest = std::numeric_limits<float>::max();
  if (path.coverage > 0) return path.distance_cm;
  return path.sees_light ? std::min(path.light_cm, farthest) : farthest;
}

}  // namespace

bool PixelSums::add(const PathSums& path, Ground ground, std::uint32_t first_sample) {
  const bool is_odd = (first_sample + traced()) % 2 == 1;
  vertices += path.vertices;
  queries += path.queries;
  exact_queries += path.exact_queries;
  if (!path.is_finite()) {
    ++dropped;
    return false;
  }
  const glm::dvec3 value = beauty_of_path(path, ground);
  const glm::dvec3 before = samples > 0 ? beauty(ground) / static_cast<double>(samples) : glm::dvec3(0.0);
  for (std::size_t layer = 0; layer < layers.size(); ++layer) layers[layer] += glm::dvec3(path.layers[layer]);
  albedo += glm::dvec3(path.albedo);
  normal += glm::dvec3(path.normal);
  tangent += glm::dvec3(path.tangent);
  coverage += static_cast<double>(path.coverage);
  opaque += is_opaque(path, ground) ? 1 : 0;
  distance_cm += static_cast<double>(path.distance_cm);
  objective += static_cast<double>(path.objective);
  excess += static_cast<double>(path.excess);
  excess_squares += static_cast<double>(path.excess) * static_cast<double>(path.excess);
  ++samples;
  if (is_odd) {
    odd_beauty += value;
    ++odd_samples;
  }
  const glm::dvec3 after = beauty(ground) / static_cast<double>(samples);
  if (samples > 1) squared_deviations += glm::max((value - before) * (value - after), glm::dvec3(0.0));
  return true;
}

glm::dvec3 PixelSums::beauty(Ground ground) const {
  glm::dvec3 sum(0.0);
  for (std::size_t layer = 0; layer < beauty_layers(ground); ++layer) sum += layers[layer];
  return sum;
}

glm::dvec3 PixelSums::variance_of_mean() const {
  if (samples < 2) return glm::dvec3(0.0);
  const auto n = static_cast<double>(samples);
  return squared_deviations / (n * (n - 1));
}

glm::dvec3 PixelSums::variance_by_halves(Ground ground) const {
  if (odd_samples == 0 || odd_samples == samples) return glm::dvec3(0.0);
  const double n = samples, odd = odd_samples, even = n - odd;
  const glm::dvec3 apart = odd_beauty / odd - (beauty(ground) - odd_beauty) / even;
  return apart * apart * (odd * even / (n * n));
}

Film::Film(const image::Window& window, bool glint, bool timed, Ground ground, std::size_t objects, bool moving,
           Extra extra)
    : window_(window),
      glint_(glint),
      ground_(ground),
      extra_(std::move(extra)),
      pixels_(static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height)),
      object_counts_(pixels_.size(), objects),
      motion_(moving ? pixels_.size() : 0),
      cpu_seconds_(timed ? pixels_.size() : 0),
      data_(extra_.data.has_sums() ? pixels_.size() : 0),
      strand_counts_(pixels_.size(), extra_.data.has(DataLayer::strand_mattes) ? any_matte_bits : 0,
                     ObjectCounts::most_strands) {
  group_sums_.resize(pixels_.size() * extra_.groups.size(), glm::dvec3(0.0));
  halves_.resize(extra_.halves ? pixels_.size() : 0);
  deep_light_.resize(extra_.deep_light ? pixels_.size() : 0);
  depth_bins_.resize(extra_.depth_bins ? pixels_.size() : 0);
}

bool Film::add(int x, int y, const PathSums& path) {
  if (halves_.empty()) {
    if (!pixel(x, y).add(path, ground_, extra_.first_sample)) return false;
  } else {
    const PixelSums before = pixel(x, y);
    if (!pixel(x, y).add(path, ground_, extra_.first_sample)) return false;
    add_to_halves(index(x, y), before);
  }
  if (path.coverage > 0) object_counts_.add(index(x, y), path.object);
  if (path.coverage > 0 && !data_.empty()) data_[index(x, y)].add(path.data, path.distance_cm);
  if (path.coverage > 0 && path.data.matte_bits != 0) strand_counts_.add(index(x, y), path.data.matte_bits);
  if (!depth_bins_.empty() && is_opaque(path, ground_))
    depth_bins_[index(x, y)].add(beauty_of_path(path, ground_), depth_of(path));
  if (!motion_.empty()) {
    MotionSums& sums = motion_[index(x, y)];
    (path.coverage > 0 ? sums.seen : sums.behind) += glm::dvec2(path.motion);
  }
  if (!deep_light_.empty()) {
    DeepLightSums& sums = deep_light_[index(x, y)];
    const auto excess = static_cast<double>(path.deep_light_excess);
    sums.excess += excess;
    sums.squares += excess * excess;
    sums.checks += path.deep_light_checks;
  }
  const std::size_t count = extra_.groups.size(), first = index(x, y) * count;
  for (std::size_t group = 0; group < count; ++group) {
    glm::dvec3 light(path.groups.light[group]);
    if (group == extra_.backdrop_group && ground_ == Ground::backdrop)
      light += glm::dvec3(path.layers[background_layer]);
    if (std::isfinite(light.x + light.y + light.z)) group_sums_[first + group] += light;
  }
  return true;
}

/// Sums over all pixels, in the same order for any number of threads: each task adds those of a block, and the blocks
/// are added one after the other. add: adds pixel i to the Sums.
template <class Sums, class Add>
Sums Film::summed(const Add& add) const {
  constexpr std::size_t block_pixels = 2048;
  std::vector<Sums> blocks((pixels_.size() + block_pixels - 1) / block_pixels);
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t block) {
    const std::size_t end = std::min(pixels_.size(), (block + 1) * block_pixels);
    Sums sums{};
    for (std::size_t i = block * block_pixels; i < end; ++i) add(sums, i);
    blocks[block] = sums;
  });
  Sums total{};
  for (const Sums& sums : blocks) total += sums;
  return total;
}

/// Finds the nearest sampled pixels by a breadth-first search from all sampled pixels at once.
std::vector<std::size_t> Film::shown_pixels() const {
  std::vector<std::size_t> source(pixels_.size(), no_pixel);
  std::vector<std::size_t> queue;
  queue.reserve(pixels_.size());
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    if (pixels_[i].samples == 0) continue;
    source[i] = i;
    queue.push_back(i);
  }
  const auto width = static_cast<std::size_t>(window_.width);
  for (std::size_t head = 0; head < queue.size() && queue.size() < pixels_.size(); ++head) {
    const std::size_t here = queue[head];
    const auto reach = [&](bool inside, std::size_t neighbour) {
      if (!inside || source[neighbour] != no_pixel) return;
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

std::vector<PixelCost> Film::costs() const {
  std::vector<PixelCost> costs(pixels_.size());
  for (std::size_t i = 0; i < costs.size(); ++i) {
    const PixelSums& sums = pixels_[i];
    const std::uint64_t paths = std::uint64_t{sums.samples} + sums.dropped;
    costs[i] = {timed() ? cpu_seconds_[i] : 0, paths, sums.vertices, sums.queries, sums.exact_queries};
  }
  return costs;
}

double Film::relative_noise() const {
  constexpr double pixels_of_independent_paths = 32;
  struct Sums {
    double independent = 0, by_halves = 0, brightness = 0, covered = 0;
    void operator+=(const Sums& more) {
      independent += more.independent;
      by_halves += more.by_halves;
      brightness += more.brightness;
      covered += more.covered;
    }
  };
  const Sums all = summed<Sums>([&](Sums& sums, std::size_t i) {
    const PixelSums& pixel = pixels_[i];
    if (!(pixel.coverage > 0)) return;
    const glm::dvec3 upper = pixel.variance_of_mean(), halves = pixel.variance_by_halves(ground_),
                     mean = pixel.beauty(ground_) / static_cast<double>(pixel.samples);
    for (int c = 0; c < 3; ++c) {
      sums.independent += upper[c];
      sums.by_halves += halves[c];
      sums.brightness += mean[c];
    }
    sums.covered += 1;
  });
  if (!(all.brightness > 0)) return 0;
  const double share = all.covered / (all.covered + pixels_of_independent_paths);
  const double variance = share * all.by_halves + (1 - share) * all.independent;
  return std::sqrt(variance * 3 * all.covered) / all.brightness;
}

Film::Seen Film::seen() const {
  struct Sums {
    double pixels = 0, samples = 0, paths = 0;
    glm::dvec3 means{0.0}, light{0.0}, squares{0.0};
    void operator+=(const Sums& more) {
      pixels += more.pixels;
      samples += more.samples;
      paths += more.paths;
      means += more.means;
      light += more.light;
      squares += more.squares;
    }
  };
  const Sums all = summed<Sums>([&](Sums& sums, std::size_t i) {
    const PixelSums& pixel = pixels_[i];
    if (!(pixel.coverage > 0)) return;
    const glm::dvec3 light = pixel.beauty(ground_), mean = light / static_cast<double>(pixel.samples);
    sums.pixels += 1;
    sums.samples += pixel.samples;
    sums.paths += pixel.coverage;
    sums.means += mean;
    sums.light += light;
    sums.squares += pixel.squared_deviations + light * mean;
  });
  Seen seen;
  seen.pixels = all.pixels;
  seen.samples = all.samples;
  seen.paths = all.paths;
  if (all.pixels > 0) seen.mean = (all.means.x + all.means.y + all.means.z) / (3 * all.pixels);
  for (int c = 0; c < 3; ++c) {
    if (all.squares[c] > 0) seen.light_paths = std::max(seen.light_paths, all.light[c] * all.light[c] / all.squares[c]);
  }
  return seen;
}

double Film::brightness() const {
  const auto light = summed<double>([&](double& sum, std::size_t i) {
    if (pixels_[i].samples > 0) sum += luminance(pixels_[i].beauty(Ground::nothing)) / pixels_[i].samples;
  });
  return light / static_cast<double>(pixels_.size());
}

struct Film::ExcessSums {
  double light = 0, excess = 0, variance = 0;
  std::uint64_t paths = 0;
  void operator+=(const ExcessSums& more) {
    light += more.light;
    excess += more.excess;
    variance += more.variance;
    paths += more.paths;
  }
  void add(const PixelSums& pixel, double pixel_excess, double squares) {
    if (pixel.samples == 0) return;
    const double n = pixel.samples;
    light += luminance(pixel.beauty(Ground::nothing)) / n;
    excess += pixel_excess / n;
    variance += squares / (n * n);  // nearly all are 0, so the mean square is the variance
  }
  Brightening brightening() const {
    const double truth = light - excess;
    if (!(truth > 0)) return {};
    return {excess / truth, std::sqrt(variance) / truth};
  }
};

Brightening Film::excess() const {
  return summed<ExcessSums>([&](ExcessSums& sums, std::size_t i) {
           sums.add(pixels_[i], pixels_[i].excess, pixels_[i].excess_squares);
         })
      .brightening();
}

std::optional<DeepLightBias> Film::deep_light_bias() const {
  if (deep_light_.empty()) return std::nullopt;
  const auto all = summed<ExcessSums>([&](ExcessSums& sums, std::size_t i) {
    sums.add(pixels_[i], deep_light_[i].excess, deep_light_[i].squares);
    if (pixels_[i].samples > 0) sums.paths += deep_light_[i].checks;
  });
  return DeepLightBias{all.brightening(), all.paths};
}

double Film::samples_per_pixel() const {
  double total = 0;
  for (const PixelSums& pixel : pixels_) total += pixel.samples;
  return pixels_.empty() ? 0 : total / static_cast<double>(pixels_.size());
}

std::uint64_t Film::dropped_samples() const {
  std::uint64_t total = 0;
  for (const PixelSums& pixel : pixels_) total += pixel.dropped;
  return total;
}

std::uint64_t Film::queries() const {
  std::uint64_t total = 0;
  for (const PixelSums& pixel : pixels_) total += pixel.queries;
  return total;
}

std::uint64_t Film::exact_queries() const {
  std::uint64_t total = 0;
  for (const PixelSums& pixel : pixels_) total += pixel.exact_queries;
  return total;
}

// The sums of a film as bytes, for checkpoints and parts of pictures, and the addition of films.
namespace {

static_assert(std::is_trivially_copyable_v<PixelSums> && std::is_trivially_copyable_v<DataSums> &&
              std::is_trivially_copyable_v<double>);

// If you add a sum, add it to add() and is_finite() below, too.
static_assert(sizeof(PixelSums) ==
              (layer_count + 5) * sizeof(glm::dvec3) + 9 * sizeof(std::uint64_t) + 4 * sizeof(std::uint32_t));

template <class T>
std::string_view bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

bool is_finite(const glm::dvec3& x) { return std::isfinite(x.x) && std::isfinite(x.y) && std::isfinite(x.z); }

bool is_finite(const PixelSums& sums) {
  bool good = is_finite(sums.albedo) && is_finite(sums.normal) && is_finite(sums.tangent) &&
              is_finite(sums.squared_deviations) && is_finite(sums.odd_beauty) && std::isfinite(sums.coverage) &&
              std::isfinite(sums.distance_cm) && std::isfinite(sums.objective) && std::isfinite(sums.opaque) &&
              std::isfinite(sums.excess) && std::isfinite(sums.excess_squares);
  for (const glm::dvec3& layer : sums.layers) good = good && is_finite(layer);
  return good;
}

}  // namespace

std::vector<std::pair<std::string, std::string_view>> Film::sections() const {
  std::vector<std::pair<std::string, std::string_view>> all{{"film.sums", bytes_of(pixels_)}};
  if (!object_counts_.bytes().empty()) all.emplace_back("film.objects", object_counts_.bytes());
  if (!group_sums_.empty()) all.emplace_back("film.groups", bytes_of(group_sums_));
  if (!motion_.empty()) all.emplace_back("film.motion", bytes_of(motion_));
  if (timed()) all.emplace_back("film.times", bytes_of(cpu_seconds_));
  if (!halves_.empty()) all.emplace_back("film.halves", bytes_of(halves_));
  if (!deep_light_.empty()) all.emplace_back("film.deep_light", bytes_of(deep_light_));
  if (!depth_bins_.empty()) all.emplace_back("film.depth", bytes_of(depth_bins_));
  if (!data_.empty()) all.emplace_back("film.data", bytes_of(data_));
  if (!strand_counts_.bytes().empty()) all.emplace_back("film.strands", strand_counts_.bytes());
  return all;
}

bool Film::set_sections(const std::map<std::string, std::string>& sections) {
  const auto take = [&](const char* name, auto& values) {
    using Value = typename std::remove_reference_t<decltype(values)>::value_type;
    const auto found = sections.find(name);
    if (found == sections.end() || found->second.size() != values.size() * sizeof(Value)) return false;
    std::memcpy(values.data(), found->second.data(), found->second.size());
    return true;
  };
  const auto take_counts = [&](const char* name, ObjectCounts& counts) {
    const auto found = sections.find(name);
    return counts.set_bytes(found == sections.end() ? std::string_view() : found->second);
  };
  bool good = take("film.sums", pixels_) && (motion_.empty() || take("film.motion", motion_)) &&
              (group_sums_.empty() || take("film.groups", group_sums_)) &&
              take_counts("film.objects", object_counts_) && take_counts("film.strands", strand_counts_) &&
              (data_.empty() || take("film.data", data_)) && (!timed() || take("film.times", cpu_seconds_)) &&
              (halves_.empty() || take("film.halves", halves_)) &&
              (deep_light_.empty() || take("film.deep_light", deep_light_)) &&
              (depth_bins_.empty() || take("film.depth", depth_bins_));
  for (std::size_t i = 0; i < depth_bins_.size(); ++i) good = good && depth_bins_[i].are_sound(pixels_[i].samples);
  for (const PixelSums& sums : pixels_) good = good && is_finite(sums);
  for (const DataSums& sums : data_) good = good && sums.is_finite();
  for (const double seconds : cpu_seconds_) good = good && std::isfinite(seconds);
  for (const glm::dvec3& sum : group_sums_) good = good && is_finite(sum);
  for (const HalfSquares& sums : halves_) good = good && is_finite(sums.even) && is_finite(sums.odd);
  for (const DeepLightSums& sums : deep_light_)
    good = good && std::isfinite(sums.excess) && std::isfinite(sums.squares);
  for (const MotionSums& sums : motion_) {
    for (const glm::dvec2& sum : {sums.seen, sums.behind}) good = good && std::isfinite(sum.x) && std::isfinite(sum.y);
  }
  return good;
}

void PixelSums::add(const PixelSums& later, Ground ground) {
  // Deviations of two samples from their common mean (Chan, Golub and LeVeque 1979).
  if (samples > 0 && later.samples > 0) {
    const auto n = static_cast<double>(samples), m = static_cast<double>(later.samples);
    const glm::dvec3 apart = later.beauty(ground) / m - beauty(ground) / n;
    squared_deviations += apart * apart * (n * m / (n + m));
  }
  squared_deviations += later.squared_deviations;
  for (std::size_t i = 0; i < layers.size(); ++i) layers[i] += later.layers[i];
  odd_beauty += later.odd_beauty;
  albedo += later.albedo;
  normal += later.normal;
  tangent += later.tangent;
  coverage += later.coverage;
  distance_cm += later.distance_cm;
  objective += later.objective;
  opaque += later.opaque;
  excess += later.excess;
  excess_squares += later.excess_squares;
  vertices += later.vertices;
  queries += later.queries;
  exact_queries += later.exact_queries;
  samples += later.samples;
  odd_samples += later.odd_samples;
  dropped += later.dropped;
}

std::size_t Film::add(const Film& later) {
  const image::Window& other = later.window_;
  std::size_t lacking = 0;
  for (int y = other.top; y < other.top + other.height; ++y) {
    for (int x = other.left; x < other.left + other.width; ++x) {
      if (!halves_.empty()) add_halves(index(x, y), later, later.index(x, y));
      pixel(x, y).add(later.pixel(x, y), ground_);
      const bool has_objects = object_counts_.add(index(x, y), later.object_counts_, later.index(x, y));
      const bool has_strands = strand_counts_.add(index(x, y), later.strand_counts_, later.index(x, y));
      lacking += has_objects && has_strands ? 0 : 1;
      if (!data_.empty()) data_[index(x, y)].add(later.data_[later.index(x, y)]);
    }
  }
  const std::size_t groups = extra_.groups.size();
  for (int y = other.top; y < other.top + other.height && groups > 0; ++y) {
    for (int x = other.left; x < other.left + other.width; ++x) {
      for (std::size_t group = 0; group < groups; ++group)
        group_sums_[index(x, y) * groups + group] += later.group_sums_[later.index(x, y) * groups + group];
    }
  }
  for (int y = other.top; y < other.top + other.height && !motion_.empty(); ++y) {
    for (int x = other.left; x < other.left + other.width; ++x) {
      motion_[index(x, y)].seen += later.motion_[later.index(x, y)].seen;
      motion_[index(x, y)].behind += later.motion_[later.index(x, y)].behind;
    }
  }
  for (int y = other.top; y < other.top + other.height && !deep_light_.empty(); ++y) {
    for (int x = other.left; x < other.left + other.width; ++x) {
      DeepLightSums& sums = deep_light_[index(x, y)];
      const DeepLightSums& more = later.deep_light_[later.index(x, y)];
      sums.excess += more.excess;
      sums.squares += more.squares;
      sums.checks += more.checks;
    }
  }
  return lacking;
}

}  // namespace tress::integrate
