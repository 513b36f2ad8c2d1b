#include <cmath>

#include "tress/adaptive/mixture.h"

namespace tress::adaptive {

double decayed_share(double rate, double attribute_mean, double attribute_variance) {
  if (rate <= 0 || attribute_mean <= 0) return 1;
  const double spread = attribute_variance / attribute_mean;
  if (!(rate * spread > 1e-6)) return std::exp(-rate * attribute_mean);
  return std::exp(-attribute_mean / spread * std::log1p(rate * spread));
}

}  // namespace tress::adaptive
