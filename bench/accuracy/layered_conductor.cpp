// A surface that is learned from random walks by tress::adaptive alone: a rough dielectric coat over a rough metal,
// GGX. A sphere of it under a sky and a lamp, by the walks themselves and by rows that are learned from them while the
// picture is rendered, at equal CPU time.
//
//   bench_layered_conductor [--size N] [--samples N] [--truth N] [--seed N] [--picture FILE.png]
//
// Both weight the lamp's samples against drawn directions. Walks have no density, so theirs is that of lobes that look
// like the surface (any positive function is unbiased); rows have their own.
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <glm/glm.hpp>
#include <memory>
#include <new>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "image/picture.h"
#include "tress/adaptive/query.h"
#include "tress/adaptive/service.h"
#include "tress/base/random.h"

namespace {

using namespace tress;
using glm::dot;
using glm::normalize;
using Vec = glm::vec3;  ///< a direction; z is the normal of the surface
constexpr float pi = std::numbers::pi_v<float>;

/// The orders of light: it met the metal not at all, once, twice, more often. They are the parts of a row. A color of
/// the metal is a power of its reflectance for each, so one row serves all colors.
constexpr std::uint32_t orders = 4;
using ByOrder = std::array<float, orders>;
constexpr glm::vec3 metal{0.95f, 0.62f, 0.28f};

/// GGX, single scattering (Walter et al. 2007). Normals are drawn from the visible ones (Heitz 2018). v.z > 0.
struct Ggx {
  float alpha;
  float g1(const Vec& v) const { return 2 * v.z / (v.z + std::sqrt(v.z * v.z + alpha * alpha * (1 - v.z * v.z))); }
  float visible(const Vec& v, const Vec& h) const {
    const float k = h.z * h.z * (alpha * alpha - 1) + 1;
    return g1(v) * alpha * alpha / (pi * k * k) * std::max(0.0f, dot(v, h)) / v.z;
  }
  Vec draw(const Vec& v, RandomStream& random) const {
    const Vec w = normalize(Vec(alpha * v.x, alpha * v.y, v.z));
    const Vec t = w.z < 0.99999f ? normalize(Vec(-w.y, w.x, 0)) : Vec(1, 0, 0);
    const float r = std::sqrt(random.next()), phi = 2 * pi * random.next(), a = r * std::cos(phi), s = (1 + w.z) / 2;
    const float b = (1 - s) * std::sqrt(1 - a * a) + s * r * std::sin(phi);
    const Vec h = a * t + b * glm::cross(w, t) + std::sqrt(std::max(0.0f, 1 - a * a - b * b)) * w;
    return normalize(Vec(alpha * h.x, alpha * h.y, std::max(1e-6f, h.z)));
  }
};
constexpr Ggx coat{0.1f}, base{0.3f};
constexpr float eta = 1.5f;  ///< of the coat

/// Reflectance of a dielectric whose index, over that of the side of c, is ratio.
float fresnel(float c, float ratio) {
  const float g2 = ratio * ratio - 1 + c * c;
  if (g2 <= 0) return 1;
  const float g = std::sqrt(g2), a = (g - c) / (g + c), b = (c * (g + c) - 1) / (c * (g - c) + 1);
  return a * a * (1 + b * b) / 2;
}

struct Walk {
  Vec wi{0};
  float weight = 1;  ///< 0: lost, as light is by single scattering
  std::uint32_t order = 0;
};

/// Walks from wo. meets(v, weight, order) is called wherever it meets the metal: v points back to where it came from,
/// weight is that of the walk so far, order that of light that leaves from there.
template <class Meets>
Walk walk(const Vec& wo, RandomStream& random, const Meets& meets) {
  Walk path;
  const auto lost = [&] { return Walk{.wi = {}, .weight = 0, .order = path.order}; };
  Vec h = coat.draw(wo, random);
  if (random.next() < fresnel(dot(wo, h), eta)) {
    path.wi = glm::reflect(-wo, h);
    path.weight = path.wi.z > 0 ? coat.g1(path.wi) : 0;
    return path;
  }
  // Below the coat, v points up from where the walk meets the metal.
  Vec v = -glm::refract(-wo, h, 1 / eta);
  for (int i = 0; i < 32 && v.z > 0; ++i) {
    path.weight *= coat.g1(v);
    path.order = std::min(path.order + 1, orders - 1);
    meets(v, path.weight, path.order);
    const Vec up = glm::reflect(-v, base.draw(v, random));
    if (up.z <= 0) return lost();
    path.weight *= base.g1(up);
    // The coat from below, mirrored at its plane: `back` has z > 0, and what leaves has z < 0.
    const Vec back(-up.x, -up.y, up.z);
    h = coat.draw(back, random);
    if (random.next() >= fresnel(dot(back, h), 1 / eta)) {
      const Vec out = glm::refract(-back, h, eta);
      path.wi = {out.x, out.y, -out.z};
      path.weight *= path.wi.z > 0 ? coat.g1(path.wi) : 0;
      return path;
    }
    const Vec again = glm::reflect(-back, h);
    v = {-again.x, -again.y, again.z};
  }
  return lost();
}

/// Azimuth and height of a direction for wo = (sin theta, 0, cos theta), and the way back. The cylinder lies across the
/// plane of incidence, so that no lobe is at one of its ends. Azimuth: the angle in that plane from the mirror
/// direction, so that the lobes of neighbouring nodes lie on one another. Height: asinh tan of the angle out of it.
std::array<float, 2> place_of(const Vec& wi, float theta) {
  return {std::atan2(wi.x, wi.z) + theta, std::atanh(std::clamp(wi.y, -0.9999999f, 0.9999999f))};
}
Vec direction_of(float azimuth, float height, float theta) {
  const float y = std::tanh(height), c = std::sqrt(std::max(0.0f, 1 - y * y));
  return {c * std::sin(azimuth - theta), y, c * std::cos(azimuth - theta)};
}
Vec outgoing(float theta) { return {std::sin(theta), 0, std::cos(theta)}; }

/// The surface as a target. Nodes: (theta of wo, 0), radians.
struct Target final : adaptive::SampledTarget {
  std::uint32_t parts(const adaptive::SliceDescription&) const override { return orders; }
  std::string model_name() const override { return "layered-conductor-1"; }
  void draw(const adaptive::SliceDescription&, float theta, float, std::uint64_t stream, std::uint32_t first,
            std::uint32_t count, std::vector<adaptive::SampledExit>& out) const override {
    for (std::uint32_t i = first; i < first + count; ++i) {
      RandomStream random(stream, i, bits_of(theta, 0));
      const Walk path = walk(outgoing(theta), random, [](const Vec&, float, std::uint32_t) {});
      const auto [azimuth, height] = place_of(path.wi, theta);
      if (path.weight > 0) out.push_back({azimuth, height, path.order, path.weight, 0});
    }
  }
};

/// f cos theta_i (1/sr) or the weight of a draw, by order, and the density of the draw (1/sr).
struct Value {
  ByOrder of{};
  float pdf = 0;
  Vec wi{0};
};

/// The surface by walks, as a renderer without rows has it.
struct ByWalks {
  float theta;
  float pdf(const Vec& wi) const {
    const Vec wo = outgoing(theta), h = normalize(wo + wi);
    return (0.2f * coat.visible(wo, h) + 0.7f * base.visible(wo, h)) / (4 * dot(wo, h)) + 0.1f / (2 * pi);
  }
  std::optional<Value> draw(RandomStream& random) const {
    const Walk path = walk(outgoing(theta), random, [](const Vec&, float, std::uint32_t) {});
    if (!(path.weight > 0)) return std::nullopt;
    Value value{{}, pdf(path.wi), path.wi};
    value.of[path.order] = path.weight;
    return value;
  }
  /// One walk, connected wherever it meets the metal to one refraction of wi by the coat, whose kernel K has
  /// K(up, wi) up.z = K(wi, up) wi.z/eta^2.
  Value evaluate(const Vec& wi, RandomStream& random) const {
    const Vec wo = outgoing(theta), half = normalize(wo + wi);
    Value value{{}, pdf(wi), wi};
    value.of[0] = fresnel(dot(wo, half), eta) * coat.visible(wo, half) * coat.g1(wi) / (4 * dot(wo, half));
    const Vec h = coat.draw(wi, random), up = -glm::refract(-wi, h, 1 / eta);
    if (up.z <= 0) return value;
    const float passes = (1 - fresnel(dot(wi, h), eta)) * coat.g1(up) * wi.z / (eta * eta);
    walk(wo, random, [&](const Vec& v, float weight, std::uint32_t order) {
      const Vec m = normalize(v + up);
      value.of[order] += weight * passes * base.visible(v, m) * base.g1(up) / (4 * dot(v, m) * up.z);
    });
    return value;
  }
};

/// What the host reads in place of a row, made once: its parts, decoded.
struct Decoded final : adaptive::RowForm {
  std::size_t bytes(const adaptive::RowView&) const override { return sizeof(adaptive::DecodedRow); }
  void write(const adaptive::RowView& row, void* memory) const override {
    new (memory) adaptive::DecodedRow(*row.ribbons);
  }
};

/// The surface by rows: one node, chosen for the hit, answers draw() and evaluate(); by walks where none does yet.
class ByRows {
 public:
  ByRows(const adaptive::Service& service, const adaptive::FormedRows& rows, float theta, RandomStream& random)
      : theta_(theta) {
    const adaptive::Node node = adaptive::choose(service, rows.slice(), theta, 0, random.next(), 0);
    adaptive::RowAnswer answer = adaptive::AnswerReader(&service).read(rows.run(node.a), 0);
    adaptive::RowView view;
    view.slice = node.slice;
    view.node = node.a;
    if (!answer) {
      adaptive::FormedLookup found = service.look_up(rows, node.a);
      answer = found.answer;
      kept_ = std::move(found.kept);
    }
    service.credit(view, 1);
    if (answer) row_ = static_cast<const adaptive::DecodedRow*>(answer.block());
  }
  std::optional<Value> draw(RandomStream& random) const {
    if (row_ == nullptr) return ByWalks{theta_}.draw(random);
    float below = random.next() * (row_->mass[0] + row_->mass[1] + row_->mass[2] + row_->mass[3]);
    std::uint32_t part = 0;
    while (part + 1 < orders && below >= row_->mass[part]) below -= row_->mass[part++];
    const float u = random.next(), v = random.next();
    const auto at = row_->ribbon[part].sample(u, v);
    Value value = valued(direction_of(at.azimuth, at.height, theta_), at.azimuth, at.height);
    if (value.wi.z <= 0) return std::nullopt;  // a row does not know the horizon
    for (float& weight : value.of) weight /= value.pdf;
    return value;
  }
  Value evaluate(const Vec& wi, RandomStream& random) const {
    if (row_ == nullptr) return ByWalks{theta_}.evaluate(wi, random);
    const auto [azimuth, height] = place_of(wi, theta_);
    return valued(wi, azimuth, height);
  }

