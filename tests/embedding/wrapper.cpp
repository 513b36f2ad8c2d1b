// A C++17 host by tress.hpp: elliptical fibers in a furnace, a target that is a class, and what a mistake gets.
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tress/tress.hpp"

using namespace tress::c;

#define EXPECT(what) \
  if (!(what)) return std::fprintf(stderr, "line %d: %s; last error: %s\n", __LINE__, #what, tress_last_error()), 1

namespace {

class Beam final : public Target {
 public:
  std::string name() const override { return "beam-1"; }
  void trace(const tress_place& place, std::vector<tress_ray>& out) const override {
    if (throws) throw std::runtime_error("no rays today");
    out.push_back({place.a, place.b, 0});
  }
  bool throws = false;
};

int furnace() {
  Service service = Service::for_fibers();
  Fibers fibers(service, TRESS_ELLIPTICAL);
  EXPECT(service && fibers);
  Fiber clear;
  for (float& sigma : clear.sigma_a) sigma = 0;
  std::uint32_t id = 0;
  EXPECT(fibers.add(clear, &id));
  EXPECT(fibers.bytes() > 0);
  std::mt19937 engine(7);
  std::uniform_real_distribution<float> next;
  constexpr int events = 2000;
  double mean = 0, squares = 0;
  tress_report report{};
  for (int pass = 0; pass < 6; ++pass) {
    mean = squares = 0;
    for (int i = 0; i < events; ++i) {
      const tress_event event = fibers.begin(id, {0.3f, 0.8f}, next(engine), next(engine), 2 * next(engine) - 1);
      const std::array<float, 4> u{next(engine), next(engine), next(engine), next(engine)};
      const tress_fiber_sample drawn = fibers.sample(event, u);
      const tress_fiber_value again = fibers.evaluate(event, drawn.direction);
      EXPECT(fibers.takes_lights(event) && again.pdf == drawn.at.pdf && again.value[1] == drawn.at.value[1]);
      const float grey[2] = {0, 1};
      float s[2], weights[2];
      EXPECT(fibers.pdf(event, drawn.direction) == again.pdf);
      EXPECT(fibers.evaluate_spectrum(event, drawn.direction, grey, 2, s) == 0 && s[1] == 0);  // of TRESS_ROUGH alone
      EXPECT(fibers.sample_spectrum(event, u, grey, 2, weights).at.pdf == 0 && weights[1] == 0);
      mean += double{drawn.weight[1]} / events;
      squares += double{drawn.weight[1]} * double{drawn.weight[1]} / events;
    }
    EXPECT(service.publish(events, &report));
  }
  const tress_fiber_sample unbegun = fibers.sample_mean(id, {0.3f, 0.8f}, {0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f});
  EXPECT(unbegun.at.pdf > 0 && fibers.mean(id, {0.3f, 0.8f}, unbegun.direction).pdf == unbegun.at.pdf);
  // Five standard errors, and 0.01 for the fit and the grid.
  const double error = std::sqrt(std::fmax(0, squares - mean * mean) / events);
  std::printf("furnace %.4f +- %.4f\n", mean, error);
  EXPECT(std::fabs(mean - 1) < 5 * error + 0.01 && report.converged_queries > 0);
  return 0;
}

int target() {
  Beam beam;
  Service service(beam);
  const float axis[2] = {0, 1};
  Slice slice;
  slice.axis_a = slice.axis_b = axis;
  slice.count_a = slice.count_b = 2;
  std::uint32_t id = 9;
  EXPECT(service.add_slice(slice, &id) && id == 0);
  beam.throws = true;
  EXPECT(service.evaluate({id, 1, 1}, 1.1f).density == 0);
  const Status publish = service.publish();
  EXPECT(publish.code() == TRESS_MISUSE && std::strstr(publish.message(), "Target::trace"));
  beam.throws = false;
  EXPECT(service.evaluate({id, 1, 1}, 1.1f).density > 1 && service.pdf({id, 1, 1}, 1.1f) > 0);
  EXPECT(service.mean(id, 1, 1, 1.1f).pdf > 0 && !service.publish_pays());
  const Status wrong = service.credit({id, 2, 1}, 1);
  EXPECT(!wrong && wrong.code() == TRESS_INVALID_ARGUMENT && *wrong.message() != '\0');

  Service moved = std::move(service);
  EXPECT(moved && !service && service.publish().code() == TRESS_INVALID_ARGUMENT);
  EXPECT(!Fibers(moved, TRESS_ROUGH) && !Fibers(service, TRESS_ROUGH) && Fibers(service, TRESS_ROUGH, TRESS_EXACT));
  return 0;
}

}  // namespace

int main() { return furnace() != 0 || target() != 0 ? 1 : 0; }
