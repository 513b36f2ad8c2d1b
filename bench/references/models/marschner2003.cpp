#include "references/models/marschner2003.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <utility>
#include <vector>

#include "base/pi.h"
#include "fiber/energy_table.h"
#include "fiber/event_constants.h"
#include "fiber/fiber_ids.h"
#include "fiber/lobe_widths.h"
#include "fiber/longitudinal.h"
#include "fiber/row_axes.h"
#include "models/registry.h"
#include "references/models/marschner_lobes.h"
#include "references/models/marschner_table.h"
#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::fiber {
namespace {

/// Standard deviation of the logistic of scale 1, pi/sqrt(3), and the scale that makes LongitudinalLobe's Gaussian one
/// of standard deviation 1.
constexpr float logistic_deviation = 1.8137994f, scale_of_unit_gaussian = 0.66794038f;
constexpr float narrowest_caustic = 2 * pi_f / 180, widest_caustic = pi_f / 4;

MarschnerShape shape_of(const FiberParameters& parameters) {
  MarschnerShape shape{static_cast<double>(parameters.eta), static_cast<double>(parameters.eccentricity), {}};
  shape.caustics.width =
      static_cast<double>(std::clamp(azimuthal_sigmas(parameters)[1], narrowest_caustic, widest_caustic));
  return shape;
}

/// What a fiber has beside its parameters.
struct FiberRecord {
  MarschnerShape shape;
  LobeWidths widths;
  glm::vec3 sigma_a{0.0f};  ///< per radius of the circle
  std::shared_ptr<const MarschnerTable> table;
  MarschnerEnergies energy;
};

struct EventConstants {
  LongitudinalLobes longitudinal;  ///< normalised; lane l: of MarschnerLobe l
  Float4 beta, alpha;              ///< likewise
  FoldedAzimuth fold;
};

class Marschner2003 final : public FiberModel {
 public:
  std::string name() const override { return "marschner2003"; }

  FiberId make_fiber(const FiberParameters& parameters) override {
    const auto [id, is_new] = ids_.find_or_add(parameters);
    if (!is_new) return id;
    FiberRecord fiber;
    fiber.shape = shape_of(parameters);
    fiber.widths = LobeWidths(parameters);
    fiber.sigma_a = sigma_a_per_radius(parameters);
    fiber.table = tables_.find(fiber.shape);
    fiber.energy = marschner_energies(*fiber.table, parameters);
    fibers_.push_back(std::move(fiber));
    return id;
  }

  FiberEvent make_event(FiberId id, const FiberDirection& wr, float xi1, float xi2, float /*h*/) const override {
    const FiberRecord& fiber = fibers_[id];
    FiberEvent event;
    event.fiber = id;
    event.wr = clamped(wr);
    event.xi1 = xi1;
    event.xi2 = xi2;
    const FoldedAzimuth fold = fold_azimuth(event.wr.phi);
    const LobeWidths::At widths = fiber.widths.at(event.wr.theta);
    const Float4 alpha = by_marschner_lobe(widths.tilt);
    const Float4 beta =
        max4(logistic_deviation * by_marschner_lobe(widths.lambda), splat(smallest_lambda / scale_of_unit_gaussian));
    new (place_of<EventConstants>(event)) EventConstants{
        {event.wr.theta, alpha, beta * scale_of_unit_gaussian, LongitudinalShape::gaussian}, beta, alpha, fold};
    begin_lobes(ids_[id], *fiber.table, fiber.energy, fold.phi, event);
    return event;
  }

  FiberSample sample_event(const FiberEvent& event, const std::array<float, 4>& u) const override {
    const FiberRecord& fiber = fibers_[event.fiber];
    const EventConstants& constants = constants_in<EventConstants>(event);
    FiberSample sample;
    const std::size_t l = draw_lobe(event, u[0]);
    const auto lobe = static_cast<MarschnerLobe>(l);
    sample.lobe = layer_of(ids_[event.fiber], l);
    sample.wi.theta = constants.longitudinal.lane(static_cast<int>(l)).sample(u[1]);
    const MarschnerTable::Place place =
        fiber.table->place(lobe, constants.fold.phi, 0.5f * (event.wr.theta - sample.wi.theta));
    sample.wi.phi = constants.fold.absolute(fiber.table->sample(lobe, place, u[3], u[2]), event.wr.phi);
    sample.value = evaluate(event, sample.wi);
    return sample;
  }

  FiberValue evaluate_event(const FiberEvent& event, const FiberDirection& direction) const override {
    const FiberRecord& fiber = fibers_[event.fiber];
    const FiberParameters& parameters = ids_[event.fiber];
    const EventConstants& constants = constants_in<EventConstants>(event);
    const FiberDirection wi = clamped(direction);
    const float theta_d = 0.5f * (event.wr.theta - wi.theta), theta_h = 0.5f * (event.wr.theta + wi.theta);
    const float x = constants.fold.relative(wi.phi, event.wr.phi);
    // At most 2, and 1 to rounding where both vanish.
    const float ratio = std::min(std::cos(wi.theta) / std::cos(theta_d), 2.0f);
    const Float4 drawn = constants.longitudinal.density(wi.theta), z = (theta_h - constants.alpha) / constants.beta;
    const Float4 printed = (0.5f / std::sqrt(2 * pi_f)) * exp_of_negative(-0.5f * z * z) / constants.beta;
    FiberValue value;
    for (std::size_t l = 0; l < marschner_lobes; ++l) {
      const float chosen = selection_of(event, l);
      if (!(chosen > 0)) continue;
      const auto lobe = static_cast<MarschnerLobe>(l);
      const MarschnerPaths paths = marschner_paths(fiber.shape, lobe, static_cast<double>(constants.fold.phi),
                                                   static_cast<double>(theta_d), static_cast<double>(x));
      const glm::vec3 n = marschner_density(paths, fiber.sigma_a);
      value.s[static_cast<std::size_t>(layer_of(parameters, l))] +=
          gain_of(parameters, l) * n * (printed[static_cast<int>(l)] * ratio * ratio);
      const MarschnerTable::Place place = fiber.table->place(lobe, constants.fold.phi, theta_d);
      value.pdf += chosen * drawn[static_cast<int>(l)] * fiber.table->density(lobe, place, x);
    }
    value.pdf = std::max(value.pdf, smallest_pdf);
    return value;
  }

  std::size_t bytes() const override {
    std::size_t bytes = tables_.bytes();
    for (const FiberRecord& fiber : fibers_) {
      bytes += sizeof(FiberRecord) + sizeof(FiberParameters);
      for (const auto& energy : fiber.energy) bytes += energy.size() * sizeof(glm::vec3);
    }
    return bytes;
  }

 private:
  FiberIds ids_;
  std::vector<FiberRecord> fibers_;
  MarschnerTables tables_;
};

}  // namespace

std::unique_ptr<FiberModel> make_marschner2003(const ModelSettings&) { return std::make_unique<Marschner2003>(); }

}  // namespace tress::inline v0_2::fiber
