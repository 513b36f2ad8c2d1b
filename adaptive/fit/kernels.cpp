#include "fit/kernels.h"

#include <cmath>

// foreach_target compiles this once for every instruction set; the first call chooses the machine's.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fit/kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "base/exp_lanes.h"
#include "base/pi.h"

HWY_BEFORE_NAMESPACE();
namespace tress::inline v0_2::adaptive {
namespace HWY_NAMESPACE {

using namespace tress::HWY_NAMESPACE;

// x = azimuth - mu in [-pi, pi].
HWY_INLINE V Offset(const double* azimuth, V mu) {
  const Doubles d;
  const V half = hn::Set(d, pi), turn = hn::Set(d, two_pi);
  V x = hn::Sub(hn::LoadU(d, azimuth), mu);
  x = hn::IfThenElse(hn::Ge(x, half), hn::Sub(x, turn), x);
  return hn::IfThenElse(hn::Lt(x, hn::Neg(half)), hn::Add(x, turn), x);
}

HWY_INLINE V Density(V x, V inverse_left, V inverse_right, V inverse_z) {
  const Doubles d;
  const V one = hn::Set(d, 1.0);
  const V inverse_s = hn::IfThenElse(hn::Lt(x, hn::Zero(d)), inverse_left, inverse_right);
  const V e = Exp(hn::Neg(hn::Mul(hn::Abs(x), inverse_s)));
  const V below = hn::Add(one, e);
  return hn::Div(hn::Mul(e, inverse_z), hn::Mul(below, below));
}

HWY_INLINE double Total(V v) {
  const Doubles d;
  return hn::GetLane(hn::SumOfLanes(d, v));
}

void AddDensity(const Shape& shape, double weight, const double* azimuth, std::size_t n, double* f) {
  const Doubles d;
  const V left = hn::Set(d, 1 / shape.left), right = hn::Set(d, 1 / shape.right);
  const V z = hn::Set(d, weight * shape.inverse_z), mu = hn::Set(d, shape.mu);
  for (std::size_t i = 0; i < n; i += hn::Lanes(d)) {
    hn::StoreU(hn::Add(hn::LoadU(d, f + i), Density(Offset(azimuth + i, mu), left, right, z)), d, f + i);
  }
}

void AddDensityAndColumns(const Shape& shape, double weight, const double* azimuth, std::size_t n, double* f,
                          double* columns, std::size_t stride) {
  const Doubles d;
  const V left = hn::Set(d, 1 / shape.left), right = hn::Set(d, 1 / shape.right);
  const V z = hn::Set(d, shape.inverse_z), mu = hn::Set(d, shape.mu), one = hn::Set(d, 1.0), zero = hn::Zero(d);
  const V a = hn::Set(d, weight), z_left = hn::Set(d, shape.log_z_left), z_right = hn::Set(d, shape.log_z_right);
  for (std::size_t i = 0; i < n; i += hn::Lanes(d)) {
    const V x = Offset(azimuth + i, mu);
    const auto on_left = hn::Lt(x, zero);
    const V inverse_s = hn::IfThenElse(on_left, left, right);
    const V y = hn::Mul(hn::Abs(x), inverse_s);
    const V e = Exp(hn::Neg(y));
    const V inverse = hn::Div(one, hn::Add(one, e));
    const V t = hn::Mul(hn::Sub(one, e), inverse);
    const V p = hn::Mul(hn::Mul(hn::Mul(e, inverse), inverse), z);
    const V ap = hn::Mul(a, p);
    const V apt = hn::Mul(ap, t);
    const V slope = hn::Mul(apt, inverse_s);
    const V widening = hn::Mul(apt, y);
    hn::StoreU(hn::Add(hn::LoadU(d, f + i), ap), d, f + i);
    hn::StoreU(p, d, columns + i);
    hn::StoreU(hn::IfThenElse(on_left, hn::Neg(slope), slope), d, columns + stride + i);
    hn::StoreU(hn::NegMulAdd(ap, z_left, hn::IfThenElseZero(on_left, widening)), d, columns + 2 * stride + i);
    hn::StoreU(hn::NegMulAdd(ap, z_right, hn::IfThenZeroElse(on_left, widening)), d, columns + 3 * stride + i);
  }
}

double SquaredError(const double* cell, const double* f, const double* g, std::size_t n) {
  const Doubles d;
  V sum = hn::Zero(d);
  for (std::size_t i = 0; i < n; i += hn::Lanes(d)) {
    const V r = hn::Sub(hn::LoadU(d, f + i), hn::LoadU(d, g + i));
    sum = hn::MulAdd(hn::Mul(hn::LoadU(d, cell + i), r), r, sum);
  }
  return Total(sum);
}

void NormalEquations(const double* columns, std::size_t stride, std::size_t count, const double* cell, const double* f,
                     const double* g, std::size_t n, double* scratch, double* normal, std::size_t leading,
                     double* gradient) {
  const Doubles d;
  double* residual = scratch;
  double* scaled = scratch + n;
  for (std::size_t i = 0; i < n; i += hn::Lanes(d)) {
    hn::StoreU(hn::Sub(hn::LoadU(d, f + i), hn::LoadU(d, g + i)), d, residual + i);
  }
  for (std::size_t j = 0; j < count; ++j) {
    V slope = hn::Zero(d), diagonal = hn::Zero(d);
    for (std::size_t i = 0; i < n; i += hn::Lanes(d)) {
      const V column = hn::LoadU(d, columns + j * stride + i);
      const V s = hn::Mul(hn::LoadU(d, cell + i), column);
      hn::StoreU(s, d, scaled + i);
      slope = hn::MulAdd(s, hn::LoadU(d, residual + i), slope);
      diagonal = hn::MulAdd(s, column, diagonal);
    }
    gradient[j] = Total(slope);
    double* out = normal + j * leading;
    out[j] = Total(diagonal);
    std::size_t k = j + 1;
    for (; k + 4 <= count; k += 4) {  // four columns at once, so that the scaled one is read once for all of them
      const double* c = columns + k * stride;
      V s0 = hn::Zero(d), s1 = hn::Zero(d), s2 = hn::Zero(d), s3 = hn::Zero(d);
      for (std::size_t i = 0; i < n; i += hn::Lanes(d)) {
        const V s = hn::LoadU(d, scaled + i);
        s0 = hn::MulAdd(s, hn::LoadU(d, c + i), s0);
        s1 = hn::MulAdd(s, hn::LoadU(d, c + stride + i), s1);
        s2 = hn::MulAdd(s, hn::LoadU(d, c + 2 * stride + i), s2);
        s3 = hn::MulAdd(s, hn::LoadU(d, c + 3 * stride + i), s3);
      }
      out[k] = Total(s0);
      out[k + 1] = Total(s1);
      out[k + 2] = Total(s2);
      out[k + 3] = Total(s3);
    }
    for (; k < count; ++k) {
      V sum = hn::Zero(d);
      for (std::size_t i = 0; i < n; i += hn::Lanes(d)) {
        sum = hn::MulAdd(hn::LoadU(d, scaled + i), hn::LoadU(d, columns + k * stride + i), sum);
      }
      out[k] = Total(sum);
    }
  }
}

Projection Project(const Shape& shape, const double* azimuth, const double* cell, const double* f, const double* g,
                   std::size_t n) {
  const Doubles d;
  const V left = hn::Set(d, 1 / shape.left), right = hn::Set(d, 1 / shape.right);
  const V z = hn::Set(d, shape.inverse_z), mu = hn::Set(d, shape.mu);
  V explained = hn::Zero(d), power = hn::Zero(d);
  for (std::size_t i = 0; i < n; i += hn::Lanes(d)) {
    const V p = Density(Offset(azimuth + i, mu), left, right, z);
    const V weighted = hn::Mul(hn::LoadU(d, cell + i), p);
    explained = hn::MulAdd(weighted, hn::Sub(hn::LoadU(d, g + i), hn::LoadU(d, f + i)), explained);
    power = hn::MulAdd(weighted, p, power);
  }
  return {Total(explained), Total(power)};
}

// Works column by column, each in registers while all earlier ones are subtracted. Whole vectors are updated, which
// overwrites what is above the diagonal; that part is never used.
void SolveInPlace(double* matrix, std::size_t leading, std::size_t count, double* x) {
  const Doubles d;
  const std::size_t lanes = hn::Lanes(d);
  HWY_ALIGN double factors[most_solved], known[most_solved];
  for (std::size_t k = 0; k < count; ++k) {
    double* target = matrix + k * leading;
    double rest = x[k];
    for (std::size_t j = 0; j < k; ++j) {
      const double* column = matrix + j * leading;
      factors[j] = column[k] * column[j];  // the diagonal holds the inverse
      rest -= column[k] * known[j];
    }
    std::size_t i = k / lanes * lanes;
    for (; i + 3 * lanes < count + lanes; i += 3 * lanes) {
      V a = hn::LoadU(d, target + i), b = hn::LoadU(d, target + i + lanes), c = hn::LoadU(d, target + i + 2 * lanes);
      const double* column = matrix + i;
      for (std::size_t j = 0; j < k; ++j, column += leading) {
        const V factor = hn::Set(d, factors[j]);
        a = hn::NegMulAdd(factor, hn::LoadU(d, column), a);
        b = hn::NegMulAdd(factor, hn::LoadU(d, column + lanes), b);
        c = hn::NegMulAdd(factor, hn::LoadU(d, column + 2 * lanes), c);
      }
      hn::StoreU(a, d, target + i);
      hn::StoreU(b, d, target + i + lanes);
      hn::StoreU(c, d, target + i + 2 * lanes);
    }
    for (; i < count; i += lanes) {
      V a = hn::LoadU(d, target + i);
      const double* column = matrix + i;
      for (std::size_t j = 0; j < k; ++j, column += leading) {
        a = hn::NegMulAdd(hn::Set(d, factors[j]), hn::LoadU(d, column), a);
      }
      hn::StoreU(a, d, target + i);
    }
    x[k] = rest;
    const double inverse = target[k] > 0 ? 1 / target[k] : 0;
    known[k] = rest * inverse;
    target[k] = inverse;
  }
  for (std::size_t j = count; j-- > 0;) {
    const double* column = matrix + j * leading;
    std::size_t i = (j + 1) / lanes * lanes;
    const auto below = hn::Gt(hn::Iota(d, static_cast<double>(i)), hn::Set(d, static_cast<double>(j)));
    V sum = hn::Zero(d);
    if (i < count) sum = hn::IfThenElseZero(below, hn::Mul(hn::LoadU(d, column + i), hn::LoadU(d, x + i)));
    for (i += lanes; i < count; i += lanes) sum = hn::MulAdd(hn::LoadU(d, column + i), hn::LoadU(d, x + i), sum);
    x[j] = (x[j] - Total(sum)) * column[j];
  }
}

void BlurRow(const double* in, const double* kernel, std::size_t taps, double* out, std::size_t n) {
  const Doubles d;
  for (std::size_t i = 0; i < n; i += hn::Lanes(d)) {
    V sum = hn::Zero(d);
    for (std::size_t k = 0; k < taps; ++k) sum = hn::MulAdd(hn::Set(d, kernel[k]), hn::LoadU(d, in + i + k), sum);
    hn::StoreU(sum, d, out + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tress::inline v0_2::adaptive
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tress::inline v0_2::adaptive {

HWY_EXPORT(AddDensity);
HWY_EXPORT(AddDensityAndColumns);
HWY_EXPORT(SquaredError);
HWY_EXPORT(NormalEquations);
HWY_EXPORT(Project);
HWY_EXPORT(SolveInPlace);
HWY_EXPORT(BlurRow);

Shape::Shape(double mode, double scale_left, double scale_right) : mu(mode), left(scale_left), right(scale_right) {
  // T(s) = tanh(pi/2s) = (1 - e)/(1 + e), e = exp(-pi/s); 1 to the last bit below s = pi/40.
  const auto e_of = [](double s) { return s < pi / 40 ? 0 : std::exp(-pi / s); };
  const double e_left = e_of(left);
  const double e_right = right == left ? e_left : e_of(right);
  const double t_left = (1 - e_left) / (1 + e_left);
  const double t_right = (1 - e_right) / (1 + e_right);
  const double twice_z = left * t_left + right * t_right;
  inverse_z = 2 / twice_z;
  log_z_left = (left * t_left - (1 - t_left * t_left) * pi / 2) / twice_z;
  log_z_right = (right * t_right - (1 - t_right * t_right) * pi / 2) / twice_z;
}

void add_density(const Shape& shape, double weight, const double* azimuth, std::size_t n, double* f) {
  HWY_DYNAMIC_DISPATCH(AddDensity)(shape, weight, azimuth, n, f);
}

void add_density_and_columns(const Shape& shape, double weight, const double* azimuth, std::size_t n, double* f,
                             double* columns, std::size_t stride) {
  HWY_DYNAMIC_DISPATCH(AddDensityAndColumns)(shape, weight, azimuth, n, f, columns, stride);
}

double squared_error(const double* cell, const double* f, const double* g, std::size_t n) {
  return HWY_DYNAMIC_DISPATCH(SquaredError)(cell, f, g, n);
}

void normal_equations(const double* columns, std::size_t stride, std::size_t count, const double* cell, const double* f,
                      const double* g, std::size_t n, double* scratch, double* normal, std::size_t leading,
                      double* gradient) {
  HWY_DYNAMIC_DISPATCH(NormalEquations)
  (columns, stride, count, cell, f, g, n, scratch, normal, leading, gradient);
}

Projection project(const Shape& shape, const double* azimuth, const double* cell, const double* f, const double* g,
                   std::size_t n) {
  return HWY_DYNAMIC_DISPATCH(Project)(shape, azimuth, cell, f, g, n);
}

void solve_in_place(double* matrix, std::size_t leading, std::size_t count, double* x) {
  HWY_DYNAMIC_DISPATCH(SolveInPlace)(matrix, leading, count, x);
}

void blur_row(const double* in, const double* kernel, std::size_t taps, double* out, std::size_t n) {
  HWY_DYNAMIC_DISPATCH(BlurRow)(in, kernel, taps, out, n);
}

}  // namespace tress::inline v0_2::adaptive
#endif
