#include "references/far_field.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/pi.h"
#include "tress/base/random.h"

namespace tress::references {
namespace {

using fiber::FiberDirection;
using fiber::FiberEvent;
using fiber::FiberModel;

constexpr std::size_t channels = 3, lobes = whole_flux;
constexpr std::uint64_t batch_paths = 1 << 15;
constexpr std::size_t batches_at_once = 16;
enum Stream : std::uint64_t { shift_stream = 1, path_stream, probe_stream };

/// By part without the whole, and channel.
using Weights = std::array<std::array<double, channels>, lobes>;

void add(Weights& weights, const fiber::FiberValue& value, double scale) {
  for (std::size_t lobe = 0; lobe < fiber::lobe_count; ++lobe) {
    for (std::size_t c = 0; c < channels; ++c) {
      weights[flux_part(lobe)][c] += scale * static_cast<double>(value.s[lobe][static_cast<int>(c)]);
    }
  }
}

/// Values of one part, the last being the whole, in one channel.
double of_part(const Weights& weights, std::size_t part, std::size_t channel) {
  if (part < lobes) return weights[part][channel];
  double sum = 0;
  for (const auto& lobe : weights) sum += lobe[channel];
  return sum;
}

/// Sums and variances of sums, which become standard errors at the end.
class Sums {
 public:
  explicit Sums(std::size_t bins) {
    for (PartialFlux& part : field.parts) {
      part.flux.fill(std::vector<double>(bins));
      part.standard_error.fill(std::vector<double>(bins));
    }
  }
  void add(std::size_t part, std::size_t channel, std::size_t bin, double flux, double variance) {
    field.parts[part].flux[channel][bin] += flux;
    field.parts[part].standard_error[channel][bin] += variance;
  }
  void finish() {
    for (PartialFlux& part : field.parts) {
      for (std::size_t c = 0; c < channels; ++c) {
        for (double& error : part.standard_error[c]) error = std::sqrt(std::max(error, 0.0));
        part.energy_error[c] = std::sqrt(std::max(part.energy_error[c], 0.0));
        for (const double flux : part.flux[c]) part.energy[c] += flux;
      }
    }
  }
  FarField field;  ///< standard errors hold variances until finish()
};

/// Points of a five-dimensional additive recurrence (the generalised golden ratio: 1/x, 1/x^2, ... with x^6 = x + 1).
class Recurrence {
 public:
  explicit Recurrence(RandomStream shift) {
    double step = 1;
    for (std::size_t d = 0; d < point_.size(); ++d) {
      step_[d] = step /= 1.1347241384015194;
      point_[d] = static_cast<double>(shift.next());
    }
  }
  const std::array<double, 5>& next() {
    for (std::size_t d = 0; d < point_.size(); ++d) {
      point_[d] += step_[d];
      point_[d] -= std::floor(point_[d]);
    }
    return point_;
  }

 private:
  std::array<double, 5> step_{}, point_{};
};

float below_one(double x) { return std::min(static_cast<float>(x), 0x1.fffffep-1f); }

struct Measure {
  const FiberModel& model;
  fiber::FiberId fiber;
  const FarFieldRequest& request;

  FiberEvent begin(double xi1, double xi2, double h) const {
    return model.begin(fiber, request.wr, below_one(xi1), below_one(xi2), static_cast<float>(h));
  }
  std::size_t bins() const { return request.theta_bins * request.phi_bins; }

  std::size_t bin_of(const FiberDirection& wi) const {
    const auto index = [](double turn, std::size_t count) {
      return static_cast<std::size_t>(std::clamp(turn * double(count), 0.0, double(count) - 1));
    };
    return index(double(wi.theta) / pi + 0.5, request.theta_bins) * request.phi_bins +
           index(0.5 * (double(wi.phi) / pi + 1), request.phi_bins);
  }

  /// One bin by one shift.
  Weights evaluate(std::size_t theta, std::size_t phi, std::size_t shift, std::uint64_t points) const {
    const double step_theta = pi / double(request.theta_bins), step_phi = 2 * pi / double(request.phi_bins);
    Recurrence recurrence(RandomStream(request.seed, shift_stream << 40 ^ (theta * request.phi_bins + phi), shift));
    Weights weights{};
    for (std::uint64_t i = 0; i < points; ++i) {
      const std::array<double, 5>& x = recurrence.next();
      const FiberEvent event = begin(x[2], x[3], 2 * x[4] - 1);
      if (!model.evaluates(event)) continue;
      const FiberDirection wi{static_cast<float>(-pi / 2 + (double(theta) + x[0]) * step_theta),
                              static_cast<float>(-pi + (double(phi) + x[1]) * step_phi)};
      add(weights, model.evaluate(event, wi), step_theta * step_phi / double(points));
    }
    return weights;
  }

