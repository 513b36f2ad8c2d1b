#include "models/learned_row.h"

#include <cmath>
#include <memory>
#include <numbers>

#include "fiber/row_axes.h"
#include "tress/adaptive/service.h"
#include "tress/base/random.h"
#include "tress/fiber/elliptical_model.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr int draws_per_pass = 16;
constexpr int most_passes = 4096;  // a row is refused after 32 failed tests of 24 scores, long before

}  // namespace

double transmitted_share(double sigma_a, double mean, double variance) {
  const double depth = sigma_a * mean;
  if (!(variance > 1e-9 * mean * mean)) return std::exp(-depth);
  return std::exp(-mean * mean / variance * std::log1p(sigma_a * variance / mean));
}

double LearnedRow::density_of(std::size_t part, double phi, double sigma_a) const {
  if (part >= fit.component_count) {
    return fit.uniform_weight / (2 * std::numbers::pi) *
           transmitted_share(sigma_a, fit.uniform_attribute_mean, fit.uniform_attribute_variance);
  }
  const float x = adaptive::wrap_angle(sign * (static_cast<float>(phi) - phi_r));
  const adaptive::Component& component = fit.components[part];
  return double(component.weight) * double(component.shape.density(x)) *
         transmitted_share(sigma_a, component.attribute_mean, component.attribute_variance);
}

double LearnedRow::density(double phi, double sigma_a) const {
  double sum = density_of(fit.component_count, phi, sigma_a);
  for (std::size_t part = 0; part < fit.component_count; ++part) sum += density_of(part, phi, sigma_a);
  return sum;
}

LearnedRow learn_row(const RowRequest& request) {
  const FoldedAzimuth fold = fold_azimuth(request.phi_r);
  adaptive::SliceDescription slice =
      elliptical_slice(request.slice_lobe, request.eta, request.eccentricity, request.sigma);
  slice.axis_a = {fold.phi};
  slice.axis_b = {std::fabs(request.theta_d)};

  adaptive::Options options;
  options.epsilon = request.epsilon;
  options.queries_before_creation = 1;
  const std::unique_ptr<adaptive::Target> target = make_elliptical_target();
  adaptive::Service service(options, *target);
  const adaptive::SliceId id = *service.add_slice(slice);

  LearnedRow learned;
  learned.phi_r = request.phi_r;
  learned.sign = fold.sign;
  RandomStream random(0x66697420726f7773ull);
  for (int pass = 0; pass < most_passes; ++pass) {
    for (int draw = 0; draw < draws_per_pass; ++draw) {
      const adaptive::RowView row = service.look_up(id, 0, 0);
      if (row.state != adaptive::RowState::open || row.fit == nullptr) continue;
      const float share = static_cast<float>(options.uniform_share_open);
      const float x = row.fit->sample(random.next(), share);
      service.score(row, x, row.nodes->density(x), row.fit->proposal_density(x, share));
    }
    learned.evaluations += service.publish().g_evaluations;
    const adaptive::RowView row = service.peek(id, 0, 0);
    learned.converged = row.state == adaptive::RowState::converged;
    if (row.fit != nullptr) learned.fit = *row.fit;
    if (learned.converged || row.state == adaptive::RowState::refused) break;
  }
  return learned;
}

}  // namespace tress::inline v0_2::fiber
