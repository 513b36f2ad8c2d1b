// Rows all over the parameter space, learned from samples as a render draws them, against the Fourier reference.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "fiber/fourier_reference.h"
#include "support/seed.h"
#include "tress/adaptive/service.h"
#include "tress/base/random.h"
#include "tress/fiber/elliptical_model.h"

namespace tress {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double degree = pi / 180;

struct Row {
  adaptive::SliceId slice;
  std::uint32_t a, b;
  adaptive::SliceDescription description;
};

double relative_l2(const adaptive::Mixture& fit, const adaptive::SliceDescription& slice, double phi_r,
                   double theta_d) {
  const fiber::FourierReference reference({.eta = slice.key.parameters[0],
                                           .eccentricity = slice.key.parameters[1],
                                           .theta_d = theta_d,
                                           .phi_r = phi_r,
                                           .sigma = slice.key.parameters[2],
                                           .p = static_cast<int>(slice.key.lobe)});
  constexpr int points = 360;
  double error = 0, variation = 0;
  const double mean = reference.energy() / (2 * pi);
  for (int i = 0; i < points; ++i) {
    const double x = -pi + 2 * pi * i / points;
    const double g = reference.density(phi_r + x), f = fit.density(static_cast<float>(x));
    error += (g - f) * (g - f) * 2 * pi / points;
    variation += (g - mean) * (g - mean) * 2 * pi / points;
  }
  return error / std::max(variation, 1e-3 / (2 * pi));
}

// 200 rows of sigma 5..25 degrees, e 0.7..1, all lobes and nodes with E_p above 0.001; 16 passes of 16 own and 16
// foreign azimuths each. Seed fixed. The design measured 0.1 % false at epsilon 0.01, worst 0.013: here at most 2 of
// 200 above epsilon (false alarm 1.1e-3 at that rate), none above 2 epsilon.
TEST(random_rows, learned_from_render_like_samples_are_close_to_the_reference) {
  const auto target = fiber::make_elliptical_target();
  const adaptive::Options options;
  adaptive::Service service(options, *target);
  RandomStream random(test::seed(2015));
  std::vector<Row> rows;
  std::vector<adaptive::TracedRay> rays;
  while (rows.size() < 200) {
    const int p = 1 + static_cast<int>(3 * random.next());
    const float e = 0.7f + 0.3f * random.next();
    const auto sigma = static_cast<float>((5 + 20 * random.next()) * degree);
    Row row{0, 0, 0, fiber::elliptical_slice(p, 1.55f, e, sigma)};
    row.a = static_cast<std::uint32_t>(random.next() * static_cast<float>(row.description.axis_a.size()));
    row.b = static_cast<std::uint32_t>(random.next() * static_cast<float>(row.description.axis_b.size()));
    rays.clear();
    target->trace(row.description, row.description.axis_a[row.a], row.description.axis_b[row.b], rays);
    double energy = 0;
    for (const auto& ray : rays) energy += ray.weight;
    if (energy < 1e-3) continue;
    row.slice = *service.add_slice(row.description);
    rows.push_back(row);
  }
  std::uint64_t evaluations = 0, samples = 0;
  for (int pass = 0; pass < 16; ++pass) {
    for (const Row& row : rows) {
      for (int i = 0; i < 16; ++i) {
        const adaptive::RowView view = service.look_up(row.slice, row.a, row.b);
        if (view.state == adaptive::RowState::converged || view.row == adaptive::RowView::no_row) continue;
        const auto foreign = static_cast<float>(2 * pi * (static_cast<double>(random.next()) - 0.5));
        service.observe(view, foreign, view.nodes->density(foreign));
        if (view.fit == nullptr) continue;
        const float x = view.fit->sample(random.next(), options.uniform_share_open);
        service.score(view, x, view.nodes->density(x), view.fit->proposal_density(x, options.uniform_share_open));
        ++samples;
      }
    }
    evaluations += service.publish().g_evaluations;
  }
  std::vector<double> errors;
  int converged = 0, falsely = 0;
  for (const Row& row : rows) {
    const adaptive::RowView view = service.peek(row.slice, row.a, row.b);
    if (view.state != adaptive::RowState::converged) continue;
    ++converged;
    const double error = relative_l2(*view.fit, row.description, static_cast<double>(row.description.axis_a[row.a]),
                                     static_cast<double>(row.description.axis_b[row.b]));
    falsely += error > options.epsilon ? 1 : 0;
    errors.push_back(error);
  }
  ASSERT_GE(converged, 190);
  std::ranges::sort(errors);
  const double worst = errors.back();
  std::printf(
      "converged %d of 200, own samples %.1f a row, g %.1f a row; relative squared L2 against the reference: "
      "median %.2g, 99 %% %.2g, max %.2g; false %d\n",
      converged, static_cast<double>(samples) / 200, static_cast<double>(evaluations) / 200, errors[errors.size() / 2],
      errors[errors.size() * 99 / 100], worst, falsely);
  EXPECT_LT(errors[errors.size() / 2], 3e-3);
  EXPECT_LE(falsely, 2);
  EXPECT_LT(worst, 2 * options.epsilon);
}

}  // namespace
}  // namespace tress
