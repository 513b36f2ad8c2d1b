// What the methods that take samples one by one or in small batches share: their start, their draws, their parameters.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fit/problem.h"
#include "fit/row_learner.h"

namespace tress::inline v0_2::adaptive {

/// Draws of a pass that are replayed at most; more are left unused.
constexpr std::uint64_t most_replayed = 256;

/// A mixture of exactly D = max_components to begin with, as a vector of parameters (problem.h): what `warm` has, if
/// given, and broad components at equal distances, of the energy.
Vector starting_parameters(const FitContext& context, int components, const Mixture* warm);

/// The mixture of these parameters, brought within the constraints and to the energy of the row.
Mixture mixture_of(const Vector& parameters, double energy);

/// For RowLearner::state(): a vector of parameters behind the number of its entries, and back; false if the words do
/// not begin with one. What is read is taken from their front.
void append_vector(const Vector& vector, std::vector<std::uint64_t>& words);
bool take_vector(std::span<const std::uint64_t>& words, Vector& vector);

/// An azimuth drawn from `proposal` with density q, and the exact g there.
struct WeightedDraw {
  float azimuth;
  double g;
  double q;
};

/// As many draws from the proposal of `fit` as the pass scored, at most most_replayed, each from its own stratum of the
/// proposal's mass (so that a small batch is spread as the mass is). g is asked and counted.
std::vector<WeightedDraw> replay(FitContext& context, const Mixture& fit, std::uint64_t draws);

/// f at one azimuth and its derivatives by the parameters (4 D + 1 of them). x in [-pi, pi).
double density_and_gradient(const Vector& parameters, double x, Vector& gradient);

}  // namespace tress::inline v0_2::adaptive
