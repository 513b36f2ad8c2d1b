// The far field of one fiber by any model: which part of the light that comes in from one direction leaves into which
// bin of directions, lobe by lobe. In the conventions of ../shared/reference/README.md and its fiber3d.csv: per unit of
// intercepted flux, the offset h uniform over the projected width; directions point away from the fiber, theta from the
// normal plane towards the tip, phi absolute from the major axis towards the minor one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tress/fiber/fiber_model.h"

namespace tress::references {

/// Lobes by order: the GLINT is in TRT, `rest` is TRRT and everything later, `whole` is the sum of the others.
constexpr std::size_t flux_parts = 5;
constexpr std::array<const char*, flux_parts> flux_part_names{"R", "TT", "TRT", "rest", "whole"};
constexpr std::size_t whole_flux = flux_parts - 1;
std::size_t flux_part(std::size_t lobe);  ///< of lobe_names

struct FarFieldRequest {
  fiber::FiberDirection wr;         ///< where light comes from, radians; |theta| < pi/2
  std::size_t theta_bins = 36;      ///< equal steps of theta_i from -pi/2 up, >= 1
  std::size_t phi_bins = 36;        ///< equal steps of phi_i from -pi up, >= 1
  std::uint64_t paths = 1'000'000;  ///< traced, or directions that are evaluated; >= 1
  std::size_t shifts = 16;          ///< >= 2, of a model that evaluates; each has a point a bin at least
  std::uint64_t seed = 0;
};

/// Of one part: fractions of the flux by channel and bin (theta index times phi_bins plus phi index), and their sums.
struct PartialFlux {
  std::array<std::vector<double>, 3> flux, standard_error;
  std::array<double, 3> energy{}, energy_error{};
};

struct FarField {
  std::array<PartialFlux, flux_parts> parts;
  std::uint64_t evaluations = 0;  ///< directions evaluated
  std::uint64_t paths = 0;        ///< paths traced, where the model or an event of it can only be sampled
};

/// A model that evaluates: S integrated over each bin and over h and the numbers that choose nodes by additive
/// recurrences in five dimensions, shifted at random; standard errors by the shifts. A model that can only be
/// sampled: paths, h stratified; standard errors by the weights of single paths, 0 where no path came. Events of a
/// model that evaluates others (FiberModel::evaluates(event)) are sampled, and both added.
/// Same request, same bits, for any number of threads (oneTBB).
FarField far_field(const fiber::FiberModel& model, fiber::FiberId fiber, const FarFieldRequest& request);

}  // namespace tress::references
