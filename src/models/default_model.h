// The fiber model of a scene where nobody names one: by its materials alone. What is asked of accuracy (an epsilon, an
// estimator, a learner, a cache) never changes what is drawn, only how well.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "models/registry.h"
#include "tress/fiber/parameters.h"

namespace tress::fiber {

/// Of chart 4 (bench/README.md): a third of the error of `elliptical` or less, at 0.95 to 1.14 times its time, warm.
inline constexpr const char* usual_model = "rough";

/// Whether lobes are given widths, another shape or a Fresnel term: a traced fiber has no lobes that could have them.
bool shapes_lobes(const FiberParameters& fiber);

/// Whether there are fibers, the lobes of all are those of Chiang et al. 2016, and nothing is asked that the model of
/// them lacks.
bool have_published_lobes(std::span<const FiberParameters> fibers);

/// `why`: empty where it is usual_model, else in words.
struct ChosenModel {
  const ModelInfo* info;
  std::string why;
};

/// `chiang2016` for hair that was given by its lobes, so that it looks as where it comes from; `elliptical` if a
/// material shapes its lobes otherwise; else usual_model. materials: those that the scene states, one fiber each;
/// fibers: those that its strands have, whose widths may be written out. Any thread.
ChosenModel default_model(std::span<const FiberParameters> materials, std::span<const FiberParameters> fibers);

/// All that default_model() can choose.
std::vector<const ModelInfo*> default_models();

}  // namespace tress::fiber
