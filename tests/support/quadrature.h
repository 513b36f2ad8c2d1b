// Composite Gauss-Legendre quadrature for tests.
#pragma once

namespace tress::test {

/// Integral of f over [a, b]: `panels` equal panels of 8-point Gauss-Legendre (exact for degree 15 in each).
template <class Function>
double integrate(Function&& f, double a, double b, int panels = 64) {
  constexpr double node[4] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
  constexpr double weight[4] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
  const double half = 0.5 * (b - a) / panels;
  double sum = 0;
  for (int i = 0; i < panels; ++i) {
    const double centre = a + (2 * i + 1) * half;
    for (int k = 0; k < 4; ++k) {
      sum += weight[k] *
             (static_cast<double>(f(centre - half * node[k])) + static_cast<double>(f(centre + half * node[k])));
    }
  }
  return sum * half;
}

/// The same over the rectangle [a, b] x [c, d].
template <class Function>
double integrate_2d(Function&& f, double a, double b, double c, double d, int panels_x = 32, int panels_y = 32) {
  return integrate([&](double x) { return integrate([&](double y) { return f(x, y); }, c, d, panels_y); }, a, b,
                   panels_x);
}

}  // namespace tress::test