 private:
  Value valued(const Vec& wi, float azimuth, float height) const {
    Value value{{}, 0, wi};
    const float per_sr = 1 / std::max(1e-6f, 1 - wi.y * wi.y);  // d azimuth d height
    float sum = 0, mass = 0;
    for (std::uint32_t part = 0; part < orders; ++part) {
      if (!(row_->mass[part] > 0)) continue;
      sum += value.of[part] = row_->mass[part] * row_->ribbon[part].density(azimuth, height) * per_sr;
      mass += row_->mass[part];
    }
    value.pdf = sum / mass;
    return value;
  }
  float theta_;
  const adaptive::DecodedRow* row_ = nullptr;
  std::shared_ptr<const void> kept_;
};

// A sky that is brighter at its zenith, y, and a lamp of four degrees.
const Vec lamp = normalize(Vec(-0.6f, 0.65f, 0.5f)), beside_lamp = normalize(Vec(lamp.y, -lamp.x, 0));
const float lamp_cos = std::cos(0.07f), lamp_pdf = 1 / (2 * pi * (1 - lamp_cos)), lamp_light = 60;
float sky(const Vec& w) { return w.y > 0 ? 0.15f + 0.9f * w.y : 0.08f; }

/// A sample of the light that leaves a point of the sphere, seen along z.
template <class Surface>
glm::vec3 sample_of(const Vec& normal, const Surface& surface, RandomStream& random) {
  const Vec seen(0, 0, 1), y = normal.z < 0.99999f ? normalize(glm::cross(normal, seen)) : Vec(0, 1, 0);
  const glm::mat3 to_world(glm::cross(y, normal), y, normal);
  glm::vec3 sum(0.0f);
  const auto add = [&](const ByOrder& weight, float light) {
    glm::vec3 tint(1.0f);
    for (const float of_order : weight) {
      sum += of_order * light * tint;
      tint *= metal;
    }
  };
  if (const std::optional<Value> drawn = surface.draw(random)) {
    const Vec w = to_world * drawn->wi;
    add(drawn->of, sky(w) + (dot(w, lamp) > lamp_cos ? lamp_light * drawn->pdf / (drawn->pdf + lamp_pdf) : 0));
  }
  const float c = 1 - random.next() * (1 - lamp_cos), s = std::sqrt(1 - c * c), phi = 2 * pi * random.next();
  const Vec to_lamp = s * std::cos(phi) * beside_lamp + s * std::sin(phi) * glm::cross(lamp, beside_lamp) + c * lamp;
  const Vec wi = glm::transpose(to_world) * to_lamp;
  if (wi.z <= 0) return sum;
  const Value value = surface.evaluate(wi, random);
  add(value.of, lamp_light / (lamp_pdf + value.pdf));
  return sum;
}

/// Sums of samples of the sphere.
struct Film {
  explicit Film(int width) : size(width), sums(static_cast<std::size_t>(width) * static_cast<std::size_t>(width)) {}
  int size;
  std::uint64_t samples = 0;
  std::vector<glm::vec3> sums;

