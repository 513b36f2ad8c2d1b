#include "references/models/ou2012.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <new>
#include <numbers>
#include <utility>
#include <vector>

#include "base/color.h"
#include "base/pi.h"
#include "fiber/circle_ray.h"
#include "fiber/energy_table.h"
#include "fiber/event_constants.h"
#include "fiber/fiber_ids.h"
#include "fiber/longitudinal.h"
#include "fiber/reflection.h"
#include "fiber/surface_fresnel.h"
#include "models/lobes/lobe_choice.h"
#include "references/models/ou2012_lobes.h"
#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr std::size_t r = 0, tt = 1, trt = 2, glint = 3;
constexpr std::array<Lobe, 4> lobes{Lobe::r, Lobe::tt, Lobe::trt, Lobe::glint};
constexpr std::size_t lobe_of(std::size_t p) { return static_cast<std::size_t>(lobes[p]); }

float half_cosine(float phi) { return std::max(std::cos(0.5f * phi), 0.0f); }

/// E_R of N_R/4 over theta_r: the mean of F.
class MeanFresnel {
 public:
  MeanFresnel(float eta, ReflectionFresnel kind) {
    for (std::size_t i = 0; i < mean_.size(); ++i) {
      const float cosine = static_cast<float>(i) / (static_cast<float>(mean_.size()) - 1);
      mean_[i] = reflected_energy(kind, eta, 1, std::acos(cosine), 0);
    }
  }
  float at(float theta_r) const {
    const float x = std::clamp(std::cos(theta_r), 0.0f, 1.0f) * (static_cast<float>(mean_.size()) - 1);
    const auto i = std::min(static_cast<std::size_t>(x), mean_.size() - 2);
    const float part = x - static_cast<float>(i);
    return (1 - part) * mean_[i] + part * mean_[i + 1];
  }

 private:
  std::array<float, 64> mean_;
};

/// What does not depend on the direction. Longitudinal: R, TT, TRT; GLINT has that of TRT.
struct Fiber {
  std::array<LongitudinalBump, 3> longitudinal;
  std::array<std::shared_ptr<const LongitudinalMasses>, 3> masses;
  std::array<glm::vec3, 4> color;         ///< C_p times the gain
  AzimuthalBump about_pi, about_caustic;  ///< N_TT, N_GLINT
  std::shared_ptr<const MeanFresnel> mean_fresnel;
};

struct EventConstants {
  std::array<LongitudinalLobe, 3> proposal;
  SurfaceFresnel fresnel;
  std::array<float, 4> selection;
};

class Ou2012 final : public FiberModel {
 public:
  std::string name() const override { return "ou2012"; }

  FiberId make_fiber(const FiberParameters& parameters) override {
    const auto [id, is_new] = ids_.find_or_add(parameters);
    if (!is_new) return id;
    const auto sigmas = azimuthal_sigmas(parameters);
    const CircleFarField far(parameters.eta, parameters.sigma_a * circle_radius(parameters.eccentricity), sigmas[1]);
    Fiber fiber;
    fiber.about_pi = AzimuthalBump(pi_f, std::hypot(far.deviation_tt, sigmas[0]));
    fiber.about_caustic = AzimuthalBump(far.caustic, sigmas[1]);
    for (std::size_t p = 0; p < 3; ++p) {
      const int order = static_cast<int>(p);
      const float beta = pi_f * std::numbers::inv_sqrt3_v<float> * longitudinal_lambda(parameters, order, 0);
      fiber.longitudinal[p] = {lobe_tilt(parameters, order), beta};
      auto& masses = masses_[{fiber.longitudinal[p].tilt, beta}];
      if (!masses) masses = std::make_shared<const LongitudinalMasses>(fiber.longitudinal[p]);
      fiber.masses[p] = masses;
    }
    const auto upright = [&](std::size_t p) { return LongitudinalBump{0, fiber.longitudinal[p].beta}.mass(0); };
    const auto& gain = parameters.gain;
    const std::size_t glint_gain = lobe_of(parameters.split_glint ? glint : trt);
    fiber.color[r] = gain[lobe_of(r)] / (4 * upright(0));
    fiber.color[tt] = gain[lobe_of(tt)] * far.tt / (fiber.about_pi.mass() * upright(1));
    fiber.color[trt] = gain[lobe_of(trt)] * far.trt / (4 * upright(2));
    fiber.color[glint] = gain[glint_gain] * far.glint / (fiber.about_caustic.mass() * upright(2));
    auto& mean_fresnel = mean_fresnel_[{parameters.eta, parameters.reflection_fresnel}];
    if (!mean_fresnel)
      mean_fresnel = std::make_shared<const MeanFresnel>(parameters.eta, parameters.reflection_fresnel);
    fiber.mean_fresnel = mean_fresnel;
    fibers_.push_back(std::move(fiber));
    return id;
  }

