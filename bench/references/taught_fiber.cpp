#include "references/taught_fiber.h"

#include <numbers>

namespace tress::references {

TaughtFiber::TaughtFiber(const fiber::ModelInfo& info, const fiber::FiberParameters& parameters,
                         const adaptive::Options& options, fiber::ModelSettings settings) {
  settings.service = nullptr;
  if (info.has_rows()) {
    adaptive::Options eager = options;
    eager.queries_before_creation = 1;
    eager.learns_to_epsilon = true;
    learned_ = fiber::make_service(info, eager);
    settings.service = learned_.service.get();
  }
  model_ = info.make(settings);
  fiber_ = model_->add_fiber(parameters);
}

Lesson TaughtFiber::teach(const Directions& known, std::uint64_t seed) {
  Lesson lesson;
  if (!learned_.service) return lesson;
  constexpr float pi = std::numbers::pi_v<float>;
  constexpr std::uint64_t teaching = 0x7465616368ull;
  for (bool done = false; !done && lesson.passes < most_passes;) {
    RandomStream random(seed, teaching, static_cast<std::uint64_t>(lesson.passes));
    for (int i = 0; i < events_a_pass; ++i) {
      const fiber::FiberDirection wr = known(random);
      const float xi1 = random.next(), xi2 = random.next(), h = 2 * random.next() - 1;
      const fiber::FiberEvent event = model_->begin(fiber_, wr, xi1, xi2, h);
      (void)model_->sample(event, {random.next(), random.next(), random.next(), random.next()});
      const float theta = pi * (random.next() - 0.5f);
      (void)model_->evaluate(event, {theta, 2 * pi * (random.next() - 0.5f)});
    }
    const adaptive::PassReport report = learned_.service->publish(events_a_pass);
    ++lesson.passes;
    lesson.converged = report.rows_converged;
    lesson.open = report.rows_open;
    lesson.refused = report.rows_refused;
    const bool learns = report.rows_open > 0 && report.g_evaluations > 0 && !report.at_ceiling;
    done = report.creations == 0 && !learns;
  }
  return lesson;
}

}  // namespace tress::references
