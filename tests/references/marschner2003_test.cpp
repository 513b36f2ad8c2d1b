// The reference model of Marschner et al. 2003: its azimuthal part by independent means, its energy as documented, its
// values at every corner of the parameters.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <vector>

#include "fiber/cross_section.h"
#include "models/registry.h"
#include "references/models/marschner_azimuth.h"
#include "references/models/marschner_table.h"
#include "references/registry.h"
#include "support/chi_square.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr double pi = std::numbers::pi, degree = pi / 180;

std::unique_ptr<FiberModel> marschner() { return references::find_model("marschner2003")->make({}); }

// c is such that the cubic is exact at both ends and at the middle; between them it stays within a few degrees.
TEST(marschner_cubic, is_exact_at_the_ends_and_near_between) {
  double largest = 0;
  for (const double theta : {0.0, 0.5, 1.0}) {
    const MarschnerCircle circle(1.55, 1.55, theta);
    for (const int p : {0, 1, 2}) {
      EXPECT_NEAR(circle.cubic(p, 0.5 * pi), circle.exact(p, 0.5 * pi), 1e-12);
      EXPECT_NEAR(circle.cubic(p, 0), 0, 1e-12);
      for (double gamma = -1.55; gamma < 1.55; gamma += 0.01) {
        largest = std::max(largest, std::abs(circle.cubic(p, gamma) - circle.exact(p, gamma)));
        const double slope = (circle.cubic(p, gamma + 1e-5) - circle.cubic(p, gamma - 1e-5)) / 2e-5;
        EXPECT_NEAR(circle.cubic_rate(p, gamma), slope, 1e-8);
      }
    }
  }
  // Marschner et al. call it a few percent of the range of 2 pi.
  EXPECT_LT(largest, 0.06);
  std::printf("largest error of the cubic: %.2f degrees\n", largest / degree);
}

// Every root leads back to phi, and their number is that of sign changes of cubic - phi on a grid.
TEST(marschner_cubic, has_the_roots_that_a_search_finds) {
  for (const double eta : {1.05, 1.2, 1.55, 2.2}) {
    for (const double theta : {0.0, 0.7, 1.3, 1.5}) {
      const MarschnerCircle circle(eta, eta, theta);
      for (const int p : {0, 1, 2}) {
        for (double phi = -3.1; phi < 3.1; phi += 0.0731) {
          std::size_t crossings = 0;
          double before = 0;
          constexpr int steps = 2000;
          for (int i = 0; i <= steps; ++i) {
            const double gamma = pi * (static_cast<double>(i) / steps - 0.5);
            const double d = std::remainder(circle.cubic(p, gamma) + p * pi - phi, 2 * pi);
            if (i > 0 && std::abs(d) < 1 && std::abs(before) < 1 && (d > 0) != (before > 0)) ++crossings;
            before = d;
          }
          // Two roots within a step of the grid are not distinguished: only next to a caustic, whose density is high.
          const MarschnerPaths paths = circle.paths(p, phi);
          bool near_caustic = false;
          for (std::size_t k = 0; k < paths.count; ++k) near_caustic |= paths.path[k].density > 20;
          if (near_caustic) continue;
          EXPECT_EQ(paths.count, crossings) << eta << " " << theta << " " << p << " " << phi;
        }
      }
    }
  }
}

// N_p without attenuation is 1/2 |dh/dphi|: the share of all offsets that leaves in a range of azimuths. Counted by
// midpoints in h through the cubic: 100,000 of them, bins of 3 degrees, error 1e-5 per offset at a bin's edge.
TEST(marschner_cubic, density_is_that_of_offsets) {
  const MarschnerCircle circle(1.55, 1.55, 0.3);
  constexpr int bins = 120, offsets = 100000, points = 400;
  for (const int p : {0, 1, 2}) {
    std::vector<double> counted(bins);
    for (int i = 0; i < offsets; ++i) {
      const double gamma = std::asin((2 * i + 1.0) / offsets - 1);
      const double phi = std::remainder(circle.cubic(p, gamma) + p * pi, 2 * pi);
      counted[static_cast<std::size_t>(std::clamp(static_cast<int>((phi / pi + 1) * 0.5 * bins), 0, bins - 1))] +=
          1.0 / offsets;
    }
    const double caustic = circle.glint({}).azimuth;
    for (int b = 0; b < bins; ++b) {
      double mass = 0;
      for (int i = 0; i < points; ++i) {
        const double phi = -pi + 2 * pi * (b + (i + 0.5) / points) / bins;
        const MarschnerPaths paths = circle.paths(p, phi);
        for (std::size_t k = 0; k < paths.count; ++k) mass += paths.path[k].density * 2 * pi / bins / points;
      }
      const double centre = -pi + 2 * pi * (b + 0.5) / bins;
      // The rule does not resolve the inverse root at a caustic.
      if (p == 2 && std::abs(std::abs(centre) - caustic) < 2.5 * 2 * pi / bins) continue;
      EXPECT_NEAR(counted[static_cast<std::size_t>(b)], mass, 1e-4) << p << ' ' << centre;
    }
  }
}

