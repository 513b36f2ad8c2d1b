// A model with rows taught by shading events at one known direction, for tests of every state of its rows.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "references/registry.h"
#include "tress/adaptive/service.h"
#include "tress/base/random.h"
#include "tress/fiber/elliptical_model.h"

namespace tress::test {

/// What the rows that an event meets have become.
enum class Rows { traced_at_vertex, absent, open, converged };

inline const char* name_of(Rows rows) {
  constexpr std::array<const char*, 4> names{"exact", "unborn", "open", "converged"};
  return names[static_cast<std::size_t>(rows)];
}

/// A model with one fiber. teach() draws `events` at wr (xi at random unless fixed), with one light sample each.
class LearnedModel {
 public:
  /// info: of a model with rows.
  LearnedModel(const fiber::FiberParameters& parameters, fiber::Estimator estimator, adaptive::Options options = {},
               const fiber::ModelInfo& info = *references::find_model("elliptical"))
      : info_(info), parameters_(parameters), learned_(fiber::make_service(info, options)) {
    read_by(estimator);
  }
  LearnedModel(const fiber::FiberParameters& parameters, bool exact, adaptive::Options options = {})
      : LearnedModel(parameters, exact ? fiber::Estimator::exact : fiber::Estimator::fitted, options) {}

  /// Another estimator on the same rows, whatever they have become.
  void read_by(fiber::Estimator estimator) {
    model_ = info_.make(
        {.estimator = estimator, .service = estimator == fiber::Estimator::exact ? nullptr : learned_.service.get()});
    fiber_ = model_->add_fiber(parameters_);
  }

  fiber::FiberEvent begin(const fiber::FiberDirection& wr, float xi1 = 0.37f, float xi2 = 0.61f) const {
    return model_->begin(fiber_, wr, xi1, xi2, 0);
  }

  void teach(const fiber::FiberDirection& wr, int passes, int events, std::uint64_t seed, bool fixed_xi) {
    for (int pass = 0; pass < passes; ++pass) {
      RandomStream random(seed, static_cast<std::uint64_t>(pass));
      for (int i = 0; i < events; ++i) {
        const float xi1 = random.next(), xi2 = random.next();
        const fiber::FiberEvent event = fixed_xi ? begin(wr) : begin(wr, xi1, xi2);
        (void)model_->sample(event, {random.next(), random.next(), random.next(), random.next()});
        (void)model_->evaluate(event, {3.1f * (random.next() - 0.5f), 6.28f * (random.next() - 0.5f)});
      }
      report_ = service().publish();
    }
  }

  /// Takes the rows that events at wr meet to a state.
  void bring_to(Rows rows, const fiber::FiberDirection& wr, bool fixed_xi = true) {
    if (rows == Rows::open) teach(wr, 1, 400, 5, fixed_xi);
    if (rows == Rows::converged) teach(wr, 24, fixed_xi ? 1500 : 5000, 7, fixed_xi);
  }

  fiber::FiberModel& model() { return *model_; }
  const fiber::FiberModel& model() const { return *model_; }
  adaptive::Service& service() { return *learned_.service; }
  const adaptive::PassReport& report() const { return report_; }

 private:
  const fiber::ModelInfo& info_;
  fiber::FiberParameters parameters_;
  fiber::ModelService learned_;
  std::unique_ptr<fiber::FiberModel> model_;
  fiber::FiberId fiber_ = 0;
  adaptive::PassReport report_;
};

inline std::unique_ptr<LearnedModel> model_in(Rows rows, const fiber::FiberParameters& parameters,
                                              const fiber::FiberDirection& wr, bool fixed_xi = true) {
  auto model = std::make_unique<LearnedModel>(parameters, rows == Rows::traced_at_vertex);
  model->bring_to(rows, wr, fixed_xi);
  return model;
}

}  // namespace tress::test
