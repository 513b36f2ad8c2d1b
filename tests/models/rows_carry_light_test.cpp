// Every model with rows credits them with the light that its directions bring (ESTIMATOR.md, E8), so that the bound on
// the bias of a picture is that of its rows, and rows can be learned by the light that they carry.
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "references/registry.h"
#include "tress/adaptive/service.h"
#include "tress/base/random.h"

namespace tress {
namespace {

constexpr int events = 3000;  // a pass

struct Taught {
  adaptive::PassReport report;
  std::string table;
};

/// A fiber under light from all over, each event the first hit of a path.
Taught teach(const fiber::ModelInfo& info, adaptive::Options options, float importance, bool split_glint) {
  options.sampled_epsilon = 0.3;
  const fiber::ModelService learned = fiber::make_service(info, options);
  adaptive::Service& service = *learned.service;
  const std::unique_ptr<fiber::FiberModel> model = info.make({.service = &service});
  fiber::FiberParameters parameters;
  parameters.split_glint = split_glint;
  const fiber::FiberId id = model->add_fiber(parameters);
  Taught taught;
  for (std::uint64_t pass = 0; pass < 12; ++pass) {
    for (std::uint64_t i = 0; i < events; ++i) {
      RandomStream random(3, pass, i);
      const float xi1 = random.next(), xi2 = random.next();
      const fiber::FiberEvent event = model->begin(id, {0.3f, 0.7f}, xi1, xi2, 0, importance);
      (void)model->sample(event, {random.next(), random.next(), random.next(), random.next()});
    }
    taught.report = service.publish(events);
  }
  taught.table = encode_cache(service.snapshot());
  return taught;
}

std::vector<const fiber::ModelInfo*> models_with_rows() {
  std::vector<const fiber::ModelInfo*> found;
  for (const fiber::ModelInfo& info : references::models()) {
    if (info.has_rows()) found.push_back(&info);
  }
  return found;
}

TEST(RowsCarryLight, TheBoundIsThatOfTheRowsInEveryModel) {
  ASSERT_GE(models_with_rows().size(), 3u);
  for (const fiber::ModelInfo* info : models_with_rows()) {
    for (const bool split : {false, true}) {
      const Taught one = teach(*info, {}, 1, split);
      ASSERT_GT(one.report.rows_converged, 0u) << info->name;
      EXPECT_GT(one.report.bias_bound, 0) << info->name;
      // The shares of the light sum to the share of E_p that rows have, below 1; a row's error is below epsilon, and 20
      // bounds sqrt(V) at the narrowest blur, 1 degree (ESTIMATOR.md, E8).
      EXPECT_LT(one.report.bias_bound, 20 * 0.1) << info->name;
      const Taught half = teach(*info, {}, 0.5f, split);
      EXPECT_NEAR(half.report.bias_bound, 0.5 * one.report.bias_bound, 1e-3 * one.report.bias_bound) << info->name;
      EXPECT_EQ(half.table, one.table) << info->name << ": light alone changes no row";
      EXPECT_EQ(teach(*info, {}, 0, split).report.bias_bound, 0) << info->name;
    }
  }
}

TEST(RowsCarryLight, RowsAreLearnedByItInEveryModel) {
  for (const fiber::ModelInfo* info : models_with_rows()) {
    adaptive::Options options;
    options.picture_error = 0.03;
    const adaptive::PassReport report = teach(*info, options, 1, false).report;
    EXPECT_GT(report.bias_bound, 0) << info->name;
    EXPECT_LE(report.bias_bound, 10 * options.picture_error) << info->name;
    std::uint64_t fitted = info->learns_samples() ? report.rows_converged : 0;
    for (std::size_t n = 1; n < report.components.size(); ++n) fitted += report.components[n];
    EXPECT_GT(fitted, 0u) << info->name << ": no row is worth a fit";
  }
}

}  // namespace
}  // namespace tress
