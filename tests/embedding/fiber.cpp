// The elliptical fiber BCSDF without the renderer: sample, evaluate, publish, until the rows are learned.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <glm/vec3.hpp>

#include "tress/adaptive/service.h"
#include "tress/base/random.h"
#include "tress/fiber/elliptical_model.h"

using namespace tress;
using namespace tress::fiber;

int main() {
  const auto target = make_elliptical_target();
  adaptive::Service service(adaptive::Options{}, *target);
  const auto made = make_elliptical_model(Estimator::fitted, &service);  // the service outlives the model
  if (!made) return 1;                                                   // made.error() says what the service is not
  const auto& model = *made;
  FiberParameters white;         // eta 1.55, eccentricity 0.85, roughness 0.2, tilt 3 degrees
  white.sigma_a = glm::vec3(0);  // absorbs nothing: in a furnace, light of 1 from everywhere, it must look like 1
  const FiberId id = model->add_fiber(white);  // between passes; equal parameters give the same id
  // Angles about the fiber, radians: theta from the normal plane towards the tangent, phi from the major axis.
  const FiberDirection camera{0.3f, 0.8f}, lamp{-0.2f, -2.2f};

  constexpr int events = 4000;
  double share = 0, furnace = 0, error = 0, lit = 0;
  for (std::uint64_t pass = 0; pass < 12; ++pass) {
    double sum = 0, squares = 0, lamps = 0;
    for (std::uint64_t i = 0; i < events; ++i) {  // any number of threads may do this
      RandomStream random(7, pass, i);
      const float xi1 = random.next(), xi2 = random.next(), h = 2 * random.next() - 1;
      const float importance = 1;  // luminance of the path's throughput so far
      const FiberEvent event = model->begin(id, camera, xi1, xi2, h, importance);
      const FiberSample drawn = model->sample(event, {random.next(), random.next(), random.next(), random.next()});
      // The weight of the sampled direction, S/Q, by color channel; green here.
      const double weight = drawn.value.pdf > 0 ? drawn.value.total().y / drawn.value.pdf : 0;
      sum += weight;
      squares += weight * weight;
      lamps += model->evaluate(event, lamp).total().y;  // S, per dtheta dphi; f = S / cos^2 theta_i
    }
    const adaptive::PassReport report = service.publish();
    share =
        static_cast<double>(report.converged_queries) / static_cast<double>(std::max<std::uint64_t>(1, report.queries));
    furnace = sum / events;
    error = std::sqrt(std::max(0.0, squares / events - furnace * furnace) / events);
    lit = lamps / events;
    std::printf("pass %2d: converged share %.3f, furnace %.4f +- %.4f, towards the lamp %.4f\n", static_cast<int>(pass),
                share, furnace, error, lit);
  }
  // Five standard errors: one run in a million fails by chance, and the seed is fixed. 0.01 is for the fit and the
  // grid.
  return share > 0.9 && std::abs(furnace - 1) < 5 * error + 0.01 && lit > 0 ? 0 : 1;
}
