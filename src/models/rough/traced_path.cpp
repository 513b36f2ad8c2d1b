#include "models/rough/traced_path.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <optional>

#include "fiber/cross_section.h"
#include "tress/base/random.h"

namespace tress::fiber {
namespace {

constexpr std::uint64_t estimate_purpose = 0x657374696d617465ull;
constexpr std::uint64_t offset_purpose = 0x6f666673657473ull;

std::uint64_t bits_of(float a, float b) {
  return (std::uint64_t{std::bit_cast<std::uint32_t>(a)} << 32) | std::bit_cast<std::uint32_t>(b);
}

/// GLINT's share of what a fiber returns as TRT, by the offset where light enters; 0 where it is not told apart.
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

FiberSample TracedFibers::sample(FiberId id, const TracedEvent& event, const FiberParameters& fiber,
                                 const std::array<float, 4>& u) const {
  RandomStream random(bits_of(u[0], u[1]), bits_of(u[2], u[3]), event.seed);
  const RoughExit exit = fibers_[id].trace(event.entry, u, random);
  FiberSample sample;
  sample.wi = exit.angles();
  sample.lobe = static_cast<Lobe>(std::min(exit.order, static_cast<int>(Lobe::residual)));
  sample.value.pdf = 1;
  const auto give = [&](Lobe lobe, float share) {
    const auto i = static_cast<std::size_t>(lobe);
    sample.value.s[i] = fiber.gain[i] * (exit.throughput * share);
  };
  const float glint = sample.lobe == Lobe::trt ? event.glint_share : 0;
  give(sample.lobe, 1 - glint);
  if (glint > 0) give(Lobe::glint, glint);
  return sample;
}

FiberValue TracedFibers::estimate(const FiberEvent& event, const TracedEvent& traced, const FiberParameters& fiber,
                                  const FiberDirection& wi) const {
  RandomStream random(bits_of(wi.theta, wi.phi), traced.seed, estimate_purpose);
  const RoughFiber& rough = fibers_[event.fiber];
  const GlintShares glints(fiber, event.wr);
  constexpr auto trt = static_cast<std::size_t>(Lobe::trt), glint = static_cast<std::size_t>(Lobe::glint);
  constexpr float share = 1 / static_cast<float>(paths_of_estimate);
  const float shift = random.next();
  FiberValue value;
  for (int i = 0; i < paths_of_estimate; ++i) {
    RoughFiber::FacetNumbers u;
    for (std::array<float, 2>& pair : u) {
      for (float& number : pair) number = random.next();
    }
    const float h = 2 * share * (static_cast<float>(i) + shift) - 1;
    const LobeColors s = rough.estimate(rough.entry(event.wr, h), wi, u, random);
    for (std::size_t p = 0; p < lobe_count; ++p) value.s[p] += share * s[p];
    const glm::vec3 of_glint = share * glints.at(h) * s[trt];
    value.s[trt] -= of_glint;
    value.s[glint] += of_glint;
  }
  for (std::size_t p = 0; p < lobe_count; ++p) value.s[p] *= fiber.gain[p];
  return value;
}

}  // namespace tress::fiber
