// The loops over samples in which a fit spends its time, for the widest instruction set that the machine has.
#pragma once

#include <cstddef>

namespace tress::inline v0_2::adaptive {

/// Arrays are padded to a multiple of this many doubles; the padding must be finite and have weight zero.
constexpr std::size_t kernel_lanes = 8;
constexpr std::size_t padded_size(std::size_t n) { return (n + kernel_lanes - 1) / kernel_lanes * kernel_lanes; }

/// One component in double: a skew logistic of mass 1 at mu, with the terms of its gradient (ESTIMATOR.md, E1).
struct Shape {
  Shape(double mode, double scale_left, double scale_right);
  double mu;                       ///< radians in [-pi, pi]
  double left, right;              ///< scales, radians
  double inverse_z;                ///< 1/Z
  double log_z_left, log_z_right;  ///< d ln Z / d ln s of each side
};

/// Adds weight p(azimuth_i) to f_i. Azimuths in [-pi, pi].
void add_density(const Shape& shape, double weight, const double* azimuth, std::size_t n, double* f);

/// Fills four columns, `stride` apart, with weight times the derivatives of p by weight (for this one, p itself without
/// the factor), mu, ln s_left and ln s_right; also adds weight p to f.
void add_density_and_columns(const Shape& shape, double weight, const double* azimuth, std::size_t n, double* f,
                             double* columns, std::size_t stride);

/// Returns the sum of cell_i (f_i - g_i)^2.
double squared_error(const double* cell, const double* f, const double* g, std::size_t n);

/// Writes the lower half of J^T W J into `normal` (column major, `leading` apart) and J^T W (f - g) into `gradient`, W
/// = diag(cell). `scratch`: 2 n doubles.
void normal_equations(const double* columns, std::size_t stride, std::size_t count, const double* cell, const double* f,
                      const double* g, std::size_t n, double* scratch, double* normal, std::size_t leading,
                      double* gradient);

/// Sums over the samples of cell (g - f) p and of cell p^2, as a component of weight first/second would explain them.
struct Projection {
  double explained, power;
};
Projection project(const Shape& shape, const double* azimuth, const double* cell, const double* f, const double* g,
                   std::size_t n);

constexpr std::size_t most_solved = 64;
/// Solves the positive definite `matrix` x = right in place, by L D L^T of the lower half without pivoting. On entry
/// `x` is the right side, at most most_solved long. The matrix is column major, its columns `leading` apart, a multiple
/// of kernel_lanes; x is as long. Destroys the matrix. Where rounding has made a pivot zero or negative, the entry of x
/// is 0.
void solve_in_place(double* matrix, std::size_t leading, std::size_t count, double* x);

/// Computes out_i = sum over k < taps of kernel_k in_(i + k), i < n; `in` holds n + taps - 1 values.
void blur_row(const double* in, const double* kernel, std::size_t taps, double* out, std::size_t n);

}  // namespace tress::inline v0_2::adaptive
