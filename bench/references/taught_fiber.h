// One fiber of any model, with the rows that its directions ask learned beforehand: what is measured of a model is then
// what a render sees once its table has converged.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "models/registry.h"
#include "tress/adaptive/options.h"
#include "tress/base/random.h"
#include "tress/fiber/fiber_model.h"

namespace tress::references {

/// What teaching has come to. Zeros for models without rows.
struct Lesson {
  int passes = 0;
  std::uint64_t converged = 0, open = 0, refused = 0;  ///< rows of the fiber
};

/// Thread-safety: model() as FiberModel says; the rest one thread.
class TaughtFiber {
 public:
  /// Draws a known direction, radians.
  using Directions = std::function<fiber::FiberDirection(RandomStream&)>;

  /// parameters: in range. options: of the table, for models with rows; rows are created at their first query. The
  /// service of `settings` is not read. info must outlive it.
  TaughtFiber(const fiber::ModelInfo& info, const fiber::FiberParameters& parameters, const adaptive::Options& options,
              fiber::ModelSettings settings = {});

  /// Shading events at directions that `known` draws, each with one sampled and one given direction, pass by pass until
  /// a pass leaves no row that learns on, or most_passes are over. Same seed, same rows.
  Lesson teach(const Directions& known, std::uint64_t seed);

  const fiber::FiberModel& model() const { return *model_; }
  fiber::FiberId fiber() const { return fiber_; }
  bool has_rows() const { return learned_.service != nullptr; }

 private:
  static constexpr int most_passes = 256, events_a_pass = 4096;

  fiber::ModelService learned_;
  std::unique_ptr<fiber::FiberModel> model_;
  fiber::FiberId fiber_ = 0;
};

}  // namespace tress::references
