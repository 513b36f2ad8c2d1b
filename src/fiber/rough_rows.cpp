#include "fiber/rough_rows.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/pi.h"
#include "fiber/rough_paths.h"
#include "fiber/row_axes.h"
#include "tress/base/random.h"
#include "tress/fiber/elliptical_model.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr float largest_height = 12;
constexpr std::size_t first_part = 4;  // among the parameters of a slice
/// With a limit between 0.2 and 0.4, a path takes 0.6 to 0.7 of the time that it takes at 0.02. Standard errors of
/// energies are then 0 to 10 % larger; below an alpha of 0.1 up to 20 %.
constexpr float roulette_below = 0.25f;
/// Dark fibers are seen by their first reflection, which is a tenth of the light of clear paths. So the first paths of
/// a stream have more of it. Later there is enough.
constexpr std::uint32_t paths_with_reflections = 512;
constexpr std::uint32_t most_at_once = 4096;  // number of paths for which a thread keeps memory: 1 MB
constexpr float to_the_end = std::numeric_limits<float>::infinity();

float clamped(float height) { return std::clamp(height, -largest_height, largest_height); }

FiberParameters clear_fiber(const adaptive::SliceKey& key) {
  FiberParameters fiber;
  fiber.eta = key.parameters[0];
  fiber.eccentricity = key.parameters[1];
  fiber.roughness = key.parameters[2];
  fiber.tilt = key.parameters[3];
  TracedParts::from(key.parameters.data() + first_part).give_to(fiber);
  fiber.sigma_a = glm::vec3(0.0f);
  return fiber;
}

/// The key of a slice, a place in it and a stream.
std::uint64_t key_of(const adaptive::SliceKey& slice, float a, float b, std::uint64_t stream) {
  std::uint64_t key = mix_bits(stream + slice.lobe);
  const auto add = [&key](float x) { key = mix_bits(key + std::bit_cast<std::uint32_t>(x + 0.0f)); };  // -0 is 0
  for (const float x : slice.used_parameters(adaptive::SliceKey::usual_parameters)) add(x);
  add(a);
  add(b);
  return key;
}

/// The destinations for the exits of consecutive streams.
using Streams = std::span<std::vector<adaptive::SampledExit>* const>;

/// Draws all streams in one wavefront.
void draw_streams(const adaptive::SliceKey& slice, float a, float b, std::uint64_t stream, std::uint32_t first,
                  std::uint32_t count, Streams to) {
  const auto sets = static_cast<std::uint32_t>(to.size());
  const float specular = specular_height(a), cos_b = std::cos(b), sin_b = std::sin(b);
  RoughPaths traced(clear_fiber(slice), {roulette_below, to_the_end});
  // Kept by each thread: new pages cost more time than the paths on them.
  thread_local std::vector<float> azimuths, heights;
  std::vector<std::size_t> counts(sets);
  for (std::uint32_t done = 0; done < count;) {
    const std::uint32_t from = first + done;
    std::uint32_t paths = std::min(count - done, most_at_once / sets);
    if (from < paths_with_reflections) paths = std::min(paths, paths_with_reflections - from);
    for (std::uint32_t set = 0; set < sets; ++set) {
      const std::uint64_t key = key_of(slice, a, b, stream + set);
      if (from < paths_with_reflections)
        traced.add_sobol_with_reflections({a, b}, key, from, paths, set);
      else
        traced.add_sobol({a, b}, key, from, paths, set);
    }
    done += paths;
    const RoughPathExits& exits = traced.trace();
    exits.places(cos_b, sin_b, largest_height, azimuths, heights);
    std::ranges::fill(counts, 0);
    for (std::size_t i = 0; i < exits.size(); ++i) ++counts[exits.set(i)];
    for (std::uint32_t set = 0; set < sets; ++set) {
      const std::size_t before = to[set]->size();
      to[set]->resize(before + counts[set]);
      counts[set] = before;
    }
    for (std::size_t i = 0; i < exits.size(); ++i) {
      const std::uint32_t set = exits.set(i);
      (*to[set])[counts[set]++] = {azimuths[i], clamped(heights[i] - specular), rough_part(exits.order(i)),
                                   exits.weight(i), exits.way(i)};
    }
  }
}

class RoughTarget : public adaptive::SampledTarget {
 public:
  std::uint32_t parts(const adaptive::SliceDescription&) const override { return rough_parts; }

  void draw(const adaptive::SliceDescription& slice, float a, float b, std::uint64_t stream, std::uint32_t first,
            std::uint32_t count, std::vector<adaptive::SampledExit>& out) const override {
    std::vector<adaptive::SampledExit>* to = &out;
    draw_streams(slice.key, a, b, stream, first, count, {&to, 1});
  }

