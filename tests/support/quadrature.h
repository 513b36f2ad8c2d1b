// Composite Gauss-Legendre quadrature for tests.
#pragma once

namespace tress::test {

/// Calls visit(x, weight) at the points of `panels` equal panels of 8-point Gauss-Legendre (exact for degree 15 in
/// each) over [a, b]: for several integrals over one evaluation each.
template <class Visit>
void visit_points(Visit&& visit, double a, double b, int panels = 64) {
  constexpr double node[4] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
  constexpr double weight[4] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
  const double half = 0.5 * (b - a) / panels;
  for (int i = 0; i < panels; ++i) {
    const double centre = a + (2 * i + 1) * half;
    for (int k = 0; k < 4; ++k) {
      visit(centre - half * node[k], half * weight[k]);
      visit(centre + half * node[k], half * weight[k]);
    }
  }
}

/// Integral of f over [a, b] by that rule.
template <class Function>
double integrate(Function&& f, double a, double b, int panels = 64) {
  double sum = 0;
  visit_points([&](double x, double weight) { sum += weight * static_cast<double>(f(x)); }, a, b, panels);
  return sum;
}

/// The same over the rectangle [a, b] x [c, d].
template <class Function>
double integrate_2d(Function&& f, double a, double b, double c, double d, int panels_x = 32, int panels_y = 32) {
  return integrate([&](double x) { return integrate([&](double y) { return f(x, y); }, c, d, panels_y); }, a, b,
                   panels_x);
}

}  // namespace tress::test