// The smooth circular fiber, traced: TT and R have its energy but for the two-index Fresnel (exact in the normal plane)
// and, at an inclination, the error of that. sigma_a 0 and 0.4 per radius.
TEST(marschner_azimuth, energy_of_tt_is_that_of_the_traced_circle) {
  MarschnerShape shape;
  shape.eccentricity = 1;
  const MarschnerTable table(shape);
  for (const float sigma_a : {0.0f, 0.4f}) {
    const auto r = table.energies(MarschnerLobe::r, glm::vec3(sigma_a));
    const auto tt = table.energies(MarschnerLobe::tt, glm::vec3(sigma_a));
    for (const float theta : {0.0f, 0.6f}) {
      const CrossSection section(1.55, 1, 0, static_cast<double>(theta));
      double traced_r = 0, traced_tt = 0;
      constexpr int n = 4000;
      for (int i = 0; i < n; ++i) {
        TracedOffset offset;
        section.trace((2 * i + 1.0) / n - 1, 1, &offset);
        traced_r += offset.weight[0] / n;
        traced_tt += offset.weight[1] / n * std::exp(-static_cast<double>(sigma_a) * offset.path[1]);
      }
      const auto at = [&](MarschnerLobe lobe, const std::vector<glm::vec3>& energy) {
        const MarschnerTable::Place place = table.place(lobe, 0, theta);
        float sum = 0;
        for (std::size_t k = 0; k < 4; ++k) sum += place.share[k] * energy[place.node[k]].g;
        return static_cast<double>(sum);
      };
      std::printf("theta %.1f sigma_a %.1f: R %.4f traced %.4f, TT %.4f traced %.4f\n", static_cast<double>(theta),
                  static_cast<double>(sigma_a), at(MarschnerLobe::r, r), traced_r, at(MarschnerLobe::tt, tt),
                  traced_tt);
      EXPECT_NEAR(at(MarschnerLobe::r, r), traced_r, theta > 0 ? 0.02 : 0.002);
      EXPECT_NEAR(at(MarschnerLobe::tt, tt), traced_tt, theta > 0 ? 0.03 : 0.01);
    }
  }
}

// The cubic has its caustic where the exact circle has it, within 3 degrees (its own error is 2.15).
TEST(marschner_caustic, stands_where_the_exact_one_stands) {
  for (const double eta_prime : {1.45, 1.55, 1.7, 1.9}) {
    const MarschnerCircle circle(eta_prime, eta_prime, 0);
    const double exact = std::abs(circle.exact(2, std::asin(circle.caustic_offset())));
    double largest = 0;
    for (double gamma = 0; gamma < 1.5; gamma += 1e-3) largest = std::max(largest, circle.exact(2, gamma));
    EXPECT_NEAR(exact, largest, 1e-5);
    EXPECT_NEAR(circle.glint({}).azimuth, exact, 3 * degree) << eta_prime;
  }
}

// The fault that is kept, e = 0.85: with the known direction along the major axis the printed index puts the caustic at
// 57 degrees, along the minor axis at 0.2. In the traced ellipse it is the other way round.
TEST(marschner_caustic, is_that_of_the_other_axis) {
  const auto printed = [](double phi_r) {
    const MarschnerCircle circle = marschner_trt_circle(1.55, 0.85, phi_r, 0, 0);
    return std::abs(circle.exact(2, std::asin(circle.caustic_offset()))) / degree;
  };
  const auto traced = [](double phi_r) {
    const CrossSection section(1.55, 0.85, phi_r, 0);
    double largest = 0;
    for (double h = -0.9; h <= 0.9; h += 1e-3) {  // further out all azimuths are met, in little light
      TracedOffset offset;
      section.trace(h, 2, &offset);
      if (offset.weight[2] <= 0) continue;
      largest = std::max(largest, std::abs(std::remainder(offset.azimuth[2] - phi_r, 2 * pi)));
    }
    return largest / degree;
  };
  std::printf("caustic along the major and minor axis: printed %.1f and %.1f, traced %.1f and %.1f degrees\n",
              printed(0), printed(0.5 * pi), traced(0), traced(0.5 * pi));
  EXPECT_NEAR(printed(0), 57, 1);
  EXPECT_NEAR(printed(0.5 * pi), 0.2, 0.1);
  EXPECT_LT(traced(0), 10);
  EXPECT_GT(traced(0.5 * pi), 35);
}