  void evaluate_all(Sums& sums) const {
    const std::uint64_t cells = bins() * request.shifts, points = (request.paths + cells - 1) / cells;
    const double shifts = double(request.shifts);
    tbb::parallel_for(std::size_t{0}, bins(), [&](std::size_t bin) {
      std::vector<Weights> by_shift(request.shifts);
      for (std::size_t s = 0; s < request.shifts; ++s) {
        by_shift[s] = evaluate(bin / request.phi_bins, bin % request.phi_bins, s, points);
      }
      for (std::size_t part = 0; part < flux_parts; ++part) {
        for (std::size_t c = 0; c < channels; ++c) {
          double mean = 0, squares = 0;
          for (const Weights& weights : by_shift) mean += of_part(weights, part, c) / shifts;
          for (const Weights& weights : by_shift) squares += std::pow(of_part(weights, part, c) - mean, 2);
          sums.add(part, c, bin, mean, squares / (shifts * (shifts - 1)));
        }
      }
    });
    for (PartialFlux& part : sums.field.parts) {
      for (std::size_t c = 0; c < channels; ++c) {
        for (const double variance : part.standard_error[c]) part.energy_error[c] += variance;
      }
    }
    sums.field.evaluations = cells * points;
  }

  /// Whether some events can only be sampled. By 4096 of them.
  bool needs_paths() const {
    if (!model.evaluates()) return true;
    RandomStream random(request.seed, probe_stream);
    for (int i = 0; i < 4096; ++i) {
      const double xi1 = double(random.next()), xi2 = double(random.next());
      if (!model.evaluates(begin(xi1, xi2, 2 * double(random.next()) - 1))) return true;
    }
    return false;
  }

  struct Path {
    std::size_t bin;
    Weights weights;
  };

  /// The paths [first, first + batch_paths) that leave with a weight. h is stratified within a batch.
  std::vector<Path> trace(std::uint64_t first) const {
    const std::uint64_t count = std::min(batch_paths, request.paths - first);
    RandomStream random(request.seed, path_stream, first);
    std::vector<Path> paths;
    for (std::uint64_t i = 0; i < count; ++i) {
      const double h = 2 * (double(i) + double(random.next())) / double(count) - 1;
      const double xi1 = double(random.next()), xi2 = double(random.next());
      const std::array<float, 4> u{random.next(), random.next(), random.next(), random.next()};
      const FiberEvent event = begin(xi1, xi2, h);
      if (model.evaluates() && model.evaluates(event)) continue;
      const fiber::FiberSample sample = model.sample(event, u);
      if (!(sample.value.pdf > 0) || sample.value.total() == glm::vec3(0.0f)) continue;
      Path& path = paths.emplace_back(bin_of(sample.wi), Weights{});
      add(path.weights, sample.value, 1 / double(sample.value.pdf));
    }
    return paths;
  }

  void trace_all(Sums& sums) const {
    Sums traced(bins());
    const double n = double(request.paths);
    for (std::uint64_t first = 0; first < request.paths; first += batches_at_once * batch_paths) {
      const std::uint64_t left = (request.paths - first + batch_paths - 1) / batch_paths;
      std::vector<std::vector<Path>> batches(std::min<std::uint64_t>(left, batches_at_once));
      tbb::parallel_for(std::size_t{0}, batches.size(),
                        [&](std::size_t b) { batches[b] = trace(first + b * batch_paths); });
      for (const std::vector<Path>& batch : batches) {
        for (const Path& path : batch) {
          for (std::size_t part = 0; part < flux_parts; ++part) {
            for (std::size_t c = 0; c < channels; ++c) {
              const double weight = of_part(path.weights, part, c);
              if (weight != 0) traced.add(part, c, path.bin, weight / n, weight * weight / n);
            }
          }
        }
      }
    }
    for (std::size_t part = 0; part < flux_parts; ++part) {
      for (std::size_t c = 0; c < channels; ++c) {
        double mean = 0, square = 0;
        for (std::size_t bin = 0; bin < bins(); ++bin) {
          const double m = traced.field.parts[part].flux[c][bin], s = traced.field.parts[part].standard_error[c][bin];
          mean += m;
          square += s;
          sums.add(part, c, bin, m, (s - m * m) / n);
        }
        sums.field.parts[part].energy_error[c] += (square - mean * mean) / n;
      }
    }
    sums.field.paths = request.paths;
  }
};

}  // namespace

std::size_t flux_part(std::size_t lobe) {
  if (lobe == static_cast<std::size_t>(fiber::Lobe::glint)) return static_cast<std::size_t>(fiber::Lobe::trt);
  return std::min<std::size_t>(lobe, lobes - 1);
}

FarField far_field(const FiberModel& model, fiber::FiberId fiber, const FarFieldRequest& request) {
  const Measure measure{model, fiber, request};
  Sums sums(measure.bins());
  if (model.evaluates()) measure.evaluate_all(sums);
  if (measure.needs_paths()) measure.trace_all(sums);
  sums.finish();
  return std::move(sums.field);
}

}  // namespace tress::references
