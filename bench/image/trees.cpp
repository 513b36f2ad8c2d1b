// What Embree's settings are worth: the rays of a renderer's own paths against trees that are built otherwise.
//
//   bench_trees SCENE [--size WxH] [--up y|z] [--environment FILE] [--melanin M] [--teach N] [--rounds N] [--only NAME]
//
// A picture is rendered to teach the rows, then one sample a pixel is traced and its rays are recorded. Each tree is
// built and meets them beside the default one, in turns, on one thread; built one at a time. Prints JSON: of each tree
// its bytes and build seconds over those of the default one, the medians over the rounds of its CPU time over that of
// the default tree, by kind of ray and for all, and the share of rays that it decides otherwise. `same again` shows
// what noise is.
#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <ctime>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/denormals.h"
#include "integrate/path_tracer.h"
#include "integrate/renderer.h"
#include "ray_packets.h"
#include "recorded_paths.h"
#include "references/registry.h"
#include "scene/read/load_scene.h"
#include "tress/adaptive/service.h"

namespace tress::bench {
namespace {

using geometry::FiberScene;
using geometry::TreeOptions;
using Quality = TreeOptions::Quality;
using Robust = TreeOptions::Robust;

enum class Strands { as_they_are, cut_in_two, cut_in_four, straight };

struct Tree {
  const char* name;
  TreeOptions options;
  Strands strands = Strands::as_they_are;
  int pieces = 1;  ///< of each segment, of straight strands
};

TreeOptions on_device(const char* device) { return {device, Quality::medium, false, Robust::with_meshes, 0}; }
TreeOptions built(Quality quality) { return {"", quality, false, Robust::with_meshes, 0}; }
TreeOptions in_pieces(float pieces) { return {"", Quality::medium, false, Robust::with_meshes, pieces}; }

std::vector<Tree> trees() {
  return {{"same again", {}},
          {"quality low", built(Quality::low)},
          {"quality high", built(Quality::high)},
          {"compact", {"", Quality::medium, true, Robust::with_meshes, 0}},
          {"robust", {"", Quality::medium, false, Robust::always, 0}},
          {"not robust", {"", Quality::medium, false, Robust::never, 0}},
          {"huge pages", on_device("hugepages=1")},
          {"AVX2", on_device("isa=avx2")},
          {"4 curves a leaf", on_device("hair_accel=bvh4obb.virtualcurve4v")},
          {"8 curves a leaf, by index", on_device("hair_accel=bvh4obb.virtualcurve8i")},
          {"boxes along the axes", on_device("hair_accel=bvh4.virtualcurve8i")},
          {"2 pieces a segment", in_pieces(2)},
          {"1 piece a segment", in_pieces(1)},
          {"segments cut in two", {}, Strands::cut_in_two},
          {"segments cut in two, 2 pieces each", in_pieces(2), Strands::cut_in_two},
          {"segments cut in four", {}, Strands::cut_in_four},
          {"straight from knot to knot", {}, Strands::straight, 1},
          {"straight, 2 pieces a segment", {}, Strands::straight, 2},
          {"straight, 4 pieces a segment", {}, Strands::straight, 4}};
}

double thread_seconds() {
  std::timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double timed(const std::function<void()>& work) {
  const double start = thread_seconds();
  work();
  return thread_seconds() - start;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// Control points of a strand as Embree has them: the ends reflected.
template <class T>
std::vector<T> reflected(const std::vector<T>& all, std::size_t begin, std::size_t end) {
  std::vector<T> control{2.0f * all[begin] - all[begin + 1]};
  control.insert(control.end(), all.begin() + std::ptrdiff_t(begin), all.begin() + std::ptrdiff_t(end));
  control.push_back(2.0f * all[end - 1] - all[end - 2]);
  return control;
}

/// The same B-spline with twice the segments.
template <class T>
std::vector<T> cut(const std::vector<T>& c) {
  std::vector<T> finer{0.5f * (c[0] + c[1])};
  for (std::size_t i = 1; i + 1 < c.size(); ++i) {
    finer.push_back(0.125f * (c[i - 1] + 6.0f * c[i] + c[i + 1]));
    finer.push_back(0.5f * (c[i] + c[i + 1]));
  }
  return finer;
}

/// Points on the B-spline, `pieces` to a segment.
template <class T>
std::vector<T> on_spline(const std::vector<T>& c, int pieces) {
  std::vector<T> points;
  const auto at = [&](std::size_t i, float t) {
    const float s = 1 - t;
    return (s * s * s * c[i] + (4 - 3 * t * t * (2 - t)) * c[i + 1] + (4 - 3 * s * s * (2 - s)) * c[i + 2] +
            t * t * t * c[i + 3]) *
           (1 / 6.0f);
  };
  for (std::size_t i = 0; i + 3 < c.size(); ++i)
    for (int k = 0; k < pieces; ++k) points.push_back(at(i, static_cast<float>(k) / static_cast<float>(pieces)));
  points.push_back(at(c.size() - 4, 1));
  return points;
}

/// B-splines that rest and have two points at least are changed; others stay.
scene::Scene changed(const scene::Scene& scene, Strands strands, int pieces) {
  scene::Scene other = scene;
  for (scene::Groom& groom : other.grooms) {
    if (groom.basis != scene::StrandBasis::bspline || !groom.later.empty() || !groom.minor_axis.empty()) continue;
    std::vector<glm::vec3> points;
    std::vector<float> radii;
    std::vector<std::uint32_t> first{0};
    const auto add = [&](const auto& all, std::size_t begin, std::size_t end, auto& to) {
      const auto control = reflected(all, begin, end);
      const auto made = strands == Strands::straight     ? on_spline(control, pieces)
                        : strands == Strands::cut_in_two ? cut(control)
                                                         : cut(cut(control));
      to.insert(to.end(), made.begin(), made.end());
    };
    for (std::uint32_t strand = 0; strand < groom.strand_count(); ++strand) {
      const std::size_t begin = groom.first_point[strand], end = groom.first_point[strand + 1];
      if (end - begin >= 2) {
        add(groom.points, begin, end, points);
        add(groom.radius_cm, begin, end, radii);
      }
      first.push_back(static_cast<std::uint32_t>(points.size()));
    }
    groom.points = points;
    groom.radius_cm = radii;
    groom.first_point = first;
    groom.basis = strands == Strands::straight ? scene::StrandBasis::linear : scene::StrandBasis::open_bspline;
  }
  return other;
}

struct Settings {
  std::string scene, size = "64x64", only;
  scene::Overrides overrides;
  int teach = 8, rounds = 5;
};

RecordedPaths recorded(const scene::Scene& scene, const FiberScene& fibers, const Settings& settings) {
  const fiber::ModelInfo& info = *references::find_model("elliptical");
  fiber::ModelService learned = fiber::make_service(info, {});
  const auto model = info.make({fiber::Estimator::fitted, learned.service.get(), 0});
  std::vector<fiber::FiberId> ids;
  for (const fiber::FiberParameters& fiber : scene.fibers) ids.push_back(model->add_fiber(fiber));
  integrate::RenderOptions options;
  options.samples = settings.teach;
  const std::atomic<bool> never{false};
  integrate::render(scene, fibers, *model, ids, learned.service.get(), options, never,
                    [](const integrate::PassProgress&) { return true; });
  const integrate::PathTracer tracer(scene, fibers, *model, ids, options);
  const FlushDenormals flush;
  RecordedPaths paths;
  recording = &paths;
  for (int y = 0; y < scene.image.height; ++y) {
    for (int x = 0; x < scene.image.width; ++x) {
      paths.is_first_ray = true;
      tracer.trace(x, y, static_cast<std::uint32_t>(settings.teach));
    }
  }
  recording = nullptr;
  return paths;
}

enum Kind : std::size_t { camera, continuation, shadow, kind_count };
constexpr std::array<const char*, kind_count> kinds{"camera", "continuation", "shadow"};

/// What each ray has met, in the order of the kinds.
using Answers = std::vector<bool>;

void meet(const FiberScene& fibers, const RecordedPaths& paths, Kind kind, Answers* met) {
  if (kind == camera)
    for (const geometry::Ray& ray : paths.camera_rays) met->push_back(fibers.intersect(ray).has_value());
  if (kind == continuation)
    for (const Way& way : paths.ways) met->push_back(fibers.intersect(way.ray).has_value());
  if (kind == shadow)
    for (const ShadowRay& ray : paths.shadow_rays) met->push_back(fibers.occluded(ray.ray, ray.distance_cm));
}

nlohmann::ordered_json compared(const Tree& tree, const scene::Scene& scene, const FiberScene& plain,
                                double plain_build, const RecordedPaths& paths, int rounds) {
  nlohmann::ordered_json found;
  found["tree"] = tree.name;
  std::optional<scene::Scene> other;
  if (tree.strands != Strands::as_they_are) other = changed(scene, tree.strands, tree.pieces);
  std::unique_ptr<FiberScene> fibers;
  double build = 0;
  try {
    build = timed([&] {
      fibers = std::make_unique<FiberScene>(other ? *other : scene, std::function<void(double)>(), tree.options);
    });
  } catch (const std::exception& error) {
    found["refused"] = error.what();
    return found;
  }
  std::array<std::vector<double>, kind_count> ratios;
  std::vector<double> all;
  Answers plain_met, met;
  for (int round = 0; round < rounds; ++round) {
    double sum = 0, plain_sum = 0;
    plain_met.clear();
    met.clear();
    for (std::size_t kind = 0; kind < kind_count; ++kind) {
      const auto one = [&] { return timed([&] { meet(*fibers, paths, Kind(kind), &met); }); };
      const auto default_one = [&] { return timed([&] { meet(plain, paths, Kind(kind), &plain_met); }); };
      double first = 0, second = 0;
      if (round % 2 == 0) first = default_one();
      second = one();
      if (round % 2 == 1) first = default_one();
      ratios[kind].push_back(second / first);
      sum += second;
      plain_sum += first;
    }
    all.push_back(sum / plain_sum);
  }
  for (std::size_t kind = 0; kind < kind_count; ++kind) found[kinds[kind]] = median(ratios[kind]);
  found["all"] = median(all);
  std::size_t differ = 0;
  for (std::size_t i = 0; i < met.size(); ++i) differ += met[i] != plain_met[i];
  found["decided_otherwise"] = static_cast<double>(differ) / static_cast<double>(met.size());
  found["bytes"] = static_cast<double>(fibers->bytes()) / static_cast<double>(plain.bytes());
  found["build_cpu"] = build / plain_build;
  return found;
}

/// Shadow rays that are asked otherwise, over the time of FiberScene::occluded() or of rtcOccluded1.
nlohmann::ordered_json asked_otherwise(const scene::Scene& scene, const FiberScene& plain, const RecordedPaths& paths,
                                       int rounds) {
  std::size_t met = 0;
  const auto ratio = [&](const std::function<void()>& rival, const std::function<void()>& usual) {
    std::vector<double> ratios;
    for (int round = 0; round < rounds; ++round) {
      const double before = timed(usual);
      ratios.push_back(timed(rival) / before);
    }
    return median(ratios);
  };
  nlohmann::ordered_json found;
  found["nearest hits in place of any"] = ratio(
      [&] {
        for (const ShadowRay& ray : paths.shadow_rays) met += plain.intersect(ray.ray).has_value();
      },
      [&] {
        for (const ShadowRay& ray : paths.shadow_rays) met += plain.occluded(ray.ray, ray.distance_cm);
      });
#if RTC_VERSION_MAJOR < 4
  const BareTree bare(scene);
  const std::vector<ShadowRay>& rays = paths.shadow_rays;
  const auto one_by_one = [&] { met += bare.one_by_one(rays); };
  for (const bool coherent : {false, true}) {
    const std::string hint = coherent ? ", said to be coherent" : "";
    found["packets of 8" + hint] = ratio([&] { met += bare.by_eight(rays, coherent); }, one_by_one);
    found["streams of 64" + hint] = ratio([&] { met += bare.in_streams(rays, coherent); }, one_by_one);
  }
#endif
  if (met == 0) found["met"] = 0;
  return found;
}

int run(const Settings& settings) {
  Result<scene::Scene> scene = scene::load_scene(settings.scene, settings.overrides);
  if (!scene) {
    fmt::print(stderr, "{}\n", scene.error().message());
    return 1;
  }
  std::unique_ptr<FiberScene> plain;
  const double build = timed([&] { plain = std::make_unique<FiberScene>(*scene); });
  const RecordedPaths paths = recorded(*scene, *plain, settings);
  nlohmann::ordered_json out;
  out["scene"] = settings.scene;
  out["rays"] = {
      {"camera", paths.camera_rays.size()}, {"continuation", paths.ways.size()}, {"shadow", paths.shadow_rays.size()}};
  out["bytes"] = plain->bytes();
  out["rounds"] = settings.rounds;
  for (const Tree& tree : trees()) {
    if (settings.only.empty() || tree.name == settings.only)
      out["trees"].push_back(compared(tree, *scene, *plain, build, paths, settings.rounds));
  }
  if (settings.only.empty()) out["shadow_rays"] = asked_otherwise(*scene, *plain, paths, settings.rounds);
  fmt::print("{}\n", out.dump(1));
  return 0;
}

}  // namespace
}  // namespace tress::bench

int main(int argc, char** argv) {
  CLI::App app("Rays of a render against trees that are built otherwise; JSON");
  tress::bench::Settings settings;
  std::string up, environment;
  float melanin = -1;
  app.add_option("scene", settings.scene)->required();
  app.add_option("--size", settings.size);
  app.add_option("--up", up);
  app.add_option("--environment", environment);
  app.add_option("--melanin", melanin);
  app.add_option("--teach", settings.teach)->check(CLI::PositiveNumber);
  app.add_option("--rounds", settings.rounds)->check(CLI::PositiveNumber);
  app.add_option("--only", settings.only);
  CLI11_PARSE(app, argc, argv);
  if (!up.empty()) settings.overrides.y_up = up == "y";
  if (!environment.empty()) settings.overrides.environment_file = environment;
  if (melanin >= 0) settings.overrides.melanin = {melanin, 0.0f};
  int width = 0, height = 0;
  if (std::sscanf(settings.size.c_str(), "%dx%d", &width, &height) != 2 || width < 1 || height < 1) return 2;
  settings.overrides.width = width;
  settings.overrides.height = height;
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  tbb::task_arena arena(1);
  return arena.execute([&] { return tress::bench::run(settings); });
}
