// Pictures by `corrected` against `exact`: the same mean before, across and after the convergence of the table.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "integrate/picture_mean.h"
#include "integrate/white_fiber.h"
#include "support/seed.h"
#include "tress/fiber/elliptical_model.h"

namespace tress::integrate {
namespace {

using fiber::Estimator;

/// A picture of brown hair and the state that it is rendered with.
class Hair {
 public:
  /// The default epsilon is large so that the fits are plainly wrong where they answer.
  explicit Hair(const adaptive::Learner* learner = &adaptive::sketch_learner, double epsilon = 0.3)
      : scene_(tangle(250, 32, 32)), target_(fiber::make_elliptical_target()) {
    scene_.camera.vertical_fov_deg = 10;
    // Light from above and to one side: the azimuthal shape matters.
    std::vector<glm::vec3> pixels(16 * 8, glm::vec3(0.02f));
    for (const int i : {35, 36, 51, 52}) pixels[static_cast<std::size_t>(i)] = glm::vec3(12.0f);
    scene_.environment = scene::Environment(16, 8, pixels, 0, 1.0f);
    scene_.environment_visible = false;
    adaptive::Options options;
    options.learner = learner;
    options.epsilon = epsilon;
    service_ = std::make_unique<adaptive::Service>(options, *target_);
  }

  /// Sums over samples [0, samples) of every pixel under `seed`. Goes on with the table as it is.
  std::vector<double> render(Estimator estimator, int samples, std::uint64_t seed, int threads = 2) {
    adaptive::Service* service = estimator == Estimator::exact ? nullptr : service_.get();
    const std::unique_ptr<fiber::FiberModel> model = *fiber::make_elliptical_model(estimator, service);
    std::vector<fiber::FiberId> ids;
    for (const fiber::FiberParameters& fiber : scene_.fibers) ids.push_back(model->add_fiber(fiber));
    RenderOptions options;
    options.samples = samples;
    options.max_depth = 6;
    options.seed = test::seed(seed);
    const RenderResult result = render_with(scene_, *model, ids, options, threads, never_stop, {}, service);
    if (result.queries > 0) {
      converged_ = 1 - static_cast<double>(result.exact_queries) / static_cast<double>(result.queries);
    }
    std::vector<double> sums;
    for (const float value : result.picture.find("G")->pixels) sums.push_back(static_cast<double>(value) * samples);
    return sums;
  }

  double converged() const { return converged_; }

 private:
  scene::Scene scene_;
  std::unique_ptr<adaptive::Target> target_;
  std::unique_ptr<adaptive::Service> service_;
  double converged_ = 0;
};

/// z of the mean difference of two pictures. Pixels are independent of each other; seeds are the same, which takes away
/// what both share.
double z_of(const std::vector<double>& a, const std::vector<double>& b) {
  const double n = static_cast<double>(a.size());
  double mean = 0, squares = 0;
  for (std::size_t i = 0; i < a.size(); ++i) mean += (a[i] - b[i]) / n;
  for (std::size_t i = 0; i < a.size(); ++i) squares += (a[i] - b[i] - mean) * (a[i] - b[i] - mean);
  return mean / std::sqrt(squares / (n * (n - 1)));
}

std::vector<double> minus(std::vector<double> a, const std::vector<double>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
  return a;
}

// Three blocks at |z| < 5: one false alarm in 580,000 runs; seeds are fixed.
TEST(Corrected, has_the_mean_of_exact_before_across_and_after_convergence) {
  const std::vector<double> exact_first = Hair().render(Estimator::exact, 1, 31);
  const std::vector<double> exact_all = Hair().render(Estimator::exact, 12, 31);
  const std::vector<double> exact_later = Hair().render(Estimator::exact, 12, 32);

  EXPECT_LT(std::abs(z_of(Hair().render(Estimator::corrected, 1, 31), exact_first)), z_limit) << "before";
  Hair hair;
  const std::vector<double> all = hair.render(Estimator::corrected, 12, 31);
  // The first sample of a longer render is that of a shorter one.
  EXPECT_LT(std::abs(z_of(minus(all, Hair().render(Estimator::corrected, 1, 31)), minus(exact_all, exact_first))),
            z_limit)
      << "across";
  const double after = z_of(hair.render(Estimator::corrected, 12, 32), exact_later);
  EXPECT_GT(hair.converged(), 0.9) << "most rows have converged";
  EXPECT_LT(std::abs(after), z_limit) << "after";
  const double fitted = z_of(hair.render(Estimator::fitted, 12, 32), exact_later);
  EXPECT_GT(std::abs(fitted), z_limit) << "the bias that corrected takes away is seen";
}

}  // namespace
}  // namespace tress::integrate
