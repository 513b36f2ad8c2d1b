#include "references/models/pekelis2015.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/exponential.hpp>
#include <map>
#include <new>
#include <tuple>
#include <utility>
#include <vector>

#include "base/pi.h"
#include "fiber/event_constants.h"
#include "fiber/fiber_ids.h"
#include "fiber/fresnel.h"
#include "fiber/longitudinal.h"
#include "fiber/row_axes.h"
#include "fiber/row_model.h"
#include "fiber/surface_fresnel.h"
#include "models/elliptical/ray_shape.h"
#include "models/registry.h"
#include "references/models/marschner_lobes.h"
#include "references/models/pekelis2015_target.h"
#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr float reflection_sigma = 1;
constexpr float least_mass = 1e-6f;    // a row of less has no light: its proposal is uniform
constexpr float least_cosine = 0.01f;  // bounds the printed 1/cos^2 theta_r
constexpr std::size_t lobe_r = 0, lobe_tt = 1, lobe_trt = 2;
constexpr std::size_t nothing_drawn = marschner_lobes;

struct RowSlice {
  adaptive::SliceId id = 0;
  adaptive::SliceDescription description;
};

struct FiberRecord {
  MarschnerShape shape;  ///< e and sigma of the grid
  LobeWidths widths;
  glm::vec3 zeta{0.0f};
  float sigma_tt = 1;
  std::array<RowSlice, 2> slices;  ///< TRT, GLINT
  std::shared_ptr<const MarschnerTable> table;
  MarschnerEnergies energy;
};

struct PekelisConstants {
  LongitudinalLobes longitudinal;  ///< lane l: of MarschnerLobe l
  Float4 lambda, tilt;             ///< likewise
  FoldedAzimuth fold;
};

/// N and its proposal at one azimuth.
struct Answer {
  float density = 0, proposal = inverse_two_pi_f;
};

class Pekelis2015 final : public RowModel {
 public:
  Pekelis2015(const ModelSettings& settings, PekelisReading reading)
      : RowModel(settings.estimator == Estimator::exact ? nullptr : settings.service), reading_(reading) {}

  std::string name() const override {
    return reading_ == PekelisReading::as_printed ? "pekelis2015-printed" : "pekelis2015";
  }

