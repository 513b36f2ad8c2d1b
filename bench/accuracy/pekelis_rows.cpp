// How well the rows of pekelis2015 are fitted: random rows of the paper's grid (section 6), learned through the service
// with learners of choice, against Marschner's functions as they are (not blurred), by the error of the paper's section
// 7.1 at its 3601 azimuths, the mean of N being its integral over 2 pi. Rows of mass below 1e-3 are counted apart:
// their GLINT has no caustic.
//
//   bench_pekelis_rows [--rows N] [--seed N] [--epsilon E] [--learner NAME] [--components N] [--blur DEG]
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <string>
#include <vector>

#include "models/pekelis2015_target.h"
#include "tress/adaptive/random.h"
#include "tress/adaptive/service.h"

namespace {

using namespace tress;
using fiber::MarschnerLobe;

constexpr double pi = std::numbers::pi, degree = pi / 180;
constexpr int azimuths = 3601, passes = 80, asked_a_pass = 16;

struct Row {
  adaptive::PageId page;
  std::uint32_t a, b;
  std::vector<double> curve;  ///< at the 3601 azimuths
  double variation = 0, mass = 0;
};

Row make_row(adaptive::Service& service, adaptive::PageId page, RandomStream& random) {
  const adaptive::PageDescription& description = service.page(page);
  const auto index = [&](std::size_t size) {
    return static_cast<std::uint32_t>(random.next() * static_cast<float>(size));
  };
  Row row{page, index(description.axis_a.size()), index(description.axis_b.size()), {}};
  const double step = 2 * pi / (azimuths - 1);
  for (int i = 0; i < azimuths; ++i) {
    row.curve.push_back(fiber::pekelis_curve(description.key, static_cast<double>(description.axis_a[row.a]),
                                             static_cast<double>(description.axis_b[row.b]), -pi + i * step));
    if (i > 0) row.mass += row.curve.back() * step;
  }
  for (const double n : row.curve) row.variation += (n - row.mass / (2 * pi)) * (n - row.mass / (2 * pi)) * step;
  return row;
}

double error_of(const Row& row, const adaptive::Mixture& fit) {
  const double step = 2 * pi / (azimuths - 1);
  double sum = 0;
  for (int i = 0; i < azimuths; ++i) {
    const double d =
        row.curve[static_cast<std::size_t>(i)] - static_cast<double>(fit.density(static_cast<float>(-pi + i * step)));
    sum += d * d * step;
  }
  return sum / std::max(row.variation, 1e-3 / (2 * pi));
}

double quantile(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

void report(const char* name, const std::vector<Row>& rows, const adaptive::Service& service, std::uint32_t paper_d) {
  std::vector<double> errors;
  std::array<int, adaptive::Mixture::max_components + 1> components{};
  int converged = 0, empty = 0, more = 0;
  for (const Row& row : rows) {
    if (row.mass < 1e-3) {
      ++empty;
      continue;
    }
    const adaptive::RowView view = service.peek(row.page, row.a, row.b);
    converged += view.state == adaptive::RowState::converged ? 1 : 0;
    if (view.fit == nullptr) continue;
    errors.push_back(error_of(row, *view.fit));
    ++components[view.fit->component_count];
    more += view.fit->component_count > paper_d ? 1 : 0;
  }
  std::sort(errors.begin(), errors.end());
  if (errors.empty()) return;
  const auto below = std::lower_bound(errors.begin(), errors.end(), 0.1) - errors.begin();
  const double n = static_cast<double>(errors.size());
  fmt::print(
      "{}: {} rows ({} more without light), converged {:.1f} %, error median {:.2g}, 90 % {:.2g}, 99 % {:.2g}, "
      "largest {:.2g}, below .1 {:.1f} %\n  components",
      name, errors.size(), empty, 100 * converged / n, quantile(errors, 0.5), quantile(errors, 0.9),
      quantile(errors, 0.99), errors.back(), 100 * static_cast<double>(below) / n);
  for (std::size_t d = 0; d < components.size(); ++d) fmt::print(" {}:{:.1f}%", d, 100 * components[d] / n);
  fmt::print(", more than the paper's {}: {:.1f} %\n", paper_d, 100 * more / n);
}

}  // namespace

int main(int argc, char** argv) {
  int count = 1000;
  double blur = 0;
  std::uint32_t components = 0;  // 0: the paper's, 5 and 3
  std::uint64_t seed = 1;
  adaptive::Options options;
  options.memory_bytes = std::size_t{4} << 30;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string name = argv[i], value = argv[i + 1];
    if (name == "--rows") count = std::atoi(value.c_str());
    if (name == "--seed") seed = std::strtoull(value.c_str(), nullptr, 10);
    if (name == "--epsilon") options.epsilon = std::atof(value.c_str());
    if (name == "--components") components = static_cast<std::uint32_t>(std::atoi(value.c_str()));
    if (name == "--blur") blur = std::atof(value.c_str()) * degree;
    if (name == "--learner") options.learner = adaptive::find_learner(value).value_or(options.learner);
  }
  const fiber::PekelisTarget target;
  for (const MarschnerLobe lobe : {MarschnerLobe::trt, MarschnerLobe::glint}) {
    adaptive::Service service(options, target);
    std::vector<adaptive::PageId> pages;
    std::vector<double> share;  // by the rows of each page
    double all = 0;
    for (const float e : {0.85f, 0.9f, 0.95f, 1.0f}) {
      for (const double sigma : {10.0, 15.0, 20.0, 25.0}) {
        adaptive::PageDescription page = fiber::pekelis_page(lobe, 1.55f, e, static_cast<float>(sigma * degree));
        if (components > 0) page.max_components = components;
        if (blur > 0) page.blur_rad = static_cast<float>(blur);
        pages.push_back(service.add_page(page));
        share.push_back(all += page.node_count());
      }
    }
    RandomStream random(seed, 25572);
    std::vector<Row> rows;
    for (int i = 0; i < count; ++i) {
      const double u = static_cast<double>(random.next()) * all;
      const auto page = static_cast<std::size_t>(std::upper_bound(share.begin(), share.end(), u) - share.begin());
      rows.push_back(make_row(service, pages[page], random));
    }
    const auto start = std::chrono::steady_clock::now();
    for (int pass = 0; pass < passes; ++pass) {
      for (const Row& row : rows) {
        for (int i = 0; i < asked_a_pass; ++i) {
          const adaptive::RowView view = service.look_up(row.page, row.a, row.b);
          if (view.state == adaptive::RowState::converged) break;
          if (view.fit == nullptr) continue;
          const float x = view.fit->sample(random.next(), options.uniform_share_open);
          service.score(view, x, view.nodes->density(x), view.fit->proposal_density(x, options.uniform_share_open));
        }
      }
      (void)service.publish();
    }
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    report(lobe == MarschnerLobe::trt ? "TRT" : "GLINT", rows, service, lobe == MarschnerLobe::trt ? 5 : 3);
    fmt::print("  {:.1f} s in all\n", seconds);
  }
}