  void draw_sets(const adaptive::SliceDescription& slice, float a, float b, std::uint64_t stream, std::uint32_t first,
                 std::uint32_t count, std::array<std::vector<adaptive::SampledExit>, 4>& out) const override {
    std::array<std::vector<adaptive::SampledExit>*, 4> to;
    for (std::size_t set = 0; set < out.size(); ++set) to[set] = &out[set];
    draw_streams(slice.key, a, b, stream, first, count, to);
  }

  std::string model_name() const override { return make_elliptical_target()->model_name(); }
};

}  // namespace

float height_of(float theta) {
  const float cosine = std::cos(theta);
  if (!(cosine > 0)) return std::copysign(largest_height, theta);
  return clamped(std::asinh(std::sin(theta) / cosine));
}

float theta_of(float height) { return std::atan(std::sinh(height)); }

std::unique_ptr<adaptive::SampledTarget> make_rough_target() { return std::make_unique<RoughTarget>(); }

int coarse_azimuth_step(float eccentricity) {
  constexpr float nearly_round = 0.8f;
  if (!(eccentricity < 1)) return 0;
  return eccentricity < nearly_round ? 2 : 3;
}

adaptive::SliceDescription rough_slice(const FiberParameters& fiber) {
  adaptive::SliceDescription slice;
  slice.kind = adaptive::SliceKind::samples;
  slice.key.lobe = rough_slice_lobe;
  slice.key.parameters = {fiber.eta, fiber.eccentricity, fiber.roughness, fiber.tilt};
  std::ranges::copy(TracedParts::of(fiber).values(), slice.key.parameters.begin() + first_part);
  std::vector<double> thetas;
  for (int theta = 0; theta <= 85; theta += 5) thetas.push_back(theta);
  thetas.push_back(87.5);
  if (fiber.tilt > 0) {
    for (std::size_t i = thetas.size() - 1; i > 0; --i) slice.axis_a.push_back(static_cast<float>(-thetas[i] * degree));
  }
  for (const double theta : thetas) slice.axis_a.push_back(static_cast<float>(theta * degree));
  const int step = coarse_azimuth_step(fiber.eccentricity), phis = step > 0 ? 12 : 0;
  for (int i = 0; i <= phis; ++i) slice.axis_b.push_back(static_cast<float>(7.5 * i * degree));
  // The coarse grid is finer towards grazing, where lobes change fastest.
  adaptive::CoarseAxes grid;
  for (std::uint32_t i = 0; i < slice.axis_a.size(); ++i) {
    constexpr std::array coarse_thetas{0.0, 20.0, 40.0, 50.0, 60.0, 70.0, 75.0, 80.0, 87.5};
    const double theta = std::abs(static_cast<double>(slice.axis_a[i])) / degree;
    if (std::ranges::any_of(coarse_thetas, [theta](double one) { return std::abs(one - theta) < 1; }))
      grid.a.push_back(i);
  }
  grid.b.push_back(0);
  for (int i = step; i > 0 && i <= phis; i += step) grid.b.push_back(static_cast<std::uint32_t>(i));
  slice.coarse.push_back(std::move(grid));
  return slice;
}

RoughGrid::RoughGrid(const adaptive::SliceDescription& slice)
    : thetas_(slice.axis_a), last_phi_(static_cast<std::uint32_t>(slice.axis_b.size() - 1)) {}

FiberDirection RoughGrid::direction(std::uint32_t node) const {
  const std::uint32_t width = last_phi_ + 1, b = node % width;
  const auto quarter = static_cast<float>(std::numbers::pi / 2);
  return {thetas_[node / width],
          last_phi_ > 0 ? quarter * static_cast<float>(b) / static_cast<float>(last_phi_) : 0.0f};
}

RoughGrid::Along RoughGrid::along_thetas(float theta) const {
  const auto above = std::upper_bound(thetas_.begin() + 1, thetas_.end() - 1, theta);
  const float below = *(above - 1);
  return {static_cast<std::uint32_t>(above - thetas_.begin()) - 1, theta - below, *above - below};
}

RoughNode RoughGrid::choose(const FiberDirection& wr, float xi1, float xi2) const {
  RoughNode node;
  float theta = wr.theta;
  if (thetas_.front() >= 0 && theta < 0) {
    node.height_sign = -1;
    theta = -theta;
  }
  const Along along = along_thetas(theta);
  node.a = along.below;
  if (xi1 * along.step < along.past) ++node.a;
  const FoldedAzimuth folded = fold_azimuth(wr.phi);
  node.azimuth_sign = folded.sign;
  node.b = std::min(static_cast<std::uint32_t>(along_phis(folded.phi) + xi2), last_phi_);
  return node;
}

RoughGrid::Steps RoughGrid::steps(const FiberDirection& wr) const {
  const Along along = along_thetas(thetas_.front() >= 0 ? std::fabs(wr.theta) : wr.theta);
  const float at = along_phis(fold_azimuth(wr.phi).phi);
  return {std::clamp(along.past / along.step, 0.0f, 1.0f), 1 - (at - std::floor(at))};
}

}  // namespace tress::inline v0_2::fiber
