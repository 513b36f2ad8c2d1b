#include "models/rough/traced_path.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <glm/exponential.hpp>
#include <numbers>
#include <optional>

#include "base/color.h"
#include "fiber/cross_section.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr std::uint64_t estimate_purpose = 0x657374696d617465ull;
constexpr std::uint64_t offset_purpose = 0x6f666673657473ull;

/// GLINT's share of the light that a fiber returns as TRT, by the offset where light enters; 0 if it is not separate.
class GlintShares {
 public:
  GlintShares(const FiberParameters& parameters, const FiberDirection& wr) {
    if (!parameters.split_glint) return;
    section_.emplace(static_cast<double>(parameters.eta), static_cast<double>(parameters.eccentricity),
                     static_cast<double>(wr.phi), static_cast<double>(wr.theta));
    sigma_ = static_cast<double>(azimuthal_sigmas(parameters)[1]);
  }
  float at(float h) const {
    return section_ ? static_cast<float>(section_->glint_share(static_cast<double>(h), sigma_)) : 0;
  }

 private:
  std::optional<CrossSection> section_;
  double sigma_ = 0;
};

}  // namespace

float TracedFibers::any_offset(const FiberEvent& event) {
  RandomStream random(bits_of(event.xi1, event.xi2), bits_of(event.wr.theta, event.wr.phi), offset_purpose);
  return 2 * random.next() - 1;
}

TracedEvent TracedFibers::begin(const FiberEvent& event, const FiberParameters& fiber, float h) const {
  const float offset = std::clamp(h, -1.0f, 1.0f);
  return {fibers_[event.fiber].entry(event.wr, offset), GlintShares(fiber, event.wr).at(offset),
          RandomStream(bits_of(event.xi1, event.xi2), bits_of(event.wr.theta, event.wr.phi),
                       std::bit_cast<std::uint32_t>(offset))
              .next_bits()};
}

float TracedFibers::kept_inside(const FiberEvent& event) {
  constexpr auto r = static_cast<std::size_t>(Lobe::r);
  float all = 0;
  for (const glm::vec3& lobe : event.energy) all += std::max({lobe.r, lobe.g, lobe.b});
  const glm::vec3& reflected = event.energy[r];
  const float of_r = std::max({reflected.r, reflected.g, reflected.b});
  return std::clamp((all - of_r) / std::max(1 - of_r, 1e-3f), 0.02f, 1.0f);
}

FiberSample TracedFibers::sample(FiberId id, const TracedEvent& event, const FiberParameters& fiber,
                                 const std::array<float, 4>& u) const {
  RandomStream random(bits_of(u[0], u[1]), bits_of(u[2], u[3]), event.seed);
  const RoughExit exit = fibers_[id].trace(event.entry, u, random, event.kept_inside);
  FiberSample sample = sample_of(exit, exit.throughput, event, fiber);
  sample.value.exit = exit.place;
  return sample;
}

HeardSample TracedFibers::listen(FiberId id, const TracedEvent& event, const FiberParameters& fiber,
                                 const std::array<float, 4>& u, std::uint64_t key) const {
  RandomStream random(bits_of(u[0], u[1]), bits_of(u[2], u[3]) + key, event.seed);
  const RoughExit exit = clear_[id].trace(event.entry, u, random);
  return {sample_of(exit, exit.throughput * glm::exp(-fiber.sigma_a * exit.way), event, fiber), exit.order,
          exit.throughput.x, exit.way};
}

FiberSample TracedFibers::sample_of(const RoughExit& exit, const glm::vec3& throughput, const TracedEvent& event,
                                    const FiberParameters& fiber) {
  FiberSample sample;
  sample.wi = exit.angles();
  sample.lobe = static_cast<Lobe>(std::min(exit.order, static_cast<int>(Lobe::residual)));
  sample.value.pdf = 1;
  sample.way = exit.way;
  const auto give = [&](Lobe lobe, float share) {
    const auto i = static_cast<std::size_t>(lobe);
    sample.value.s[i] = fiber.gain[i] * (throughput * share);
  };
  const float glint = sample.lobe == Lobe::trt ? event.glint_share : 0;
  give(sample.lobe, 1 - glint);
  if (glint > 0) give(Lobe::glint, glint);
  return sample;
}

