// The data that the elliptical model keeps with an event: all that depends on the known direction only.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>

#include "base/float4.h"
#include "fiber/longitudinal.h"
#include "fiber/reflection.h"
#include "fiber/row_axes.h"
#include "models/elliptical/colored_rows.h"
#include "models/elliptical/elliptical_fiber.h"

namespace tress::inline v0_2::fiber {

/// Computed once per event and used for every direction of it. Lanes are row_lobes unless said otherwise.
struct VertexConstants {
  ReflectionLobe reflection;
  LongitudinalLobes longitudinal;  ///< by order p - 1: TT, TRT (GLINT too), TRRT (residual too); R is unused
  Float4 uniform_pdf;              ///< for each lobe: its selection times the uniform share of its proposal, 1/rad
  /// Rows of the nodes that xi1 chose, by the node in |theta_d|. Lobes that are not selected get rows of density 0. If
  /// rows do not answer on their own, all runs are without answers.
  std::array<adaptive::RowRun, 4> runs;
  FoldedAzimuth fold;
  float inverse_luminance;    ///< 1 over the luminance of all lobes: the factor of their selections
  glm::vec3 reflection_gain;  ///< gain of R, times what roughness leaves of its energy
  std::uint64_t hash;         ///< hash of xi and the known direction, for `corrected`
};

}  // namespace tress::inline v0_2::fiber
