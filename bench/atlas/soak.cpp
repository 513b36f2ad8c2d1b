// One process that lives many times: it loads a scene, makes a service, takes over the table of the life before,
// renders a little, saves to memory and destroys everything. What it holds afterwards must not grow.
//
//   bench_atlas_soak SCENE [--lives N] [--size WxH] [--spp N]
//
// Prints JSON: after each life the resident bytes, the bytes that are allocated on the heap (mallinfo2) without the
// saved table, and those of that; and how each grew over the second half, in bytes. Lives differ in seed. Under
// valgrind or LeakSanitizer a few lives show what is lost.
#include <malloc.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "geometry/fiber_scene.h"
#include "integrate/renderer.h"
#include "scene/read/load_scene.h"
#include "tress/adaptive/cache.h"
#include "tress/fiber/elliptical_model.h"

namespace tress {
namespace {

struct Settings {
  std::string scene, size = "16x20";
  int lives = 500, samples = 2;
};

/// Fails with a message: a bench has no one to hand an error to.
[[noreturn]] void stop_with(const std::string& message) {
  std::fprintf(stderr, "%s\n", message.c_str());
  std::exit(1);
}

std::uint64_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::uint64_t size = 0, resident = 0;
  file >> size >> resident;
  return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

/// One life; `saved` is the table of the one before, and then this one's.
void live(const Settings& settings, int life, std::string& saved) {
  scene::Overrides overrides;
  int width = 0, height = 0;
  if (std::sscanf(settings.size.c_str(), "%dx%d", &width, &height) != 2) stop_with("--size: expected WxH");
  overrides.width = width;
  overrides.height = height;
  const Result<scene::Scene> scene = scene::load_scene(settings.scene, overrides);
  if (!scene) stop_with(scene.error().message());
  const geometry::FiberScene fibers(*scene);
  const auto target = fiber::make_elliptical_target();
  adaptive::Options learn;
  learn.seed = static_cast<std::uint64_t>(life);
  adaptive::Service service(learn, *target);
  const auto model = *fiber::make_elliptical_model(fiber::Estimator::fitted, &service);
  std::vector<fiber::FiberId> ids;
  for (const fiber::FiberParameters& one : scene->fibers) ids.push_back(model->add_fiber(one));
  if (!saved.empty()) {
    Result<adaptive::TableSnapshot> image = adaptive::decode_cache(saved, target->model_name(), "saved");
    if (!image) stop_with(image.error().message());
    if (const auto error = service.load(std::move(*image))) stop_with(error->message());
  }
  integrate::RenderOptions options;
  options.samples = settings.samples;
  options.seed = static_cast<std::uint64_t>(life);
  const std::atomic<bool> never{false};
  integrate::render(*scene, fibers, *model, ids, &service, options, never, nullptr);
  saved = adaptive::encode_cache(service.snapshot());
}

int run(const Settings& settings) {
  std::vector<std::uint64_t> resident, heap, table;
  for (auto* series : {&resident, &heap, &table}) series->reserve(static_cast<std::size_t>(settings.lives));
  std::string saved;
  for (int life = 0; life < settings.lives; ++life) {
    live(settings, life, saved);
    resident.push_back(resident_bytes());
    heap.push_back(mallinfo2().uordblks + mallinfo2().hblkhd - saved.capacity());
    table.push_back(saved.size());
  }
  const std::size_t half = heap.size() / 2;
  const auto change = [half](const std::vector<std::uint64_t>& values) {
    return static_cast<std::int64_t>(values.back()) - static_cast<std::int64_t>(values[half]);
  };
  const nlohmann::ordered_json out = {{"lives", settings.lives},
                                      {"rss_bytes", resident},
                                      {"heap_bytes", heap},
                                      {"table_bytes", table},
                                      {"heap_change_bytes", change(heap)},
                                      {"table_change_bytes", change(table)},
                                      {"rss_change_bytes", change(resident)}};
  std::printf("%s\n", out.dump().c_str());
  return 0;
}

}  // namespace
}  // namespace tress

int main(int argc, char** argv) {
  tress::Settings settings;
  CLI::App app("One process that lives many times");
  app.add_option("scene", settings.scene)->required();
  app.add_option("--lives", settings.lives)->check(CLI::Range(1, 100000));
  app.add_option("--size", settings.size);
  app.add_option("--spp", settings.samples)->check(CLI::Range(1, 4096));
  CLI11_PARSE(app, argc, argv);
  return tress::run(settings);
}