// TRT is 0 at a full caustic, never infinite, and removal stays within [0, 1] through the fade; GLINT has the mass
// 2 t Delta h.
TEST(marschner_caustic, is_removed_and_put_back_within_bounds) {
  MarschnerShape shape;
  shape.eccentricity = 1;
  double largest = 0;
  for (shape.eta = 1.3; shape.eta < 2.6; shape.eta += 0.0311) {
    for (const double width : {2.0, 10.0, 25.0, 45.0}) {
      shape.caustics.width = width * degree;
      const MarschnerCircle circle(shape.eta, shape.eta, 0);
      const MarschnerGlint glint = circle.glint(shape.caustics);
      EXPECT_GE(glint.strength, 0);
      EXPECT_LE(glint.strength, 1);
      EXPECT_LE(glint.share, shape.caustics.largest_share);
      double mass = 0;
      constexpr int n = 2000;
      for (int i = 0; i < n; ++i) {
        const double phi = -pi + 2 * pi * (i + 0.5) / n;
        const double kept = glint.removal(phi, shape.caustics.width);
        ASSERT_GE(kept, 0);
        ASSERT_LE(kept, 1);
        for (const MarschnerPaths& paths : {marschner_paths(shape, MarschnerLobe::trt, 0, 0, phi)}) {
          double density = 0;
          for (std::size_t k = 0; k < paths.count; ++k) density += paths.path[k].density;
          ASSERT_TRUE(std::isfinite(density));
          largest = std::max(largest, density);
        }
        mass += glint.density(phi, shape.caustics.width) * 2 * pi / n;
      }
      // The Gaussian is not wrapped: at 45 degrees 6e-5 of it is cut off.
      EXPECT_NEAR(mass, 2 * glint.strength * glint.share, 1e-3);
    }
  }
  std::printf("largest density of TRT without its caustics: %.3f /rad\n", largest);
  EXPECT_LT(largest, 6);
}

// Integral of S over all directions by midpoints, and the mean weight of samples, which must agree with it.
struct Furnace {
  double integral = 0;
  test::SampleMean weight;
};
Furnace furnace_of(float e, float theta) {
  FiberParameters parameters;
  parameters.sigma_a = glm::vec3(0);
  parameters.eccentricity = e;
  const auto model = marschner();
  const FiberId fiber = model->add_fiber(parameters);
  Furnace furnace;
  RandomStream random(11);
  const int events = e < 1 ? 8 : 1;
  constexpr int inclinations = 180, azimuths = 72;
  for (int i = 0; i < events; ++i) {
    const FiberDirection wr{theta * static_cast<float>(degree), static_cast<float>(0.5 * pi * (i + 0.5) / events)};
    const FiberEvent event = model->begin(fiber, wr, 0.5f, 0.5f, 0);
    for (int t = 0; t < inclinations; ++t) {
      for (int a = 0; a < azimuths; ++a) {
        const FiberDirection wi{static_cast<float>(pi * ((t + 0.5) / inclinations - 0.5)),
                                static_cast<float>(2 * pi * ((a + 0.5) / azimuths - 0.5))};
        furnace.integral +=
            static_cast<double>(model->evaluate(event, wi).total().g) * pi / inclinations * 2 * pi / azimuths / events;
      }
    }
    for (int s = 0; s < 4000 / events; ++s) {
      const FiberSample sample = model->sample(event, {random.next(), random.next(), random.next(), random.next()});
      furnace.weight.add(static_cast<double>(sample.value.total().g / sample.value.pdf));
    }
  }
  return furnace;
}