  /// One more sample of each pixel; surface(theta, random) makes what scatters there.
  template <class Surface>
  void add(std::uint64_t seed, const Surface& surface) {
    tbb::parallel_for(0, size, [&](int row) {
      for (int column = 0; column < size; ++column) {
        const auto pixel = static_cast<std::size_t>(row * size + column);
        RandomStream random(seed, samples, pixel);
        const float x = (2 * (static_cast<float>(column) + random.next()) / static_cast<float>(size) - 1) * 1.04f;
        const float y = (1 - 2 * (static_cast<float>(row) + random.next()) / static_cast<float>(size)) * 1.04f;
        const float z2 = 1 - x * x - y * y;
        if (z2 < 1e-4f) continue;
        const Vec normal(x, y, std::sqrt(z2));
        sums[pixel] += sample_of(normal, surface(std::acos(normal.z), random), random);
      }
    });
    ++samples;
  }
  void add_walks(std::uint64_t seed) {
    add(seed, [](float theta, RandomStream&) { return ByWalks{theta}; });
  }
};

/// The films beside one another.
image::Picture picture_of(const std::vector<const Film*>& films) {
  image::Picture picture;
  picture.height = films[0]->size;
  picture.width = picture.height * static_cast<int>(films.size());
  for (const int c : {0, 1, 2}) {
    picture.channels.push_back({std::string(1, "RGB"[c]), {}});
    for (int row = 0; row < picture.height; ++row)
      for (const Film* film : films)
        for (int x = 0; x < film->size; ++x)
          picture.channels.back().pixels.push_back(film->sums[static_cast<std::size_t>(row * film->size + x)][c] /
                                                   static_cast<float>(film->samples));
  }
  return picture;
}

double seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

struct Setting {
  int size = 160;
  std::uint64_t samples = 64, truth = 2048, seed = 1;
  std::string picture;
};

void print(const char* name, const Film& film, const Film& truth, double cpu) {
  const image::Picture one = picture_of({&film}), reference = picture_of({&truth});
  double ours = 0, theirs = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    for (const float x : one.channels[c].pixels) ours += static_cast<double>(x);
    for (const float x : reference.channels[c].pixels) theirs += static_cast<double>(x);
  }
  const auto off = image::compare(reference, one, "truth", name);
  fmt::print("| {} | {:.2f} | {} | {:.5f} | {:.4f} |\n", name, cpu, film.samples, off ? off->rel_mse : NAN,
             ours / theirs);
}

