#include "models/registry.h"

#include <algorithm>
#include <iterator>

#include "models/chiang2016.h"
#include "models/deon2011.h"
#include "models/fiber3d.h"
#include "models/marschner2003.h"
#include "models/ou2012.h"
#include "models/pekelis2015.h"

namespace tress::fiber {
namespace {

constexpr ModelInfo all_models[] = {
    {.name = "elliptical",
     .source = "Pekelis, Hery, Villemin, Ling 2015, appendix; adaptive/ESTIMATOR.md",
     .summary = "elliptical fibers, traced exactly and learned while rendering",
     .make_target = make_elliptical_target,
     .make = [](const ModelSettings& s) { return make_elliptical_model(s.estimator, s.service); },
     .conserves_energy = true},
    {.name = "chiang2016",
     .source = "Chiang, Bitterli, Tappan, Burley 2016",
     .summary = "near field, trimmed logistics and a geometric series: what today's renderers ship",
     .make_target = nullptr,
     .make = make_chiang2016,
     .conserves_energy = true},
    {.name = "deon2011",
     .source = "d'Eon, Francois, Hill, Letteri, Aubry 2011; sampling of d'Eon, Marschner, Hanika 2013",
     .summary = "circular fibers, a Gaussian detector by quadrature over the width, energy-conserving lobes",
     .make_target = nullptr,
     .make = make_deon2011,
     .conserves_energy = true,
     .has_quadrature = true},
    {.name = "ou2012",
     .source = "Ou, Xie, Krishnamachari, Pellacini 2012; Sadeghi, Pritchett, Jensen, Tamstorf 2010",
     .summary = "artist-friendly lobes, not normalised, with a Fresnel term in R",
     .make_target = nullptr,
     .make = make_ou2012},
    {.name = "marschner2003",
     .source = "Marschner, Jensen, Cammarano, Worley, Hanrahan 2003",
     .summary = "the cubic approximation with eta*(phi_h) and its caustics smoothed; a reference, not normalised",
     .make_target = nullptr,
     .make = make_marschner2003},
    {.name = "fiber3d",
     .source = "traced Beckmann facets: visible normals of Heitz and d'Eon 2014, walk of Heitz et al. 2016",
     .summary = "the ground truth: a rough elliptical fiber, path traced at every hit; no light sampling",
     .make_target = nullptr,
     .make = make_fiber3d,
     .conserves_energy = true},
    {.name = "pekelis2015",
     .source = "Pekelis, Hery, Villemin, Ling 2015, sections 3 to 6",
     .summary = "the paper's own model: Marschner's TRT and GLINT as fitted mixtures, nearest row, not normalised",
     .make_target = make_pekelis2015_target,
     .make = [](const ModelSettings& s) { return make_pekelis2015(s, PekelisReading::corrected); }},
    {.name = "pekelis2015-printed",
     .source = "Pekelis, Hery, Villemin, Ling 2015, equations 2, 3 and 5 and s(theta_D) as printed",
     .summary = "the same with the equations as printed, to see what they do: far too bright at grazing angles",
     .make_target = make_pekelis2015_target,
     .make = [](const ModelSettings& s) { return make_pekelis2015(s, PekelisReading::as_printed); }},
};

}  // namespace

std::span<const ModelInfo> models() { return all_models; }

const ModelInfo* find_model(const std::string& name) {
  const auto found = std::find_if(std::begin(all_models), std::end(all_models),
                                  [&](const ModelInfo& model) { return model.name == name; });
  return found == std::end(all_models) ? nullptr : found;
}

}  // namespace tress::fiber