  FiberEvent make_event(FiberId id, const FiberDirection& wr, float xi1, float xi2, float /*h*/) const override {
    const Fiber& fiber = fibers_[id];
    const FiberParameters& parameters = ids_[id];
    FiberEvent event;
    event.fiber = id;
    event.wr = clamped(wr);
    event.xi1 = xi1;
    event.xi2 = xi2;
    const float theta_r = event.wr.theta;
    const auto proposal = [&](std::size_t p) {
      const LongitudinalBump& bump = fiber.longitudinal[p];
      return LongitudinalLobe(theta_r, bump.tilt, bump.beta * lambda_of_cauchy, LongitudinalShape::cauchy);
    };
    auto* constants = new (place_of<EventConstants>(event))
        EventConstants{{proposal(0), proposal(1), proposal(2)},
                       SurfaceFresnel(parameters.eta, theta_r, parameters.reflection_fresnel),
                       {}};
    const std::array<float, 4> azimuthal_mass{4 * fiber.mean_fresnel->at(theta_r), fiber.about_pi.mass(), 4,
                                              fiber.about_caustic.mass()};
    float sum = 0;
    for (std::size_t p = 0; p < lobes.size(); ++p) {
      const glm::vec3 energy = fiber.color[p] * (azimuthal_mass[p] * fiber.masses[std::min(p, trt)]->at(theta_r));
      event.energy[layer_of(parameters, p)] += energy;
      sum += constants->selection[p] = luminance(energy);
    }
    if (!(sum > smallest_pdf)) constants->selection = {sum = 1, 0, 0, 0};
    for (std::size_t p = 0; p < lobes.size(); ++p)
      event.selection[layer_of(parameters, p)] += constants->selection[p] /= sum;
    return event;
  }

  FiberSample sample_event(const FiberEvent& event, const std::array<float, 4>& u) const override {
    const EventConstants& constants = constants_in<EventConstants>(event);
    const Fiber& fiber = fibers_[event.fiber];
    std::size_t p = 0;
    float below = 0;
    for (std::size_t k = 0; k < lobes.size(); ++k) {
      if (!(constants.selection[k] > 0)) continue;
      p = k;
      if (u[0] < (below += constants.selection[k])) break;
    }
    FiberSample sample;
    sample.lobe = static_cast<Lobe>(layer_of(ids_[event.fiber], p));
    sample.wi.theta = constants.proposal[std::min(p, trt)].sample(u[1]);
    const float phi = p == tt      ? fiber.about_pi.sample(u[2])
                      : p == glint ? fiber.about_caustic.sample(u[2])
                                   : 2 * std::asin(std::clamp(2 * u[2] - 1, -1.0f, 1.0f));
    sample.wi.phi = adaptive::wrap_angle(event.wr.phi + phi);
    sample.value = value_at(event, sample.wi);
    return sample;
  }

  FiberValue evaluate_event(const FiberEvent& event, const FiberDirection& wi) const override {
    return value_at(event, clamped(wi));
  }

  std::size_t bytes() const override {
    return fibers_.capacity() * sizeof(Fiber) + ids_.size() * sizeof(FiberParameters) +
           masses_.size() * sizeof(LongitudinalMasses) + mean_fresnel_.size() * sizeof(MeanFresnel);
  }

 private:
  static std::size_t layer_of(const FiberParameters& parameters, std::size_t p) {
    return lobe_of(p == glint && !parameters.split_glint ? trt : p);
  }

  FiberValue value_at(const FiberEvent& event, const FiberDirection& wi) const {
    const EventConstants& constants = constants_in<EventConstants>(event);
    const Fiber& fiber = fibers_[event.fiber];
    const FiberParameters& parameters = ids_[event.fiber];
    const float phi = adaptive::wrap_angle(wi.phi - event.wr.phi), cosine = half_cosine(phi);
    const std::array<float, 4> height{constants.fresnel(cosine) * cosine, fiber.about_pi.height(phi), cosine,
                                      fiber.about_caustic.height(phi)};
    const std::array<float, 4> pdf{0.25f * cosine, fiber.about_pi.pdf(phi), 0.25f * cosine,
                                   fiber.about_caustic.pdf(phi)};
    std::array<float, 3> m, q;
    for (std::size_t p = 0; p < m.size(); ++p) {
      m[p] = fiber.longitudinal[p].height(event.wr.theta, wi.theta);
      q[p] = constants.proposal[p].density(wi.theta);
    }
    FiberValue value;
    for (std::size_t p = 0; p < lobes.size(); ++p) {
      value.s[layer_of(parameters, p)] += fiber.color[p] * (m[std::min(p, trt)] * height[p]);
      value.pdf += constants.selection[p] * q[std::min(p, trt)] * pdf[p];
    }
    value.pdf = std::max(value.pdf, smallest_pdf);
    return value;
  }

  FiberIds ids_;
  std::vector<Fiber> fibers_;                                                            ///< by id
  std::map<std::pair<float, float>, std::shared_ptr<const LongitudinalMasses>> masses_;  ///< by tilt and beta
  std::map<std::pair<float, ReflectionFresnel>, std::shared_ptr<const MeanFresnel>> mean_fresnel_;  ///< by eta and kind
};

}  // namespace

std::unique_ptr<FiberModel> make_ou2012(const ModelSettings&) { return std::make_unique<Ou2012>(); }

}  // namespace tress::inline v0_2::fiber
