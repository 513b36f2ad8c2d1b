// The sums of a film as bytes, for checkpoints and parts of pictures, and the addition of films.
#include <cmath>
#include <cstring>
#include <type_traits>

#include "integrate/film.h"

namespace tress::integrate {
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
