// pekelis2015 with a service of its own, taught by shading events at one known direction.
#pragma once

#include <cstdint>
#include <memory>

#include "references/models/pekelis2015.h"
#include "references/registry.h"
#include "tress/adaptive/service.h"
#include "tress/base/random.h"

namespace tress::test {

class TaughtPekelis {
 public:
  TaughtPekelis(const fiber::FiberParameters& parameters, fiber::PekelisReading reading,
                const adaptive::Learner* learner = &adaptive::sketch_learner)
      : target_(fiber::make_pekelis2015_target()), service_(options(learner), *target_) {
    model_ = fiber::make_pekelis2015({.service = &service_}, reading);
    fiber_ = model_->add_fiber(parameters);
  }

  const fiber::FiberModel& model() const { return *model_; }
  fiber::FiberEvent begin(const fiber::FiberDirection& wr) const { return model_->begin(fiber_, wr, 0, 0, 0); }

  /// Each event draws one sample and evaluates one direction: theta_i about the specular cone, phi uniform.
  void teach(const fiber::FiberDirection& wr, int passes, int events) {
    for (int pass = 0; pass < passes; ++pass) {
      RandomStream random(7, static_cast<std::uint64_t>(pass));
      const fiber::FiberEvent event = begin(wr);
      for (int i = 0; i < events; ++i) {
        (void)model_->sample(event, {random.next(), random.next(), random.next(), random.next()});
        (void)model_->evaluate(event, {-wr.theta, 6.28f * (random.next() - 0.5f)});
      }
      report_ = service_.publish();
    }
  }
  const adaptive::PassReport& report() const { return report_; }

 private:
  static adaptive::Options options(const adaptive::Learner* learner) {
    adaptive::Options options;
    options.learner = learner;
    return options;
  }

  std::unique_ptr<adaptive::Target> target_;
  adaptive::Service service_;
  std::unique_ptr<fiber::FiberModel> model_;
  fiber::FiberId fiber_ = 0;
  adaptive::PassReport report_;
};

}  // namespace tress::test
