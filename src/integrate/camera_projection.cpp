#include "integrate/camera_projection.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace tress::integrate {
namespace {

constexpr double near_cm = 0.1;  ///< depth at which z of worldToNDC is 0; it is 1 at infinity

std::array<float, 16> as_floats(const std::array<double, 16>& matrix) {
  std::array<float, 16> floats;
  std::transform(matrix.begin(), matrix.end(), floats.begin(), [](double x) { return static_cast<float>(x); });
  return floats;
}

/// The matrix for points that are counted from 0, of one for points counted from an origin.
std::array<double, 16> from_zero(std::array<double, 16> matrix, const glm::dvec3& origin) {
  for (std::size_t column = 0; column < 4; ++column)
    for (std::size_t row = 0; row < 3; ++row)
      matrix[12 + column] -= origin[static_cast<int>(row)] * matrix[4 * row + column];
  return matrix;
}

}  // namespace

CameraAxes::CameraAxes(const scene::Camera& camera) : forward(glm::normalize(camera.look_at - camera.eye)) {
  right = glm::cross(forward, camera.up);
  if (glm::length(right) < 1e-6f * glm::length(camera.up)) {
    right = glm::cross(forward, std::abs(forward.y) < 0.5f ? glm::vec3(0, 1, 0) : glm::vec3(1, 0, 0));
  }
  right = glm::normalize(right);
  down = glm::cross(forward, right);
}

CameraProjection::CameraProjection(const scene::Camera& camera, const scene::Image& image)
    : eye_(camera.eye), width_(image.width), height_(image.height) {
  const CameraAxes axes(camera);
  right_ = axes.right;
  up_ = -axes.down;
  forward_ = axes.forward;
  orthographic_ = camera.orthographic_height_cm > 0;
  half_height_ = orthographic_ ? camera.orthographic_height_cm / 2.0
                               : std::tan(double{camera.vertical_fov_deg} * std::numbers::pi / 360);
  shift_x_ = camera.shift_x;
  shift_y_ = camera.shift_y;
  half_width_ = half_height_ * width_ / height_;
}

std::array<double, 16> CameraProjection::world_to_camera() const {
  const glm::dvec3 moved(-glm::dot(eye_, right_), -glm::dot(eye_, up_), -glm::dot(eye_, forward_));
  return {right_.x, up_.x,   forward_.x, 0,  //
          right_.y, up_.y,   forward_.y, 0,  //
          right_.z, up_.z,   forward_.z, 0,  //
          moved.x,  moved.y, moved.z,    1};
}

std::array<double, 16> CameraProjection::world_to_ndc() const {
  const std::array<double, 16> camera = world_to_camera();
  std::array<double, 16> ndc{};
  for (std::size_t row = 0; row < 16; row += 4) {
    const double x = camera[row], y = camera[row + 1], z = camera[row + 2], w = camera[row + 3];
    const double over = orthographic_ ? w : z;  // the divisor of the other components
    ndc[row] = 0.5 * (x / half_width_ + over) - shift_x_ * over;
    ndc[row + 1] = 0.5 * (over - y / half_height_) + shift_y_ * over;
    ndc[row + 2] = z - near_cm * w;
    ndc[row + 3] = over;
  }
  return ndc;
}

std::optional<glm::dvec2> CameraProjection::pixel(const glm::dvec3& world) const {
  const glm::dvec3 from_eye = world - eye_;
  const double depth = glm::dot(from_eye, forward_);
  if (!(depth > 0)) return std::nullopt;
  const double over = orthographic_ ? 1 : depth;
  return glm::dvec2(width_ * (0.5 + 0.5 * glm::dot(from_eye, right_) / (over * half_width_) - shift_x_),
                    height_ * (0.5 - 0.5 * glm::dot(from_eye, up_) / (over * half_height_) + shift_y_));
}

void describe_camera(const scene::Camera& camera, const scene::Image& image, image::Picture* picture,
                     const glm::dvec3& origin) {
  const CameraProjection projection(camera, image);
  picture->matrices["worldToCamera"] = as_floats(from_zero(projection.world_to_camera(), origin));
  picture->matrices["worldToNDC"] = as_floats(from_zero(projection.world_to_ndc(), origin));
  const glm::dvec2 half = projection.half_size();
  picture->screen_width = static_cast<float>(2 * half.x);
  picture->screen_center = {static_cast<float>(2 * half.x * double{camera.shift_x}),
                            static_cast<float>(2 * half.y * double{camera.shift_y})};
}

}  // namespace tress::integrate
