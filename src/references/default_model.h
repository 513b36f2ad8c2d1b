// The fiber model of a command that names none.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "models/registry.h"
#include "tress/fiber/parameters.h"

namespace tress::adaptive {
class RowSource;
}

namespace tress::references {

/// Of chart 4 (bench/README.md): a third of the error of `elliptical` or less, at 0.95 to 1.14 times its time, warm.
inline constexpr std::string_view default_model = "rough";

/// Whether lobes are given widths, another shape or a Fresnel term: a traced fiber has no lobes that could have them.
bool shapes_lobes(const fiber::FiberParameters& fiber);

/// Whether there are fibers, the lobes of all are those of Chiang et al. 2016, and nothing is asked that the model of
/// them lacks.
bool have_published_lobes(std::span<const fiber::FiberParameters> fibers);

/// What a command that names no model says of it all the same.
struct ModelHints {
  std::string option{};              ///< one that was given and has a meaning, or another, for `elliptical`; else empty
  bool needs_rows = false;           ///< an option was given that only models with rows have
  bool shapes_lobes = false;         ///< a material of the scene does
  bool has_published_lobes = false;  ///< all hair of the scene has
  std::filesystem::path warm_cache{};  ///< that rows are read from; empty: none
};

/// `why`: empty where it is default_model for want of hints, else in words.
struct ChosenModel {
  std::string name, why;
};

/// `elliptical` if there is an option that speaks of it, so that commands from the time when it was the default do what
/// they did; `chiang2016` for hair that was given by its lobes, so that it looks as where it comes from, unless rows
/// are needed; `elliptical` if a material shapes its lobes otherwise; else the model whose rows the cache has, so that
/// a shot goes on as it began; else default_model. A cache that is absent, empty or cannot be read says nothing. Any
/// thread.
ChosenModel choose_model(const ModelHints& hints);

/// The model whose rows these are, `rough` where some slices are of samples; goes through them from the first as far as
/// it must. Null if there is none, or of no model here.
const fiber::ModelInfo* model_of_rows(adaptive::RowSource& rows);

}  // namespace tress::references
