#include "scene/model/camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/ext/vector_double3.hpp>
#include <glm/geometric.hpp>
#include <numbers>

#include "scene/model/groom_bounds.h"
#include "scene/model/parameters.h"

namespace tress::scene {
namespace {

constexpr float elevation_rad = 0.14f;  ///< 8 degrees above the horizon
constexpr float margin = 1.06f;

/// The direction towards the camera.
glm::vec3 back_of(double turn_rad) {
  const float level = std::cos(elevation_rad);
  return {static_cast<float>(std::sin(turn_rad)) * level, -static_cast<float>(std::cos(turn_rad)) * level,
          std::sin(elevation_rad)};
}

/// Tangents of the half angles of view, including the margin.
struct View {
  float right, up;
  View(const Image& image, const Camera& camera)
      : up(std::tan(camera.vertical_fov_deg / 2 * std::numbers::pi_v<float> / 180) / margin) {
    right = up * static_cast<float>(image.width) / static_cast<float>(image.height);
  }
};

/// The largest `distance_of(point - middle)` of all points, along `back`.
template <class Distance>
Camera placed(const std::vector<Groom>& grooms, const Camera& camera, const glm::vec3& middle, const glm::vec3& back,
              Distance distance_of) {
  float distance = 0.1f;
  for (const auto& groom : grooms)
    for_each_seen_point(groom, [&](const glm::vec3& p) { distance = std::max(distance, distance_of(p - middle)); });
  Camera framed = camera;
  framed.look_at = middle;
  framed.eye = middle + distance * back;
  framed.up = glm::vec3(0, 0, 1);
  return framed;
}

Camera between(const Camera& a, const Camera& b, float t) {
  const auto mix = [t](const auto& x, const auto& y) { return x + t * (y - x); };
  Camera camera = a;
  camera.eye = mix(a.eye, b.eye);
  camera.look_at = mix(a.look_at, b.look_at);
  camera.up = mix(a.up, b.up);
  camera.vertical_fov_deg = mix(a.vertical_fov_deg, b.vertical_fov_deg);
  return camera;
}

/// The height of the part of the sensor that the picture uses.
double sensor_height_mm(const Lens& lens, const Image& image) {
  const double size = lens.sensor_mm, aspect = static_cast<double>(image.width) / image.height;
  const bool by_width = lens.sensor_fit == Lens::Fit::width || (lens.sensor_fit == Lens::Fit::longer && aspect >= 1);
  return by_width ? size / aspect : size;
}

/// Sets the angle of view from the focal length, or the focal length from the angle.
Camera with_angle(Camera camera, const Lens& lens, const Image& image) {
  constexpr double degrees = 180 / std::numbers::pi;
  const double half_mm = sensor_height_mm(lens, image) / 2;
  if (camera.focal_length_mm > 0)
    camera.vertical_fov_deg = static_cast<float>(2 * std::atan(half_mm / double{camera.focal_length_mm}) * degrees);
  return camera;
}

/// Sets radius and focus of the lens for a camera at its place. Sets *fault if the point in focus is not in front of
/// it.
Camera with_lens(Camera camera, const Lens& lens, const Image& image, std::optional<CameraFault>* fault) {
  const double half_angle_rad = double{camera.vertical_fov_deg} / 2 * std::numbers::pi / 180;
  camera.focal_length_mm = static_cast<float>(sensor_height_mm(lens, image) / 2 / std::tan(half_angle_rad));
  if (lens.f_number) camera.lens_radius_cm = camera.focal_length_mm / 10 / (2 * *lens.f_number);
  if (lens.radius_cm) camera.lens_radius_cm = *lens.radius_cm;
  if (!(camera.lens_radius_cm > 0)) return camera;
  const glm::vec3 forward = glm::normalize(camera.look_at - camera.eye);
  const glm::vec3 sharp = lens.focus_point.value_or(camera.look_at);
  camera.focus_cm = lens.focus_cm.value_or(glm::dot(sharp - camera.eye, forward));
  if (!(camera.focus_cm >= 1e-3f))
    *fault = {"depth_of_field/focus_point", "a point before the camera",
              fmt::format("one at {:g} cm along the view", camera.focus_cm)};
  return camera;
}

Camera at_keys(std::vector<CameraKey> keys, double frame, const Lens& lens, const Image& image) {
  for (CameraKey& key : keys) key.camera = with_angle(key.camera, lens, image);
  const auto next =
      std::find_if(keys.begin(), keys.end(), [frame](const CameraKey& key) { return key.frame >= frame; });
  if (next == keys.end()) return keys.back().camera;
  if (next == keys.begin() || next->frame == frame) return next->camera;
  const auto& before = *(next - 1);
  const double t = (frame - before.frame) / (static_cast<double>(next->frame) - before.frame);
  return between(before.camera, next->camera, static_cast<float>(t));
}

/// The turn, counter-clockwise from above, in [0, 2 pi).
double turn_at(const Turntable& turntable, double frame) {
  double step = std::fmod(frame, turntable.frames);
  if (step < 0) step += turntable.frames;
  return 2 * std::numbers::pi * step / turntable.frames;
}

Camera on_turntable(const Turntable& turntable, double frame, const std::vector<Groom>& grooms, const Image& image,
                    const Camera& still) {
  Camera camera = frame_grooms_all_round(grooms, image, still, turntable.look_at);
  const glm::vec3 middle = turntable.look_at.value_or(camera.look_at);
  float distance = std::hypot(camera.eye.x - middle.x, camera.eye.y - middle.y), height = camera.eye.z - middle.z;
  if (turntable.distance_cm) distance = *turntable.distance_cm, height = turntable.height_cm;
  const double turn = turntable.turns_camera ? turn_at(turntable, frame) : 0;
  camera.look_at = middle;
  camera.eye = middle + glm::vec3(distance * static_cast<float>(std::sin(turn)),
                                  -distance * static_cast<float>(std::cos(turn)), height);
  camera.up = glm::vec3(0, 0, 1);
  return camera;
}

}  // namespace

Camera camera_during(const std::vector<Camera>& moments, float time) {
  const BetweenMoments at(time, moments.size());
  const Camera &a = moments[at.before], &b = moments[at.before + 1];
  const float t = at.share;
  Camera camera = between(a, b, t);
  camera.lens_radius_cm = a.lens_radius_cm + t * (b.lens_radius_cm - a.lens_radius_cm);
  camera.focus_cm = a.focus_cm + t * (b.focus_cm - a.focus_cm);
  return camera;
}

std::optional<glm::vec3> middle_of(const std::vector<Groom>& grooms) {
  std::optional<Box> all;
  for (const auto& groom : grooms) {
    for_each_seen_point(groom, [&](const glm::vec3& point) {
      if (!all) all = Box{point, point};
      all->include(point);
    });
  }
  if (!all) return std::nullopt;
  return 0.5f * (all->low + all->high);
}

Camera frame_grooms(const std::vector<Groom>& grooms, const Image& image, const Camera& camera, double turn_rad) {
  const auto middle = middle_of(grooms);
  if (!middle) return camera;
  const View view(image, camera);
  const glm::vec3 back = back_of(turn_rad);
  const glm::vec3 right(static_cast<float>(std::cos(turn_rad)), static_cast<float>(std::sin(turn_rad)), 0);
  const glm::vec3 up = glm::cross(back, right);
  return placed(grooms, camera, *middle, back, [&](const glm::vec3& d) {
    return glm::dot(d, back) + std::max(std::abs(glm::dot(d, right)) / view.right, std::abs(glm::dot(d, up)) / view.up);
  });
}

Camera frame_grooms_all_round(const std::vector<Groom>& grooms, const Image& image, const Camera& camera,
                              const std::optional<glm::vec3>& look_at) {
  const auto middle = middle_of(grooms);
  if (!middle) return camera;
  const View view(image, camera);
  const float c = std::cos(elevation_rad), s = std::sin(elevation_rad);
  // A point at height z moves on a circle of radius r. The largest value over its azimuth t has a closed form: back . d
  // = c r cos t + s z, right . d = r sin t, up . d = -s r cos t + c z.
  return placed(grooms, camera, look_at.value_or(*middle), back_of(0), [&](const glm::vec3& d) {
    const float r = std::hypot(d.x, d.y), z = d.z;
    const float aside = r * std::hypot(c, 1 / view.right) + s * z;
    const float above = r * std::abs(c - s / view.up) + z * (s + c / view.up);
    const float below = r * std::abs(c + s / view.up) + z * (s - c / view.up);
    return std::max({aside, above, below});
  });
}

std::optional<CameraFault> fault_of(const Camera& camera) {
  const Range& angles = parameter_at("/camera/vertical_fov_deg")->range;
  if (!angles.contains(double{camera.vertical_fov_deg}))
    return CameraFault{
        "focal_length_mm",
        fmt::format("one that gives a vertical angle of view of {:g} to {:g} degrees", angles.least, angles.most),
        fmt::format("{:g} degrees", camera.vertical_fov_deg)};
  const auto forward = camera.look_at - camera.eye;
  if (!(glm::length(forward) > 1e-5f)) return CameraFault{"look_at", "a point other than eye", "the same point"};
  const auto up_length = glm::length(camera.up);
  if (!(up_length > 1e-6f && glm::length(glm::cross(glm::normalize(forward), camera.up / up_length)) > 1e-4f))
    return CameraFault{"up", "a direction across the view", "one along it, or of no length"};
  return std::nullopt;
}

ObjectTurn object_turn_at(const CameraDescription& description, std::optional<double> frame,
                          const std::vector<Groom>& grooms) {
  if (!description.turntable || description.turntable->turns_camera) return {};
  const glm::vec3 middle = middle_of(grooms).value_or(glm::vec3(0.0f));
  return {-turn_at(*description.turntable, frame.value_or(0)), description.turntable->look_at.value_or(middle)};
}

glm::dvec3 ObjectTurn::of(const glm::dvec3& point) const {
  if (turn_rad == 0) return point;
  const double c = std::cos(turn_rad), s = std::sin(turn_rad), x = point.x - double{pivot.x},
               y = point.y - double{pivot.y};
  return {c * x - s * y + double{pivot.x}, s * x + c * y + double{pivot.y}, point.z};
}

namespace {

void turn_instance(std::span<const ObjectTurn> turns, bool differ, Instance* instance) {
  const auto turn = [](const ObjectTurn& by, Similarity& place) {
    if (by.turn_rad == 0) return;
    place.offset = glm::vec3(by.of(place.offset));
    const ObjectTurn of_directions{by.turn_rad, glm::vec3(0.0f)};
    for (int column = 0; column < 3; ++column) place.turn[column] = glm::vec3(of_directions.of(place.turn[column]));
  };
  if (differ && instance->later.empty()) instance->later.assign(turns.size() - 1, instance->first);
  for (std::size_t i = 0; i < instance->later.size(); ++i)
    turn(turns[std::min(i + 1, turns.size() - 1)], instance->later[i]);
  turn(turns.front(), instance->first);
}

}  // namespace

void turn_objects(std::span<const ObjectTurn> turns, std::vector<Groom>* grooms, std::vector<Mesh>* meshes) {
  const ObjectTurn& first = turns.front();
  const bool differ =
      std::ranges::any_of(turns, [&](const ObjectTurn& turn) { return turn.turn_rad != first.turn_rad; });
  const auto turn_points = [](const ObjectTurn& turn, std::vector<glm::vec3>& points) {
    if (turn.turn_rad == 0) return;
    for (glm::vec3& point : points) point = glm::vec3(turn.of(point));
  };
  const auto of_directions = [](const ObjectTurn& turn) { return ObjectTurn{turn.turn_rad, glm::vec3(0.0f)}; };
  const auto at = [&](std::size_t later) { return turns[std::min(later + 1, turns.size() - 1)]; };
  for (Groom& groom : *grooms) {
    if (!groom.instances.empty()) {
      for (Instance& instance : groom.instances) turn_instance(turns, differ, &instance);
      continue;
    }
    if (differ && groom.later.empty()) groom.later.assign(turns.size() - 1, {groom.points});
    for (std::size_t i = 0; i < groom.later.size(); ++i) {
      StrandMoment& moment = groom.later[i];
      turn_points(at(i), moment.points);
      const ObjectTurn since{at(i).turn_rad - first.turn_rad, glm::vec3(0.0f)};
      for (int column = 0; column < 3; ++column) moment.turned[column] = since.of(moment.turned[column]);
    }
    groom.turned_rad += first.turn_rad;
    turn_points(first, groom.points);
    turn_points(of_directions(first), groom.minor_axis);
  }
  for (Mesh& mesh : *meshes) {
    if (differ && mesh.later.empty()) mesh.later.assign(turns.size() - 1, {mesh.positions, mesh.normals});
    for (std::size_t i = 0; i < mesh.later.size(); ++i) {
      turn_points(at(i), mesh.later[i].positions);
      turn_points(of_directions(at(i)), mesh.later[i].normals);
    }
    turn_points(first, mesh.positions);
    turn_points(of_directions(first), mesh.normals);
  }
}

Result<Camera> camera_at(const CameraDescription& description, std::optional<double> frame,
                         const std::vector<Groom>& grooms, const Image& image, const std::string& name) {
  const Camera still = with_angle(description.camera, description.lens, image);
  Camera camera = still;
  double at = frame.value_or(0);
  if (description.framed) {
    camera = frame_grooms(grooms, image, still, description.turn_rad);
  } else if (description.turntable) {
    camera = on_turntable(*description.turntable, at, grooms, image, still);
  } else if (!description.keys.empty()) {
    at = frame.value_or(description.keys.front().frame);
    camera = at_keys(description.keys, at, description.lens, image);
  }
  std::optional<CameraFault> fault = fault_of(camera);
  if (!fault) camera = with_lens(camera, description.lens, image, &fault);
  if (fault)
    return Error{name, fmt::format("/camera at frame {:.10g}: {}", at, fault->key), fault->expected, fault->found};
  return camera;
}

float pixel_cm_at(const Camera& camera, const Image& image, const glm::vec3& point) {
  const auto height = static_cast<float>(image.height);
  if (camera.orthographic_height_cm > 0) return camera.orthographic_height_cm / height;
  const float depth = glm::dot(point - camera.eye, glm::normalize(camera.look_at - camera.eye));
  return 2 * std::tan(camera.vertical_fov_deg * std::numbers::pi_v<float> / 360) * std::max(depth, 0.0f) / height;
}

}  // namespace tress::scene