// The white furnace is REPORTED, it is not 1: the figures that the header sums up, alpha = 0.2. Means over the azimuth
// by midpoints, which resolve the narrowest lobe (TT, 4 degrees in theta_i) with 1 degree steps; samples agree
// within 4.5 standard errors (false alarm 7e-6 each) and that error of 0.005.
TEST(marschner2003, furnace_is_what_the_documents_say) {
  struct Row {
    float e, theta;
    double furnace;
  };
  constexpr Row rows[] = {{1.00f, 0, 0.964},  {1.00f, 60, 0.939}, {1.00f, 85, 1.167}, {0.85f, 0, 0.974},
                          {0.85f, 60, 0.948}, {0.85f, 85, 1.169}, {0.70f, 0, 0.989},  {0.70f, 85, 1.171}};
  for (const Row& row : rows) {
    const Furnace furnace = furnace_of(row.e, row.theta);
    std::printf("e %.2f theta %2.0f: furnace %.3f, sampled %.3f +- %.3f\n", static_cast<double>(row.e),
                static_cast<double>(row.theta), furnace.integral, furnace.weight.mean(),
                furnace.weight.standard_error());
    EXPECT_NEAR(furnace.integral, row.furnace, 0.005);
    EXPECT_NEAR(furnace.weight.mean(), furnace.integral, 0.005 + 4.5 * furnace.weight.standard_error());
  }
}

TEST(marschner2003, is_finite_with_bounded_weights_at_every_corner) {
  RandomStream random(5);
  float largest = 0;
  for (const float eta : {1.05f, 1.55f, 3.0f}) {
    for (const float e : {0.5f, 0.85f, 1.0f}) {
      for (const float roughness : {0.01f, 0.2f, 1.0f}) {
        for (const float sigma_a : {0.0f, 1.0f, 1e4f}) {
          FiberParameters parameters;
          parameters.eta = eta;
          parameters.eccentricity = e;
          parameters.roughness = roughness;
          parameters.sigma_a = glm::vec3(0, 0.1f, 1) * sigma_a;
          parameters.split_glint = roughness > 0.1f;
          const auto model = marschner();
          const FiberId fiber = model->add_fiber(parameters);
          ASSERT_EQ(model->add_fiber(parameters), fiber);
          for (const float theta : {0.0f, 0.7f, 1.5707964f, -1.5707964f}) {
            for (const float phi : {0.0f, 1.5707964f, -3.1415927f, 2.5f}) {
              const FiberEvent event = model->begin(fiber, {theta, phi}, 0, 0.99f, 1);
              const auto check = [&](const FiberValue& value) {
                ASSERT_TRUE(std::isfinite(value.pdf) && value.pdf > 0);
                for (const glm::vec3& s : value.s) {
                  for (int c = 0; c < 3; ++c) ASSERT_TRUE(std::isfinite(s[c]) && s[c] >= 0);
                }
              };
              for (int i = 0; i < 12; ++i) {
                const FiberSample sample =
                    model->sample(event, {random.next(), random.next(), random.next(), random.next()});
                check(sample.value);
                largest = std::max(largest, sample.value.total().r / sample.value.pdf);
              }
              for (const float end : {0.0f, 0.99999994f}) check(model->sample(event, {end, end, end, end}).value);
              for (const float theta_i : {-1.5707964f, 0.0f, 1.5707964f}) {
                for (const float phi_i : {-3.1415927f, 0.0f, 3.1415925f}) {
                  check(model->evaluate(event, {theta_i, phi_i}));
                }
              }
            }
          }
        }
      }
    }
  }
  std::printf("largest weight %.1f\n", static_cast<double>(largest));
  EXPECT_LT(largest, 400);
}

TEST(marschner2003, splitting_the_glint_changes_layers_only) {
  FiberParameters whole, split;
  split.split_glint = true;
  const auto model = marschner();
  const FiberId a = model->add_fiber(whole), b = model->add_fiber(split);
  const FiberDirection wr{0.3f, 0.8f};
  const FiberEvent of_whole = model->begin(a, wr, 0, 0, 0), of_split = model->begin(b, wr, 0, 0, 0);
  for (float phi = -3; phi < 3; phi += 0.31f) {
    const FiberValue x = model->evaluate(of_whole, {-0.2f, phi}), y = model->evaluate(of_split, {-0.2f, phi});
    EXPECT_EQ(x.pdf, y.pdf);
    EXPECT_NEAR(x.total().g, y.total().g, 1e-6f);
    EXPECT_EQ(x.s[static_cast<std::size_t>(Lobe::glint)].g, 0);
  }
  EXPECT_GT(of_split.energy[static_cast<std::size_t>(Lobe::glint)].g, 0);
}

}  // namespace
}  // namespace tress::inline v0_2::fiber
