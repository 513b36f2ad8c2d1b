#include "fiber/fiber_ids.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstdint>
#include <glm/vec3.hpp>

#include "tress/base/random.h"
#include "tress/fiber/parameter_ranges.h"

namespace tress::inline v0_2::fiber {
namespace {

// Hashes the members that usually differ between fibers; operator== decides. 0 and -0 are equal and have one hash.
std::size_t hash_of(const FiberParameters& fiber) {
  std::uint64_t hash = 0;
  const auto add = [&](float value) { hash = mix_bits(hash + std::bit_cast<std::uint32_t>(value + 0.0f)); };
  const auto add_color = [&](const glm::vec3& color) {
    for (int c = 0; c < 3; ++c) add(color[c]);
  };
  for (const float value : {fiber.eta, fiber.eccentricity, fiber.roughness, fiber.tilt}) add(value);
  for (const float value : {fiber.medulla_radius, fiber.medulla_scattering, fiber.medulla_asymmetry}) add(value);
  for (const float value : {fiber.medulla_absorption, fiber.cortex_scattering, fiber.cortex_asymmetry}) add(value);
  add(fiber.wetness);
  add_color(fiber.sigma_a);
  for (const auto& sigma : fiber.azimuthal_sigma) add(sigma.value_or(-1.0f));
  for (const auto& lambda : fiber.longitudinal_lambda) add(lambda.value_or(-1.0f));
  add(fiber.published_widths ? fiber.published_widths->longitudinal_lambda[0] : -1.0f);
  add(fiber.split_glint ? 1.0f : 0.0f);
  add(fiber.energy_path_share);
  for (const glm::vec3& gain : fiber.gain) add_color(gain);
  return static_cast<std::size_t>(hash);
}

}  // namespace

std::pair<FiberId, bool> FiberIds::find_or_add(const FiberParameters& parameters) {
  assert(out_of_range(parameters) == nullptr);
  const std::size_t hash = hash_of(parameters);
  const auto [first, last] = id_of_hash_.equal_range(hash);
  const auto found = std::find_if(first, last, [&](const auto& entry) { return fibers_[entry.second] == parameters; });
  if (found != last) return {found->second, false};
  const auto id = static_cast<FiberId>(fibers_.size());
  fibers_.push_back(parameters);
  id_of_hash_.emplace(hash, id);
  return {id, true};
}

}  // namespace tress::inline v0_2::fiber
