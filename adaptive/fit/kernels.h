// The loops over samples that a fit spends its time in, for the widest instruction set that the machine has.
#pragma once

#include <cstddef>

namespace tress::adaptive {

/// Arrays are padded to a multiple of this many doubles; what is in the padding must be finite, its weight zero.
constexpr std::size_t kernel_lanes = 8;
constexpr std::size_t padded_size(std::size_t n) { return (n + kernel_lanes - 1) / kernel_lanes * kernel_lanes; }

/// One component in double: a skew logistic of mass 1 at mu, and what its gradient needs (ESTIMATOR.md, E1).
struct Shape {
  Shape(double mode, double scale_left, double scale_right);
  double mu;                       ///< radians in [-pi, pi]
  double left, right;              ///< scales, radians
  double inverse_z;                ///< 1/Z
  double log_z_left, log_z_right;  ///< d ln Z / d ln s of each side
};

/// f_i += weight p(azimuth_i). Azimuths in [-pi, pi].
void add_density(const Shape& shape, double weight, const double* azimuth, std::size_t n, double* f);

/// Fills four columns, `stride` apart, with weight times the derivatives of p by weight (p itself, without it), mu,
/// ln s_left and ln s_right; and adds weight p to f.
void add_density_and_columns(const Shape& shape, double weight, const double* azimuth, std::size_t n, double* f,
                             double* columns, std::size_t stride);

/// Sum of cell_i (f_i - g_i)^2.
double squared_error(const double* cell, const double* f, const double* g, std::size_t n);

/// Lower half of J^T W J into `normal` (column major, `leading` apart) and J^T W (f - g) into `gradient`, W =
/// diag(cell). `scratch`: 2 n doubles.
void normal_equations(const double* columns, std::size_t stride, std::size_t count, const double* cell, const double* f,
                      const double* g, std::size_t n, double* scratch, double* normal, std::size_t leading,
                      double* gradient);

/// Sums over the samples of cell (g - f) p and of cell p^2: what a component of weight first/second would explain.
struct Projection {
  double explained, power;
};
Projection project(const Shape& shape, const double* azimuth, const double* cell, const double* f, const double* g,
                   std::size_t n);

constexpr std::size_t most_solved = 64;
/// Solves the positive definite `matrix` x = right in place, by L D L^T of the lower half without pivoting; what is in
/// `x` before is the right side, at most most_solved long. Column major, columns `leading` apart, a multiple of
/// kernel_lanes; x as long. Destroys the matrix. A pivot that rounding has made nothing leaves its entry 0.
void solve_in_place(double* matrix, std::size_t leading, std::size_t count, double* x);

/// out_i = sum over k < taps of kernel_k in_(i + k), i < n; `in` holds n + taps - 1.
void blur_row(const double* in, const double* kernel, std::size_t taps, double* out, std::size_t n);

}  // namespace tress::adaptive