  FiberId make_fiber(const FiberParameters& parameters) override {
    const auto [id, is_new] = ids_.find_or_add(parameters);
    if (!is_new) return id;
    FiberRecord fiber;
    const float e = nearest_pekelis_eccentricity(parameters.eccentricity);
    const float sigma = nearest_pekelis_sigma(azimuthal_sigmas(parameters)[1]);
    fiber.shape = {static_cast<double>(parameters.eta), static_cast<double>(e), {}};
    fiber.shape.caustics.width = static_cast<double>(sigma);
    fiber.widths = LobeWidths(parameters);
    const glm::vec3 sigma_a = sigma_a_per_radius(parameters);
    fiber.zeta = pekelis_zeta(glm::exp(-2.0f * sigma_a), reading_);
    // A logistic of scale s has the variance pi^2 s^2/3; sigma_TT widens it by that of the blur.
    const float scale = pekelis_transmission_scale(parameters.eta, reading_);
    const float blur = azimuthal_sigmas(parameters)[0] / (scale * pi_f);
    fiber.sigma_tt = std::sqrt(1 + 3 * blur * blur);
    for (std::size_t i = 0; i < 2; ++i) {
      const auto lobe = static_cast<MarschnerLobe>(lobe_trt + i);
      fiber.slices[i].description = pekelis_slice(lobe, parameters.eta, e, sigma);
      if (service_ != nullptr) fiber.slices[i].id = slice_of(fiber.slices[i].description);
    }
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
    const Float4 lambda = by_marschner_lobe(widths.lambda), tilt = by_marschner_lobe(widths.tilt);
    new (place_of<PekelisConstants>(event))
        PekelisConstants{{event.wr.theta, tilt, lambda, LongitudinalShape::logistic}, lambda, tilt, fold};
    begin_lobes(ids_[id], *fiber.table, fiber.energy, fold.phi, event);
    return event;
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
  FiberSample draw(const FiberEvent& event, const std::array<float, 4>& u, DirectionRows& rows) const override {
    const FiberRecord& fiber = fibers_[event.fiber];
    const PekelisConstants& constants = constants_in<PekelisConstants>(event);
    FiberSample sample;
    const std::size_t l = draw_lobe(event, u[0]);
    sample.lobe = layer_of(ids_[event.fiber], l);
    sample.wi.theta = constants.longitudinal.lane(static_cast<int>(l)).sample(u[1]);
    const float theta_d = 0.5f * (event.wr.theta - sample.wi.theta);
    float x = 0;
    if (l == lobe_r) {
      x = sample_pekelis_reflection(u[2], reflection_sigma);
    } else if (l == lobe_tt) {
      x = transmission(event, theta_d).sample(u[2]);
    } else {
      x = sample_row(fiber, l, constants.fold.phi, theta_d, u, rows);
    }
    sample.wi.phi = constants.fold.absolute(x, event.wr.phi);
    sample.value = value_at(event, sample.wi, l, rows);
    return sample;
  }

  FiberValue value(const FiberEvent& event, const FiberDirection& wi, DirectionRows& rows) const override {
    return value_at(event, clamped(wi), nothing_drawn, rows);
  }

  adaptive::SliceId slice_of(const adaptive::SliceDescription& description) {
    const auto [entry, is_new] = slices_.try_emplace(description.key, adaptive::SliceId{0});
    if (is_new) entry->second = service_->add_slice(description).value();
    return entry->second;
  }

  adaptive::SkewLogistic transmission(const FiberEvent& event, float theta_d) const {
    const auto eta_prime =
        static_cast<float>(bravais_index(static_cast<double>(ids_[event.fiber].eta), static_cast<double>(theta_d)));
    return pekelis_transmission(pekelis_transmission_scale(eta_prime, reading_) * fibers_[event.fiber].sigma_tt);
  }

  /// Both rows share a layer of the value unless the fiber splits the glint off.
  adaptive::RowView row_of(const FiberRecord& fiber, std::size_t lobe, float phi_r, float theta_d,
                           DirectionRows& rows) const {
    const RowSlice& slice = fiber.slices[lobe - lobe_trt];
    const PekelisNode node = nearest_pekelis_node(slice.description, phi_r, theta_d);
    return rows.ask(slice.id, node.a, node.b, Lobe::trt);
  }

  float sample_row(const FiberRecord& fiber, std::size_t lobe, float phi_r, float theta_d,
                   const std::array<float, 4>& u, DirectionRows& rows) const {
    if (service_ == nullptr) {
      const auto l = static_cast<MarschnerLobe>(lobe);
      return fiber.table->sample(l, fiber.table->place(l, phi_r, theta_d), u[3], u[2]);
    }
    const adaptive::RowView view = row_of(fiber, lobe, phi_r, theta_d, rows);
    const adaptive::Options& options = service_->options();
    if (view.state == adaptive::RowState::converged || view.fit != nullptr)
      return view.sample(u[2], uniform_share(view));
    const adaptive::TracedNodes& nodes = *view.nodes;
    const float share = options.uniform_share_open;
    if (u[3] < share || nodes.energy() < least_mass) return -pi_f + 2 * pi_f * u[2];
    return draw_azimuth(shape_of(nodes), 0, nodes.energy(), u[2], (u[3] - share) / (1 - share));
  }

  float uniform_share(const adaptive::RowView& view) const {
    return view.state == adaptive::RowState::converged ? service_->options().uniform_share_converged
                                                       : service_->options().uniform_share_open;
  }

  /// drawn: x was drawn from this row's own proposal.
  Answer ask_row(const adaptive::RowView& view, float x, bool drawn, FiberValue& value) const {
    ++value.queries;
    value.objective += view.objective;
    const float share = uniform_share(view);
    if (view.state == adaptive::RowState::converged) {
      return {view.density(x), view.proposal_density(x, share)};
    }
    ++value.exact_queries;
    const adaptive::TracedNodes& nodes = *view.nodes;
    const float g = nodes.density(x);
    if (view.fit != nullptr) {
      const float q = view.fit->proposal_density(x, share);
      if (drawn) {
        service_->score(view, x, g, q);
      } else {
        service_->observe(view, x, g);
      }
      return {g, q};
    }
    service_->observe(view, x, g);
    if (nodes.energy() < least_mass) return {g, inverse_two_pi_f};
    return {g, (1 - share) * g / nodes.energy() + share * inverse_two_pi_f};
  }

  /// A_p N_p of TRT or GLINT without gain, and its proposal.
  glm::vec3 row_lobe(const FiberRecord& fiber, std::size_t lobe, float phi_r, float theta_d, float x,
                     const PekelisAttenuation& attenuation, bool drawn, const adaptive::RowView& row, float& proposal,
                     FiberValue& value) const {
    const auto at = [](float angle) { return static_cast<double>(angle); };
    const MarschnerCircle circle =
        marschner_trt_circle(fiber.shape.eta, fiber.shape.eccentricity, at(phi_r), at(theta_d), at(x));
    glm::vec3 attenuated(0.0f);  // mean over the roots, by their densities
    float density = 0;
    if (lobe == lobe_trt) {
      const MarschnerPaths paths = circle.paths(2, at(x));
      for (std::size_t k = 0; k < paths.count; ++k) {
        const auto weight = static_cast<float>(paths.path[k].density);
        attenuated += weight * attenuation(2, static_cast<float>(paths.path[k].cos_gamma));
        density += weight;
      }
      if (density > 0) attenuated /= density;
    } else {
      const double offset = circle.caustic_offset();
      attenuated = attenuation(2, static_cast<float>(std::sqrt(std::max(1 - offset * offset, 0.0))));
    }
    if (service_ == nullptr) {
      ++value.queries;
      ++value.exact_queries;
      const auto l = static_cast<MarschnerLobe>(lobe);
      proposal = fiber.table->density(l, fiber.table->place(l, phi_r, theta_d), x);
      return attenuated * static_cast<float>(pekelis_curve(fiber.slices[lobe - lobe_trt].description.key, at(phi_r),
                                                           at(theta_d), at(x)));
    }
    const Answer answer = ask_row(row, x, drawn, value);
    proposal = answer.proposal;
    return attenuated * answer.density;
  }

  FiberValue value_at(const FiberEvent& event, const FiberDirection& wi, std::size_t drawn, DirectionRows& rows) const {
    const FiberRecord& fiber = fibers_[event.fiber];
    const FiberParameters& parameters = ids_[event.fiber];
    const PekelisConstants& constants = constants_in<PekelisConstants>(event);
    const float theta_d = 0.5f * (event.wr.theta - wi.theta);
    const float x = constants.fold.relative(wi.phi, event.wr.phi);
    const Float4 m = constants.longitudinal.density(wi.theta), seen = longitudinal_as_read(event, constants, wi, m);
    const PekelisAttenuation attenuation(parameters.eta, theta_d, fiber.zeta, reading_);
    FiberValue value;
    for (std::size_t l = 0; l < marschner_lobes; ++l) {
      const float chosen = selection_of(event, l);
      if (!(chosen > 0)) continue;
      glm::vec3 azimuthal;
      float proposal = 0;
      adaptive::RowView row;
      if (l == lobe_r) {
        proposal = pekelis_reflection(x, reflection_sigma);
        const SurfaceFresnel fresnel(parameters.eta, theta_d, parameters.reflection_fresnel);
        azimuthal = glm::vec3(proposal * fresnel(std::abs(std::cos(0.5f * x))));
      } else if (l == lobe_tt) {
        proposal = transmission(event, theta_d).density(x);
        azimuthal = proposal * attenuation(1, transmitted_cosine(fiber, theta_d, x));
      } else {
        if (service_ != nullptr) row = row_of(fiber, l, constants.fold.phi, theta_d, rows);
        azimuthal = row_lobe(fiber, l, constants.fold.phi, theta_d, x, attenuation, l == drawn, row, proposal, value);
      }
      const auto lane = static_cast<int>(l);
      const glm::vec3 s = gain_of(parameters, l) * azimuthal * seen[lane];
      value.s[static_cast<std::size_t>(layer_of(parameters, l))] += s;
      if (l >= lobe_trt && service_ != nullptr) rows.set_part(row, s);
      value.pdf += chosen * m[lane] * proposal;
    }
    value.pdf = std::max(value.pdf, smallest_pdf);
    return value;
  }

  /// cos gamma of the path of TT that leaves at x; 0 where none does.
  static float transmitted_cosine(const FiberRecord& fiber, float theta_d, float x) {
    const MarschnerCircle circle(fiber.shape.eta, fiber.shape.eta, static_cast<double>(theta_d));
    const MarschnerPaths paths = circle.paths(1, static_cast<double>(x));
    double cosine = 0;
    for (std::size_t k = 0; k < paths.count; ++k) cosine = std::max(cosine, paths.path[k].cos_gamma);
    return static_cast<float>(cosine);
  }

  /// M as S has it: `normalised`, or as printed, with the printed factor of eq. 2.
  Float4 longitudinal_as_read(const FiberEvent& event, const PekelisConstants& constants, const FiberDirection& wi,
                              Float4 normalised) const {
    if (reading_ == PekelisReading::corrected) return normalised;
    const Float4 scaled = (0.5f * (event.wr.theta + wi.theta) - constants.tilt) / constants.lambda;
    const Float4 decay = exp_of_negative(-abs4(scaled)), tail = 1 + decay;
    const float ratio = std::cos(wi.theta) / std::max(std::cos(event.wr.theta), least_cosine);
    return decay / (constants.lambda * tail * tail) * (ratio * ratio);
  }

  PekelisReading reading_;
  FiberIds ids_;
  std::vector<FiberRecord> fibers_;
  MarschnerTables tables_;
  std::map<adaptive::SliceKey, adaptive::SliceId> slices_;
};

}  // namespace

std::unique_ptr<adaptive::Target> make_pekelis2015_target() { return std::make_unique<PekelisTarget>(); }

std::unique_ptr<FiberModel> make_pekelis2015(const ModelSettings& settings, PekelisReading reading) {
  return std::make_unique<Pekelis2015>(settings, reading);
}

}  // namespace tress::inline v0_2::fiber
