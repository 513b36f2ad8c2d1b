// The fiber model of a scene if none is named: its materials alone decide. Options of accuracy (an epsilon, an
// estimator, a learner, a cache) never change the model.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "models/registry.h"
#include "tress/fiber/parameters.h"

namespace tress::inline v0_2::fiber {

/// The usual choice (bench/README.md, chart 4): at most a third of the error of `elliptical`, in 0.95 to 1.14 times its
/// time with a warm cache.
inline constexpr const char* usual_model = "rough";

/// Whether the fiber sets widths of lobes, another shape or a Fresnel term: a traced fiber has no lobes to which they
/// could apply.
bool shapes_lobes(const FiberParameters& fiber);

/// Whether all fibers, at least one, have the lobes of Chiang et al. 2016 and need no feature that the model of these
/// lobes lacks.
bool have_published_lobes(std::span<const FiberParameters> fibers);

/// `why`: the reason in words; empty for usual_model.
struct ChosenModel {
  const ModelInfo* info;
  std::string why;
};

/// Chooses `chiang2016` for hair that was given by its lobes, so that it looks as in its original renderer;
/// `elliptical` if a material shapes its lobes in another way; else usual_model. materials: the scene's materials, one
/// fiber each; fibers: those of its strands, whose widths may be explicit. Any thread.
ChosenModel default_model(std::span<const FiberParameters> materials, std::span<const FiberParameters> fibers);

/// All models that default_model() can choose.
std::vector<const ModelInfo*> default_models();

}  // namespace tress::inline v0_2::fiber
