// A target of the host's own behind the C interface: a beam by its rays, and a random walk by its samples. Both are
// learned over a few passes, and what was learned is saved, loaded and answered from at once.
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tress/tress.h"

static int trace(void* user, const tress_place* place, tress_rays* rays) {
  (void)user;
  for (int i = 0; i < 32; ++i) {
    const tress_ray ray = {place->a + 0.02f * (float)i, place->b / 32, 0};
    tress_add_rays(rays, &ray, 1);
  }
  return 1;
}

static float hashed(uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return (float)((x ^ (x >> 31)) >> 40) / 16777216.0f;
}

// Two parts: 0.7 of the light within a quarter turn of a, 0.2 anywhere.
static int draw(void* user, const tress_place* place, uint64_t stream, uint32_t first, uint32_t count,
                tress_exits* exits) {
  (void)user;
  for (uint32_t i = first; i < first + count; ++i) {
    const uint64_t key = (stream << 34) + ((uint64_t)i << 2) + 1;
    const float u = 2 * hashed(key) - 1, t = hashed(key + 1) + hashed(key + 2) - 1;
    const tress_exit both[2] = {{place->a + 0.79f * u, t, 0, 0.7f, 0}, {3.14f * u, t + place->b, 1, 0.2f, 0}};
    tress_add_exits(exits, both, 2);
  }
  return 1;
}

typedef struct host {
  tress_service* service;
  uint32_t beam, walk;
  int failures, calls_of_progress;
  int64_t bytes;
} host;

static void on_error(void* user, tress_result result, const char* message) {
  ++((host*)user)->failures;
  fprintf(stderr, "%s: %s\n", tress_result_name(result), message);
}

static int on_progress(void* user, double done) {
  ++((host*)user)->calls_of_progress;
  return done >= 0 && done < 1;
}

static int on_memory(void* user, int64_t bytes, int post) {
  (void)post;  // 0: may refuse
  ((host*)user)->bytes += bytes;
  return 1;
}

static int start(host* self) {
  memset(self, 0, sizeof *self);
  const tress_target target = {"beam-1", self, trace, draw, 2};
  tress_options options;
  tress_options_init(&options);
  options.threads = 2;
  options.user = self;
  options.on_error = on_error;
  options.on_progress = on_progress;
  options.on_memory = on_memory;
  if (tress_service_create(&target, &options, &self->service) != TRESS_OK) return 0;
  const float a[5] = {-1, -0.5f, 0, 0.5f, 1}, b[3] = {0.25f, 0.5f, 0.75f};
  tress_slice slice;
  tress_slice_init(&slice);
  slice.axis_a = a;
  slice.count_a = 5;
  slice.axis_b = b;
  slice.count_b = 3;
  if (tress_service_add_slice(self->service, &slice, &self->beam) != TRESS_OK) return 0;
  slice.kind = TRESS_SAMPLES;
  slice.lobe = 1;
  slice.coarse_steps[0] = 2;
  return tress_service_add_slice(self->service, &slice, &self->walk) == TRESS_OK;
}

// The mean weight of draws from a node, which is the mass of its target.
static double mass(const host* self, tress_node node, int pass) {
  double sum = 0;
  for (int i = 0; i < 2000; ++i) {
    const uint64_t key = (uint64_t)pass * 8192 + (uint64_t)i * 4;
    const float u[3] = {hashed(key + 1), hashed(key + 2), hashed(key + 3)};
    tress_value drawn, again;
    if (tress_service_sample(self->service, node, u, &drawn) != TRESS_OK || !drawn.answered) return -1;
    if (tress_service_evaluate(self->service, node, drawn.azimuth, drawn.height, &again) != TRESS_OK) return -1;
    if (drawn.density != again.density || drawn.pdf != again.pdf || !(drawn.pdf > 0)) return -1;
    if (tress_service_credit(self->service, node, 0.5f, 1) != TRESS_OK) return -1;
    sum += (double)(drawn.density / drawn.pdf) / 2000;
  }
  return sum;
}

#define EXPECT(what) \
  if (!(what)) return fprintf(stderr, "line %d: %s; last error: %s\n", __LINE__, #what, tress_last_error()), 1

int main(int count, char** arguments) {
  const char* cache = count > 1 ? arguments[1] : "service.cache";
  remove(cache);
  EXPECT(tress_version() == TRESS_VERSION);
  host first;
  EXPECT(start(&first));
  EXPECT(tress_service_load(first.service, cache) == TRESS_FILE_MISSING && first.failures == 1);
  EXPECT(tress_service_prepare(first.service) == TRESS_OK);
  const tress_node beam = {first.beam, 2, 1}, walk = {first.walk, 2, 2};
  tress_report report;
  double of_beam = 0, of_walk = 0;
  for (int pass = 0; pass < 8; ++pass) {
    of_beam = mass(&first, beam, pass);
    of_walk = mass(&first, walk, pass);
    EXPECT(tress_service_publish(first.service, 4000, &report) == TRESS_OK);
    EXPECT(first.bytes == (int64_t)report.bytes);
  }
  // The standard error of the beam's mean is 0.5/sqrt(2000) = 0.011 for weights in [0, 1]; the walk's has none.
  EXPECT(fabs(of_beam - 0.5) < 0.05 && fabs(of_walk - 0.9) < 1e-3);
  EXPECT(report.queries == 8000 && report.answered_queries == 8000 && report.rows_converged > 0 && report.bytes > 0);
  EXPECT(first.failures == 1 && first.calls_of_progress > 8);
  EXPECT(strstr(tress_service_telemetry(first.service), "\"queries\":8000") != NULL);
  EXPECT(tress_service_save(first.service, cache) == TRESS_OK);

  host second;
  EXPECT(start(&second));
  EXPECT(tress_service_load(second.service, cache) == TRESS_OK);
  tress_value known, loaded;
  EXPECT(tress_service_evaluate(first.service, beam, 0.2f, 0, &known) == TRESS_OK && known.state == TRESS_CONVERGED);
  EXPECT(tress_service_evaluate(second.service, beam, 0.2f, 0, &loaded) == TRESS_OK);
  EXPECT(known.density == loaded.density && loaded.state == TRESS_CONVERGED && loaded.density > 0);
  EXPECT(tress_service_load(second.service, cache) == TRESS_INVALID_CALL);  // rows are in use
  EXPECT(second.failures == 1);
  tress_service_release(first.service);
  tress_service_release(second.service);
  return 0;
}
