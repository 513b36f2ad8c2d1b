#include "models/fiber3d.h"

#include <array>
#include <cstddef>
#include <new>
#include <string>

#include "fiber/energy_table.h"
#include "fiber/event_constants.h"
#include "models/lobes/fiber_store.h"
#include "models/lobes/lobe_choice.h"
#include "models/rough/traced_path.h"

namespace tress::inline v0_2::fiber {
namespace {

class Fiber3d final : public FiberModel {
 public:
  explicit Fiber3d(Masked masked) : traced_(masked) {}
  std::string name() const override { return "fiber3d"; }
  bool evaluates() const override { return false; }
  std::size_t bytes() const override { return store_.bytes() + traced_.bytes(); }

  FiberId make_fiber(const FiberParameters& parameters) override {
    FiberParameters exact = parameters;
    exact.reflection_fresnel = ReflectionFresnel::exact;
    const FiberId id = store_.add(exact);
    if (id == traced_.size()) traced_.add(exact);
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
    select_lobes(event);
    new (place_of<TracedEvent>(event)) TracedEvent(traced_.begin(event, fiber.parameters, h));
    return event;
  }

  FiberSample sample_event(const FiberEvent& event, const std::array<float, 4>& u) const override {
    return traced_.sample(event.fiber, constants_in<TracedEvent>(event), store_[event.fiber].parameters, u);
  }

  FiberValue evaluate_event(const FiberEvent&, const FiberDirection&) const override { return {}; }

 private:
  FiberStore store_;
  TracedFibers traced_;
};

}  // namespace

std::unique_ptr<FiberModel> make_fiber3d(const ModelSettings& settings) {
  return std::make_unique<Fiber3d>(settings.loses_masked_light ? Masked::is_lost : Masked::meets_others);
}

}  // namespace tress::inline v0_2::fiber