float TracedFibers::balance(const FiberParameters& fiber, const EnergyTable& energies, Offset offset) {
  constexpr float usual_theta = 0.3f, usual_phi = 0.8f, share_of_second_moment = 0.2f;
  float reflected = 0, all = 0;
  const LobeColors energy = energies.at(usual_phi, usual_theta).colored;
  for (std::size_t p = 0; p < lobe_count; ++p) {
    const float luminous = luminance(energy[p]);
    all += luminous;
    if (p == static_cast<std::size_t>(Lobe::r)) reflected = luminous;
  }
  const float share = all > 0 ? reflected / all : 1, slopes = fiber.roughness * fiber.roughness;
  const float of_reflection = 1 / (2 * slopes), of_exit = 2 / (slopes * (fiber.eta - 1) * (fiber.eta - 1));
  const float of_one_path = (offset == Offset::any ? share * of_reflection : 0.0f) + (1 - share) * of_exit;
  const float of_sphere = share_of_second_moment * of_one_path / (offset == Offset::any ? paths_of_estimate : 1);
  return std::max(of_sphere, 1.0f) / (4 * std::numbers::pi_v<float>);
}

void TracedFibers::recolor(const FiberSample& drawn, const FiberParameters& fiber, std::span<const float> sigma_a,
                           std::span<float> s) {
  for (std::size_t p = 0; p < lobe_count; ++p) {
    int c = -1;  // the channel that the fiber has left the most of
    for (const int other : {0, 1, 2}) {
      if (drawn.value.s[p][other] > 0 && (c < 0 || fiber.sigma_a[other] < fiber.sigma_a[c])) c = other;
    }
    if (c < 0) continue;
    const float own = drawn.value.s[p][c] / fiber.gain[p][c] * luminance(fiber.gain[p]);
    for (std::size_t i = 0; i < s.size(); ++i) s[i] += own * std::exp((fiber.sigma_a[c] - sigma_a[i]) * drawn.way);
  }
}

FiberValue TracedFibers::estimate(const FiberEvent& event, const TracedEvent& traced, const FiberParameters& fiber,
                                  const FiberDirection& wi, Offset offset) const {
  return estimate(fibers_[event.fiber], event, traced, fiber, wi, offset);
}

void TracedFibers::add_estimate(const FiberEvent& event, const TracedEvent& traced, const FiberParameters& fiber,
                                const FiberDirection& wi, Offset offset, std::span<const float> sigma_a,
                                std::span<float> s) const {
  FiberParameters colored = fiber;
  for (glm::vec3& gain : colored.gain) gain = glm::vec3(luminance(gain));
  for (std::size_t first = 0; first < s.size(); first += 3) {
    const auto at = [&](std::size_t i) { return std::min(first + i, s.size() - 1); };
    colored.sigma_a = {sigma_a[at(0)], sigma_a[at(1)], sigma_a[at(2)]};
    const glm::vec3 all = estimate(RoughFiber(colored, masked_), event, traced, colored, wi, offset).total();
    for (int c = 0; c < 3; ++c) s[at(static_cast<std::size_t>(c))] = all[c];
  }
}

FiberValue TracedFibers::estimate(const RoughFiber& rough, const FiberEvent& event, const TracedEvent& traced,
                                  const FiberParameters& fiber, const FiberDirection& wi, Offset offset) const {
  RandomStream random(bits_of(wi.theta, wi.phi), traced.seed, estimate_purpose);
  constexpr auto trt = static_cast<std::size_t>(Lobe::trt), glint = static_cast<std::size_t>(Lobe::glint);
  FiberValue value;
  const auto add_path = [&](const RoughEntry& entry, float glint_share, float share) {
    RoughFiber::FacetNumbers u;
    for (std::array<float, 2>& pair : u) {
      for (float& number : pair) number = random.next();
    }
    const LobeColors s = offset == Offset::known ? rough.estimate(entry, wi, u, random, value.exit)
                                                 : rough.estimate(entry, wi, u, random);
    for (std::size_t p = 0; p < lobe_count; ++p) value.s[p] += share * s[p];
    const glm::vec3 of_glint = share * glint_share * s[trt];
    value.s[trt] -= of_glint;
    value.s[glint] += of_glint;
  };
  if (offset == Offset::known) {
    add_path(traced.entry, traced.glint_share, 1);
  } else {
    const GlintShares glints(fiber, event.wr);
    constexpr float share = 1 / static_cast<float>(paths_of_estimate);
    const float shift = random.next();
    for (int i = 0; i < paths_of_estimate; ++i) {
      const float h = 2 * share * (static_cast<float>(i) + shift) - 1;
      add_path(rough.entry(event.wr, h), glints.at(h), share);
    }
  }
  for (std::size_t p = 0; p < lobe_count; ++p) value.s[p] *= fiber.gain[p];
  return value;
}

}  // namespace tress::inline v0_2::fiber
