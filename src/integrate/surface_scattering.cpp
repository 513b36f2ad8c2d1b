#include "integrate/surface_scattering.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>

#include "base/pi.h"

namespace tress::integrate {
namespace {

constexpr float least_width = 1e-3f;

/// Reflectance of a dielectric for unpolarized light from outside. cosine: in [0, 1].
float fresnel(float cosine, float eta) {
  const float inside = std::sqrt(std::max(0.0f, 1 - (1 - cosine * cosine) / (eta * eta)));
  const float across = (cosine - eta * inside) / (cosine + eta * inside);
  const float along = (eta * cosine - inside) / (eta * cosine + inside);
  return 0.5f * (across * across + along * along);
}

float largest(const glm::vec3& color) { return std::max({color.x, color.y, color.z}); }

}  // namespace

Coat::Coat(float roughness, float eta) : width_(std::max(roughness * roughness, least_width)), eta_(eta) {
  // The mean of F G2 / G1 over the visible normals, with the same stratified numbers at every cosine.
  constexpr int strata = 48;
  for (int i = 0; i <= cells; ++i) {
    const float root = static_cast<float>(i) / cells, cosine = std::max(root * root, 1e-4f);
    const glm::vec3 out(std::sqrt(1 - cosine * cosine), 0, cosine);
    double sum = 0;
    for (int a = 0; a < strata; ++a)
      for (int b = 0; b < strata; ++b) {
        const glm::vec3 in =
            sample(out, {(static_cast<float>(a) + 0.5f) / strata, (static_cast<float>(b) + 0.5f) / strata});
        if (!(in.z > 0)) continue;
        const float density = pdf(out, in);
        if (density > 0) sum += static_cast<double>(value(out, in) / density);
      }
    albedo_[static_cast<std::size_t>(i)] = std::min(1.0f, static_cast<float>(sum / (strata * strata)));
  }
  constexpr int steps = 2048;
  double mean = 0;
  for (int i = 0; i < steps; ++i) {
    const float cosine = (static_cast<float>(i) + 0.5f) / steps;
    mean += 2 * static_cast<double>(cosine * albedo(cosine)) / steps;
  }
  mean_albedo_ = static_cast<float>(mean);
}

float Coat::albedo(float cosine) const {
  const float place = std::sqrt(std::clamp(cosine, 0.0f, 1.0f)) * cells;
  const auto cell = std::min(static_cast<std::size_t>(place), std::size_t{cells} - 1);
  return albedo_[cell] + (place - static_cast<float>(cell)) * (albedo_[cell + 1] - albedo_[cell]);
}

/// Smith's Lambda.
float Coat::masking(const glm::vec3& direction) const {
  const float squared = direction.z * direction.z;
  const float tangent = std::max(0.0f, 1 - squared) / std::max(squared, 1e-12f);
  return 0.5f * (std::sqrt(1 + width_ * width_ * tangent) - 1);
}

float Coat::distribution(const glm::vec3& normal) const {
  const float x = normal.x / width_, y = normal.y / width_, z = normal.z;
  const float sum = x * x + y * y + z * z;
  return 1 / (pi_f * width_ * width_ * sum * sum);
}

float Coat::value(const glm::vec3& out, const glm::vec3& in) const {
  if (!(out.z > 0 && in.z > 0)) return 0;
  const glm::vec3 half = glm::normalize(out + in);
  const float both = 1 / (1 + masking(out) + masking(in));
  return fresnel(std::clamp(glm::dot(out, half), 0.0f, 1.0f), eta_) * distribution(half) * both / (4 * out.z);
}

float Coat::pdf(const glm::vec3& out, const glm::vec3& in) const {
  const glm::vec3 sum = out + in;
  const float length = glm::length(sum);
  if (!(out.z > 0 && length > 1e-6f)) return 0;
  const glm::vec3 half = sum / length;
  if (!(half.z > 0)) return 0;
  return distribution(half) / (4 * out.z * (1 + masking(out)));
}

glm::vec3 Coat::sample(const glm::vec3& out, const glm::vec2& u) const {
  // Stretches the facets to a width of 1, where they are a hemisphere, and draws a visible point of it.
  const glm::vec3 seen = glm::normalize(glm::vec3(width_ * out.x, width_ * out.y, out.z));
  const float across = std::hypot(seen.x, seen.y);
  const glm::vec3 first = across > 1e-6f ? glm::vec3(-seen.y, seen.x, 0) / across : glm::vec3(1, 0, 0);
  const glm::vec3 second = glm::cross(seen, first);
  const float radius = std::sqrt(u.x), azimuth = 2 * pi_f * u.y, a = radius * std::cos(azimuth);
  const float raised = 0.5f * (1 + seen.z);
  const float b = (1 - raised) * std::sqrt(std::max(0.0f, 1 - a * a)) + raised * radius * std::sin(azimuth);
  const glm::vec3 point = a * first + b * second + std::sqrt(std::max(0.0f, 1 - a * a - b * b)) * seen;
  const glm::vec3 half = glm::normalize(glm::vec3(width_ * point.x, width_ * point.y, std::max(1e-6f, point.z)));
  return glm::normalize(2 * glm::dot(out, half) * half - out);
}

SurfaceMaterial::SurfaceMaterial(const glm::vec3& diffuse_albedo, const Coat* over, const glm::vec3& towards)
    : diffuse(diffuse_albedo),
      coat(over),
      out(towards),
      coat_albedo(over != nullptr ? over->albedo(towards.z) : 0.0f) {}

glm::vec3 SurfaceMaterial::albedo() const { return coat_albedo + (1 - coat_albedo) * diffuse; }

glm::vec3 SurfaceMaterial::value(const glm::vec3& in) const {
  if (!(in.z > 0)) return glm::vec3(0.0f);
  const glm::vec3 lambert = diffuse * (in.z / pi_f);
  if (coat == nullptr) return lambert;
  const float reaches = (1 - coat_albedo) * (1 - coat->albedo(in.z)) / (1 - coat->mean_albedo());
  return lambert * reaches + coat->value(out, in);
}

/// The share is in proportion to the light that the coat and the diffuse part reflect, within [0.1, 0.9].
float SurfaceMaterial::coat_share() const {
  if (coat == nullptr) return 0;
  const float below = (1 - coat_albedo) * largest(diffuse);
  return std::clamp(coat_albedo / std::max(coat_albedo + below, 1e-6f), 0.1f, 0.9f);
}

glm::vec3 SurfaceMaterial::sample(const std::array<float, 4>& u) const {
  if (u[2] < coat_share()) return coat->sample(out, {u[0], u[1]});
  const float sine = std::sqrt(u[0]), cosine = std::sqrt(std::max(0.0f, 1 - u[0])), azimuth = 2 * pi_f * u[1];
  return {sine * std::cos(azimuth), sine * std::sin(azimuth), cosine};
}

float SurfaceMaterial::pdf(const glm::vec3& in) const {
  const float lambert = std::max(0.0f, in.z) / pi_f;
  const float share = coat_share();
  return share > 0 ? share * coat->pdf(out, in) + (1 - share) * lambert : lambert;
}

}  // namespace tress::integrate
