#include "models/fiber3d.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <new>
#include <string>
#include <vector>

#include "base/color.h"
#include "fiber/cross_section.h"
#include "fiber/energy_table.h"
#include "fiber/event_constants.h"
#include "fiber/longitudinal.h"
#include "fiber/rough_fiber.h"
#include "models/elliptical/fiber_store.h"
#include "tress/adaptive/mixture.h"
#include "tress/base/random.h"

namespace tress::fiber {
namespace {

struct EventConstants {
  RoughEntry entry;
  float glint_share;   ///< of TRT
  std::uint64_t seed;  ///< by all numbers of the event
};

std::uint64_t bits_of(float a, float b) {
  return (std::uint64_t{std::bit_cast<std::uint32_t>(a)} << 32) | std::bit_cast<std::uint32_t>(b);
}

class Fiber3d final : public FiberModel {
 public:
  std::string name() const override { return "fiber3d"; }
  bool evaluates() const override { return false; }
  std::size_t bytes() const override { return store_.bytes() + traced_.capacity() * sizeof(RoughFiber); }

  FiberId add_fiber(const FiberParameters& parameters) override {
    FiberParameters exact = parameters;
    exact.reflection_fresnel = ReflectionFresnel::exact;
    const FiberId id = store_.add(exact);
    if (id == traced_.size()) traced_.emplace_back(exact);
    return id;
  }

  FiberEvent make_event(FiberId id, const FiberDirection& wr, float xi1, float xi2, float h) const override {
    const FiberRecord& fiber = store_[id];
    FiberEvent event;
    event.fiber = id;
    event.wr = clamped(wr);
    event.xi1 = xi1;
    event.xi2 = xi2;
    event.energy = fiber.energies->at(event.wr.phi, event.wr.theta).colored;
    float sum = 0;
    for (std::size_t p = 0; p < lobe_count; ++p) sum += event.selection[p] = luminance(event.energy[p]);
    if (!(sum > 0)) event.selection[0] = sum = 1;
    for (float& probability : event.selection) probability /= sum;
    const float offset = std::clamp(h, -1.0f, 1.0f);
    new (place_of<EventConstants>(event)) EventConstants{
        traced_[id].entry(event.wr, offset), glint_share(fiber, event.wr, offset),
        RandomStream(bits_of(xi1, xi2), bits_of(event.wr.theta, event.wr.phi), std::bit_cast<std::uint32_t>(offset))
            .next_bits()};
    return event;
  }

  FiberSample sample(const FiberEvent& event, const std::array<float, 4>& u) const override {
    const auto& constants = constants_in<EventConstants>(event);
    RandomStream random(bits_of(u[0], u[1]), bits_of(u[2], u[3]), constants.seed);
    const RoughExit exit = traced_[event.fiber].trace(constants.entry, u, random);
    FiberSample sample;
    sample.wi = exit.angles();
    sample.lobe = static_cast<Lobe>(std::min(exit.order, static_cast<int>(Lobe::residual)));
    sample.value.pdf = 1;
    const LobeColors& gain = store_[event.fiber].parameters.gain;
    const auto give = [&](Lobe lobe, float share) {
      const auto i = static_cast<std::size_t>(lobe);
      sample.value.s[i] = gain[i] * (exit.throughput * share);
    };
    const float glint = sample.lobe == Lobe::trt ? constants.glint_share : 0;
    give(sample.lobe, 1 - glint);
    if (glint > 0) give(Lobe::glint, glint);
    return sample;
  }

  FiberValue evaluate(const FiberEvent&, const FiberDirection&) const override { return {}; }

 private:
  static float glint_share(const FiberRecord& fiber, const FiberDirection& wr, float h) {
    const FiberParameters& parameters = fiber.parameters;
    if (!parameters.split_glint) return 0;
    const CrossSection section(static_cast<double>(parameters.eta), static_cast<double>(parameters.eccentricity),
                               static_cast<double>(wr.phi), static_cast<double>(wr.theta));
    return static_cast<float>(
        section.glint_share(static_cast<double>(h), static_cast<double>(azimuthal_sigmas(parameters)[1])));
  }

  FiberStore store_{nullptr};
  std::vector<RoughFiber> traced_;  ///< by FiberId
};

}  // namespace

std::unique_ptr<FiberModel> make_fiber3d(const ModelSettings& /*settings*/) { return std::make_unique<Fiber3d>(); }

}  // namespace tress::fiber
