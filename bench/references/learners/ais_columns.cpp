#include "references/learners/ais_columns.h"

#include <cmath>
#include <numbers>

#include "fit/kernels.h"

// Compiled once for every instruction set by foreach_target; the machine chooses on the first call.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "references/learners/ais_columns.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "base/exp_lanes.h"

HWY_BEFORE_NAMESPACE();
namespace tress::inline v0_2::adaptive {
namespace HWY_NAMESPACE {

using namespace tress::HWY_NAMESPACE;

// With y = |x|/s, t = tanh(y/2) = -d ln p/dy, dt/dy = (1 - t^2)/2, and the sign that x has: d ln p is (sign t/s, t y);
// its own derivatives are -(1 - t^2)/2s^2, -sign (t + y dt/dy)/s, -y (t + y dt/dy); p'' = p (d d ln p + (d ln p)^2).
void AisColumns(const AisShape& shape, bool circular, const double* azimuth, std::size_t n, double* p, double* first,
                double* second, std::size_t stride) {
  const Doubles d;
  const V left = hn::Set(d, 1 / shape.left), right = hn::Set(d, 1 / shape.right), mu = hn::Set(d, shape.mu);
  const V one = hn::Set(d, 1.0), zero = hn::Zero(d), half = hn::Set(d, 0.5);
  const V pi = hn::Set(d, std::numbers::pi), two_pi = hn::Set(d, circular ? 2 * std::numbers::pi : 0.0);
  for (std::size_t i = 0; i < n; i += hn::Lanes(d)) {
    V x = hn::Sub(hn::LoadU(d, azimuth + i), mu);
    x = hn::IfThenElse(hn::Ge(x, pi), hn::Sub(x, two_pi), x);
    x = hn::IfThenElse(hn::Lt(x, hn::Neg(pi)), hn::Add(x, two_pi), x);
    const auto on_left = hn::Lt(x, zero);
    const V inverse_s = hn::IfThenElse(on_left, left, right);
    const V y = hn::Mul(hn::Abs(x), inverse_s);
    const V e = Exp(hn::Neg(y));
    const V inverse = hn::Div(one, hn::Add(one, e));
    const V t = hn::Mul(hn::Sub(one, e), inverse);
    const V value = hn::Mul(hn::Mul(e, inverse), inverse);
    const V bend = hn::Mul(half, hn::NegMulAdd(t, t, one));
    const V mixed = hn::MulAdd(y, bend, t);
    const V by_mu = hn::Mul(hn::IfThenElse(on_left, hn::Neg(t), t), inverse_s);
    const V by_scale = hn::Mul(t, y);
    const V sign_over_s = hn::IfThenElse(on_left, hn::Neg(inverse_s), inverse_s);
    const V mu_mu = hn::Mul(value, hn::NegMulAdd(bend, hn::Mul(inverse_s, inverse_s), hn::Mul(by_mu, by_mu)));
    const V mu_scale = hn::Mul(value, hn::NegMulAdd(sign_over_s, mixed, hn::Mul(by_mu, by_scale)));
    const V scale_scale = hn::Mul(value, hn::NegMulAdd(y, mixed, hn::Mul(by_scale, by_scale)));
    const V slope = hn::Mul(value, by_scale);
    hn::StoreU(value, d, p + i);
    hn::StoreU(hn::Mul(value, by_mu), d, first + i);
    hn::StoreU(hn::IfThenElseZero(on_left, slope), d, first + stride + i);
    hn::StoreU(hn::IfThenZeroElse(on_left, slope), d, first + 2 * stride + i);
    hn::StoreU(mu_mu, d, second + i);
    hn::StoreU(hn::IfThenElseZero(on_left, mu_scale), d, second + stride + i);
    hn::StoreU(hn::IfThenZeroElse(on_left, mu_scale), d, second + 2 * stride + i);
    hn::StoreU(hn::IfThenElseZero(on_left, scale_scale), d, second + 3 * stride + i);
    hn::StoreU(hn::IfThenZeroElse(on_left, scale_scale), d, second + 4 * stride + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tress::inline v0_2::adaptive
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tress::inline v0_2::adaptive {
namespace {

constexpr double pi = std::numbers::pi;

double side_mass(double scale, double reach) { return 0.5 * scale * std::tanh(0.5 * reach / scale); }

}  // namespace

HWY_EXPORT(AisColumns);

double AisShape::left_mass(AisBasis basis) const { return side_mass(left, basis == AisBasis::line ? mu + pi : pi); }

double AisShape::right_mass(AisBasis basis) const { return side_mass(right, basis == AisBasis::line ? pi - mu : pi); }

void ais_columns(const AisShape& shape, AisBasis basis, const double* azimuth, std::size_t n, double* p, double* first,
                 double* second, std::size_t stride) {
  HWY_DYNAMIC_DISPATCH(AisColumns)
  (shape, basis == AisBasis::circular, azimuth, n, p, first, second, stride);
}

}  // namespace tress::inline v0_2::adaptive
#endif
