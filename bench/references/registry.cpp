#include "references/registry.h"

#include <array>

#include "references/learners/ais_learner.h"
#include "references/learners/appendix_learner.h"
#include "references/learners/eager_learner.h"
#include "references/learners/em_learner.h"
#include "references/models/deon2011.h"
#include "references/models/deon2022.h"
#include "references/models/marschner2003.h"
#include "references/models/ou2012.h"
#include "references/models/pekelis2015.h"

namespace tress::references {
namespace {

using fiber::ModelInfo;
using fiber::ModelSettings;

const ModelInfo all_models[] = {
    fiber::elliptical_info,
    fiber::rough_info,
    fiber::chiang2016_info,
    {.name = "deon2011",
     .source = "d'Eon, Francois, Hill, Letteri, Aubry 2011; sampling of d'Eon, Marschner, Hanika 2013",
     .summary = "circular fibers, a Gaussian detector by quadrature over the width, energy-conserving lobes",
     .make_target = nullptr,
     .make = fiber::make_deon2011,
     .conserves_energy = true,
     .has_quadrature = true},
    {.name = "deon2022",
     .source = "d'Eon 2022 (NVIDIA RTXCR); R of d'Eon, Marschner, Hanika 2014, TT of Marschner et al. 2003",
     .summary = "round fibers in closed form, TRT as three fitted Gaussians; not normalised",
     .make_target = nullptr,
     .make = fiber::make_deon2022},
    {.name = "ou2012",
     .source = "Ou, Xie, Krishnamachari, Pellacini 2012; Sadeghi, Pritchett, Jensen, Tamstorf 2010",
     .summary = "artist-friendly lobes, not normalised, with a Fresnel term in R",
     .make_target = nullptr,
     .make = fiber::make_ou2012},
    {.name = "marschner2003",
     .source = "Marschner, Jensen, Cammarano, Worley, Hanrahan 2003",
     .summary = "the cubic approximation with eta*(phi_h) and its caustics smoothed; a reference, not normalised",
     .make_target = nullptr,
     .make = fiber::make_marschner2003},
    fiber::fiber3d_info,
    {.name = "pekelis2015",
     .source = "Pekelis, Hery, Villemin, Ling 2015, sections 3 to 6",
     .summary = "the paper's own model: Marschner's TRT and GLINT as fitted mixtures, nearest row, not normalised",
     .make_target = fiber::make_pekelis2015_target,
     .make = [](const ModelSettings& s) { return make_pekelis2015(s, fiber::PekelisReading::corrected); }},
    {.name = "pekelis2015-printed",
     .source = "Pekelis, Hery, Villemin, Ling 2015, equations 2, 3 and 5 and s(theta_D) as printed",
     .summary = "the same with the equations as printed, to see what they do: far too bright at grazing angles",
     .make_target = fiber::make_pekelis2015_target,
     .make = [](const ModelSettings& s) { return make_pekelis2015(s, fiber::PekelisReading::as_printed); }},
};

}  // namespace

using adaptive::Learner;
using adaptive::make_row_learner;

constinit const Learner eager_learner{"eager", "ours on samples of its own, when a row is created",
                                      make_row_learner<adaptive::EagerLearner>};
constinit const Learner ais_learner{"ais", "the paper's adaptive importance sampling, when a row is created",
                                    make_row_learner<adaptive::AisLearner>};
constinit const Learner em_learner{"em", "stepwise expectation maximisation, after each pass",
                                   make_row_learner<adaptive::EmLearner>};
constinit const Learner appendix_learner{"appendix",
                                         "one sample at a time, the nearest to the paper's 9.1 that converges",
                                         make_row_learner<adaptive::AppendixLearner>};
constinit const Learner appendix_literal_learner{"appendix-literal", "the paper's 9.1 as printed: it does not converge",
                                                 make_row_learner<adaptive::LiteralAppendixLearner>};

fiber::Catalog catalog() {
  static constexpr std::array all_learners{
      &adaptive::sketch_learner, &eager_learner,           &ais_learner, &em_learner,
      &appendix_learner,         &appendix_literal_learner};
  return {all_models, all_learners};
}

std::span<const ModelInfo> models() { return catalog().models; }
std::span<const Learner* const> learners() { return catalog().learners; }
const ModelInfo* find_model(std::string_view name) { return catalog().find_model(name); }
const Learner* find_learner(std::string_view name) { return catalog().find_learner(name); }

}  // namespace tress::references
