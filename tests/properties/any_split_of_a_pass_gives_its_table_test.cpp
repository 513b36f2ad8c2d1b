// One pass equals its pieces, for every learner: the same observations, in any order and split over any threads, give
// the same table and report the same. A ceiling is kept, and changes nothing of this.
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "adaptive/drive_service.h"
#include "adaptive/toy_target.h"
#include "properties/generators.h"
#include "references/registry.h"
#include "tress/adaptive/learner.h"

namespace tress::inline v0_2::adaptive {
namespace {

struct Learned {
  std::string bytes;
  PassReport last;
};

Learned learn(const Options& options, std::uint64_t first_pass, std::uint32_t passes, std::size_t queries,
              unsigned threads) {
  const testing::MovingPeaks target;
  Service service(options, target);
  for (std::uint32_t p = 0; p < 2; ++p) service.add_slice(testing::toy_slice(p, 3, p == 0 ? 0.3f : 0.1f));
  Learned learned;
  for (std::uint64_t pass = 0; pass < passes; ++pass) {
    testing::run_pass(service, 2, first_pass + pass, queries, threads);
    learned.last = service.publish();
    RC_ASSERT(learned.last.bytes <= options.memory_bytes);
  }
  learned.bytes = encode_cache(service.snapshot());
  return learned;
}

/// Drawn as numbers: learner, threads, ceiling, passes, queries, seed.
TRESS_DEAR_PROPERTY(Service, OfAnyLearnerLearnsTheSameFromAPassAndItsPieces, 20) {
  const std::vector<std::uint32_t> drawn = *any_numbers(6, 1000);
  Options options;
  options.learner = references::learners()[drawn[0] % references::learners().size()];
  options.tests_before_refusal = 4;
  options.max_components = 4;
  options.seed = drawn[5];
  // From room for a row or two to room for all.
  if (drawn[2] % 2 == 1) options.memory_bytes = 4000 + 60 * drawn[2];
  const std::uint32_t passes = 1 + drawn[3] % 4;
  const std::size_t queries = drawn[4];
  const Learned one = learn(options, drawn[5], passes, queries, 1);
  const Learned many = learn(options, drawn[5], passes, queries, 2 + drawn[1] % 7);
  RC_ASSERT(many.bytes == one.bytes);
  RC_ASSERT(many.last.queries == one.last.queries);
  RC_ASSERT(many.last.g_evaluations == one.last.g_evaluations);
  RC_ASSERT(many.last.refits == one.last.refits);
  RC_ASSERT(many.last.creations == one.last.creations);
  RC_ASSERT(many.last.bytes == one.last.bytes);
  RC_ASSERT(many.last.at_ceiling == one.last.at_ceiling);
  RC_ASSERT(many.last.effective_sample_size == one.last.effective_sample_size);
  RC_ASSERT(many.last.objective_p50 == one.last.objective_p50);
  // At the ceiling the memo has room for some nodes only, first come, first served: others are traced at every query.
  if (options.memory_bytes == Options{}.memory_bytes) RC_ASSERT(many.last.traces == one.last.traces);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
