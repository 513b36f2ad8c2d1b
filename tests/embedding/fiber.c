// A clear fiber in a furnace, light of 1 from everywhere: it must look like 1. Its rows are kept in a cache.
#include <stdio.h>

#include "tress/tress.h"

static float next(uint64_t* state) {  // uniform in [0, 1): the host's own random numbers
  *state = *state * 6364136223846793005u + 1442695040888963407u;
  return (float)(*state >> 40) / 16777216.0f;
}

static void print(void* user, tress_result result, const char* message) {
  fprintf((FILE*)user, "%s: %s\n", tress_result_name(result), message);
}

int main(int count, char** arguments) {
  const char* cache = count > 1 ? arguments[1] : "fiber.cache";
  tress_options options;
  tress_options_init(&options);
  options.on_error = print;
  options.user = stderr;
  tress_service* service = NULL;
  tress_fibers* fibers = NULL;
  tress_fiber hair;
  tress_fiber_init(&hair);
  hair.sigma_a[0] = hair.sigma_a[1] = hair.sigma_a[2] = 0;  // clear; see tress_fiber_set_color()
  uint32_t id = 0;
  float mean = 0;
  if (tress_service_create_for_fibers(&options, &service) == TRESS_OK &&
      tress_fibers_create(service, TRESS_ROUGH, TRESS_FITTED, &fibers) == TRESS_OK &&
      tress_fibers_add(fibers, &hair, &id) == TRESS_OK) {
    tress_service_load(service, cache);     // TRESS_FILE_MISSING in the first session
    tress_service_prepare(service);         // so that the first pass gets answers
    for (int pass = 0; pass < 4; ++pass) {  // short passes at first: rows are learned between them
      uint64_t random = 7 + (uint64_t)pass;
      const int events = 500 << pass;
      mean = 0;
      for (int i = 0; i < events; ++i) {  // any number of threads
        const tress_direction to_camera = {0.3f, 0.8f}, to_light = {-0.2f, -2.2f};
        const float xi1 = next(&random), xi2 = next(&random), h = 2 * next(&random) - 1, importance = 1;
        const float u[4] = {next(&random), next(&random), next(&random), next(&random)};
        tress_event event;
        tress_fiber_sample drawn;
        tress_fiber_value lit;
        tress_fibers_begin(fibers, id, to_camera, xi1, xi2, h, importance, &event);
        tress_fibers_sample(fibers, &event, u, &drawn);  // go on in drawn.direction, throughput times drawn.weight
        if (tress_fibers_takes_lights(fibers, &event)) tress_fibers_evaluate(fibers, &event, to_light, &lit);
        mean += drawn.weight[1] / (float)events;
      }
      tress_service_publish(service, (uint64_t)events, NULL);  // one thread
      printf("pass %d: furnace %.3f\n", pass, (double)mean);
    }
    printf("%s\n", tress_service_telemetry(service));
    tress_service_save(service, cache);
  }
  tress_fibers_release(fibers);
  tress_service_release(service);
  return mean > 0.98f && mean < 1.02f ? 0 : 1;
}