/// The share of a row's draws that lie below the horizon: over all rows, and the most of one.
std::array<double, 2> below_horizon(const adaptive::Service& service, adaptive::SliceId slice) {
  constexpr int draws = 4096;
  const std::vector<float>& axis = service.slice(slice).axis_a;
  std::array<double, 2> share{};
  for (std::uint32_t node = 0; node < axis.size(); ++node) {
    RandomStream random(1, node);
    int below = 0;
    for (int i = 0; i < draws; ++i) {
      const auto at = adaptive::sample(service, {slice, node, 0}, {random.next(), random.next(), random.next()});
      below += direction_of(at.azimuth, at.height, axis[node]).z <= 0 ? 1 : 0;
    }
    share[0] += static_cast<double>(below) / draws / static_cast<double>(axis.size());
    share[1] = std::max(share[1], static_cast<double>(below) / draws);
  }
  return share;
}

int run(const Setting& setting) {
  Film truth(setting.size), walks(setting.size), first(setting.size);
  while (truth.samples < setting.truth) truth.add_walks(setting.seed + 1);
  const double from = seconds();
  while (walks.samples < setting.samples) walks.add_walks(setting.seed);
  const double budget = seconds() - from;
  fmt::print("| | CPU s | samples | relMSE | mean over the truth's |\n|---|---|---|---|---|\n");
  print("walks", walks, truth, budget);

  const Target target;
  std::optional<adaptive::TableSnapshot> learned;
  for (const char* name : {"rows, cold", "rows, warm"}) {
    adaptive::Service service({}, target);
    adaptive::SliceDescription slice;
    slice.kind = adaptive::SliceKind::samples;
    for (int i = 0; i <= 48; ++i) slice.axis_a.push_back(1.57f / 48 * static_cast<float>(i));
    slice.axis_b = {0};
    slice.coarse = {{{0, 12, 24, 36, 48}, {0}}};
    const double start = seconds();
    if (learned && service.load(*learned)) return 1;
    const auto id = service.add_slice(slice);
    const auto rows = id ? service.add_form(*id, std::make_shared<Decoded>()) : id.error();
    if (!rows) return 1;
    service.prepare();
    Film film(setting.size);
    while (film.samples == 0 || seconds() - start < budget) {
      film.add(setting.seed, [&](float theta, RandomStream& random) { return ByRows(service, **rows, theta, random); });
      if (service.publish_pays()) service.publish(film.sums.size());
    }
    print(name, film, truth, seconds() - start);
    if (!learned) {
      learned = service.snapshot();
      first = film;
    } else {
      const auto [all, most] = below_horizon(service, *id);
      fmt::print("below the horizon: {:.2f} % of the rows' draws, {:.2f} % of one row's\n", 100 * all, 100 * most);
    }
  }
  if (setting.picture.empty()) return 0;
  const auto error = image::write_png(setting.picture, picture_of({&walks, &first, &truth}));
  if (error) fmt::print(stderr, "{}\n", error->message());
  return error ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  Setting setting;
  CLI::App app("A coated metal by random walks and by rows, at equal CPU time");
  app.add_option("--size", setting.size, "pixels of a side")->check(CLI::Range(4, 4096));
  app.add_option("--samples", setting.samples, "of walks, a pixel; rows get their CPU time")
      ->check(CLI::Range(1, 1 << 20));
  app.add_option("--truth", setting.truth, "samples a pixel of the truth, by walks")->check(CLI::Range(1, 1 << 24));
  app.add_option("--seed", setting.seed);
  app.add_option("--picture", setting.picture, "PNG to write: walks, rows from nothing, truth");
  CLI11_PARSE(app, argc, argv);
  return run(setting);
}
