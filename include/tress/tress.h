/* The C interface of tress (C11, C++17): the learning service and the hair BCSDFs behind handles. No type of another
   library is in it, and libtress_c exports these functions alone. tress.hpp wraps it for C++17.

   Life of a session: create a service; add fibers or slices; load a cache; for each pass: any number of threads sample
   and evaluate, then one thread publishes; save; release.

   Thread-safety. Functions marked "any thread" may be called at once, between two publishes. All others, of one service
   and what is made from it: one thread, while no other call runs. The service refuses with TRESS_INVALID_CALL what it
   sees to be at a wrong time, such as a call from inside one of its own callbacks during a publish. What it does not
   see, such as a publish while other threads read, is undefined: check_passes finds more of these. The same calls
   between two publishes, in any order and from any number of threads, give the same table and answers to the bit.

   Errors. No call ends the host or throws. A call that fails returns a code, sets its results to zero (fields of a
   struct that it changes stay), and leaves a sentence in tress_last_error(). Null pointers are allowed everywhere: they
   are refused, or mean what the function says. Numbers that are no numbers are refused, or count as 0 where begin,
   sample and evaluate say "clamped". A handle must not be used after its release. */
#ifndef TRESS_TRESS_H
#define TRESS_TRESS_H

#include <stddef.h>
#include <stdint.h>

#include "tress/version.h" /* TRESS_VERSION, TRESS_VERSION_NUMBER(major, minor, patch) */

#if defined(__GNUC__)
#define TRESS_API __attribute__((visibility("default")))
#else
#define TRESS_API
#endif
#ifdef __cplusplus
#define TRESS_NOTHROW noexcept
#define TRESS_ALIGNED(bytes) alignas(bytes)
extern "C" {
#else
#define TRESS_NOTHROW
#define TRESS_ALIGNED(bytes) _Alignas(bytes)
#endif

typedef enum tress_result {
  TRESS_OK = 0,
  TRESS_INVALID_ARGUMENT = 1, /* a null handle, an id that was not given, a number out of its range */
  TRESS_INVALID_CALL = 2,     /* at a wrong time, or an event of an earlier pass */
  TRESS_FILE_MISSING = 3,     /* there is no file of that name */
  TRESS_FILE_INVALID = 4,     /* a file that is damaged, of another model, or cannot be read or written */
  TRESS_MISUSE = 5,           /* publish ended the pass, and a target failed or a call came at a wrong time */
  TRESS_CANCELLED = 6,        /* publish ended the pass; what the progress callback cut off is learned later */
  TRESS_OUT_OF_MEMORY = 7,
  TRESS_INTERNAL = 8 /* an exception that is a defect of the library */
} tress_result;

/* The version of the compiled library, as TRESS_VERSION is of this header. Equal major and minor versions (while the
   major one is 0) have the same interface. Any thread. */
TRESS_API uint32_t tress_version(void) TRESS_NOTHROW;
/* "TRESS_OK" and so on; "unknown" for other numbers. Static storage; any thread. */
TRESS_API const char* tress_result_name(tress_result result) TRESS_NOTHROW;
/* The reason for the last call of the calling thread that failed, "place: expected X, found Y", at most 1,023 bytes;
   "" if none did. Valid until the thread's next failure. */
TRESS_API const char* tress_last_error(void) TRESS_NOTHROW;

/* ---- The service ------------------------------------------------------------------------------------------------ */

typedef struct tress_service tress_service;

/* The node whose target is asked: what its slice was described by, and the coordinates on the slice's axes. */
typedef struct tress_place {
  uint32_t lobe;
  float parameters[16];
  float a, b;
  float blur; /* radians; of slices of densities */
} tress_place;

/* `weight` of the mass of a node, >= 0, leaves at `azimuth`, radians, any turn. attribute: a value, >= 0, that is
   averaged (hair: the internal path length), or 0. Finite numbers. */
typedef struct tress_ray {
  float azimuth, weight, attribute;
} tress_ray;
/* One exit of a random walk: `weight` of a unit of light leaves at (azimuth, height) as `part`. Height: a place along
   the axis of a cylinder, any finite number. part: less than tress_target::parts. */
typedef struct tress_exit {
  float azimuth, height;
  uint32_t part;
  float weight, attribute;
} tress_exit;

/* Where a callback puts what it has found; valid inside the callback. A null list or null items are ignored. */
typedef struct tress_rays tress_rays;
typedef struct tress_exits tress_exits;
TRESS_API void tress_add_rays(tress_rays* list, const tress_ray* rays, size_t count) TRESS_NOTHROW;
TRESS_API void tress_add_exits(tress_exits* list, const tress_exit* exits, size_t count) TRESS_NOTHROW;

/* Gives the rays of a node. Its density is g(x) = sum of weight G(x - azimuth), G the wrapped Gaussian of the slice's
   blur. A density that is known by its values at n equal steps is n rays of weight g 2 pi/n, with a blur of two steps
   or so. Returns 0 if it failed, else another number. Pure: the same node gives the same rays. Any thread. */
typedef int (*tress_trace_function)(void* user, const tress_place* place, tress_rays* rays);
/* Gives the exits of walks [first, first + count) of a stream, for a target that can only be drawn from. Pure: the same
   arguments give the same exits; streams are independent. Returns as above. Any thread. */
typedef int (*tress_draw_function)(void* user, const tress_place* place, uint64_t stream, uint32_t first,
                                   uint32_t count, tress_exits* exits);

/* What is to be learned. trace, draw or both; a null one means that there are no slices of that kind. */
typedef struct tress_target {
  /* Of what it computes and of the axes, "conductor-1": a cache of another name is refused. 1 to 256 printable ASCII
     characters; copied. */
  const char* name;
  void* user; /* passed to the callbacks */
  tress_trace_function trace;
  tress_draw_function draw;
  uint32_t parts; /* the number of densities of a node of samples, 1 to 4 */
} tress_target;

typedef struct tress_options {
  double epsilon;         /* > 0; relative squared L2 error at which a row of densities has converged */
  double sampled_epsilon; /* > 0; chi-square over mass at which a row of samples has */
  double picture_error;   /* >= 0; replaces both, by the light that is credited; 0: off */
  size_t memory_bytes;    /* limit of the rows and of what is made of them, 0.03 MB a row; beyond it, nodes are
                             answered by their target */
  float heard_share;      /* [0, 1]; largest share of the queries of TRESS_ROUGH at which the fiber is traced, as a
                             test; less where it would make the picture noisier */
  uint64_t seed;
  uint32_t threads;      /* of publish and of what else is parallel inside, at most 4,096; 0, or more than cores: all */
  int learns_to_epsilon; /* whether rows of samples learn until they pass at sampled_epsilon, however often they are
                            queried; 0: by their queries, and sampled_epsilon only decides what counts as converged */
  int check_passes;      /* whether calls at a wrong time are noted, for the development of a host: ten times
                            slower, and rows of samples count other queries, so that their table is another one */
  void* user;            /* passed to the callbacks */
  /* Every failure of a call with this service, by the thread that called, but those of calls that it makes itself.
     May be null, as the others. */
  void (*on_error)(void* user, tress_result result, const char* message);
  void (*on_log)(void* user, const char* sentence); /* what a host may want to log and is no error */
  /* Called inside publish and prepare, by the thread that called those, before each portion of the work; done: the
     share that is done, in [0, 1). If it returns 0, the rest is left for later passes; the pass ends as always. */
  int (*on_progress)(void* user, double done);
  /* Called with every change of tress_report::bytes, so that the sum is that number after each publish, and 0 when the
     service and all fibers on it are released; tress_fibers_bytes() is not in it. post 0: asks before a row is opened.
     If the answer is 0, the row is not counted, and no more rows are opened in this call: their nodes are answered as
     at memory_bytes, and ask again in later passes. post 1: reports what has changed already; the answer is ignored.
     By the thread that adds, loads, prepares, publishes or releases, where it may not use the service. */
  int (*on_memory)(void* user, int64_t bytes, int post);
  /* The host's own tasks, in place of oneTBB's, in publish and prepare: calls task(data, i) for each i below count, on
     any threads, and returns when those calls have returned. The bits of the table stay the same. Called by the thread
     that publishes. tress_fibers_add() goes on to use `threads` of oneTBB. */
  void (*parallel_for)(void* user, size_t count, void (*task)(void* data, size_t i), void* data);
} tress_options;

/* Sets the defaults of every setting. */
TRESS_API void tress_options_init(tress_options* options) TRESS_NOTHROW;
/* A service on a target. options: null for the defaults. On failure *service is null. Any thread. */
TRESS_API tress_result tress_service_create(const tress_target* target, const tress_options* options,
                                            tress_service** service) TRESS_NOTHROW;
/* A service for tress_fibers_create(), of either model or both. */
TRESS_API tress_result tress_service_create_for_fibers(const tress_options* options,
                                                       tress_service** service) TRESS_NOTHROW;
/* Fibers on the service keep what they need. Null is allowed. */
TRESS_API void tress_service_release(tress_service* service) TRESS_NOTHROW;

enum { TRESS_DENSITIES = 0, TRESS_SAMPLES = 1 };

/* A grid of nodes (axis_a[i], axis_b[j]), one row each; axes ascend. Everything is copied. */
typedef struct tress_slice {
  uint32_t kind; /* TRESS_DENSITIES: learned from trace; TRESS_SAMPLES: from draw */
  uint32_t lobe; /* its name, with the parameters; TRESS_DENSITIES: the first three, the others 0 */
  float parameters[16];
  const float *axis_a, *axis_b;
  size_t count_a, count_b; /* 1 to 65,536 */
  float blur;              /* TRESS_DENSITIES: standard deviation of the kernel, radians, > 0 */
  /* TRESS_SAMPLES: coarser grids, of every n-th node and the last of either axis, 0 for none. Rows of the first, the
     coarsest, answer at first; the others are not used. Each a multiple of the next. */
  uint32_t coarse_steps[4];
} tress_slice;

/* All zero, but for a blur of 0.2. */
TRESS_API void tress_slice_init(tress_slice* slice) TRESS_NOTHROW;
/* Adds a slice, or finds the same one. A service for fibers is refused: its slices are those of its fibers. */
TRESS_API tress_result tress_service_add_slice(tress_service* service, const tress_slice* slice,
                                               uint32_t* id) TRESS_NOTHROW;

/* Takes over the rows of a cache file, before the first pass. TRESS_FILE_MISSING is no failure for a first session. */
TRESS_API tress_result tress_service_load(tress_service* service, const char* path) TRESS_NOTHROW;
/* Joins the rows with those that the file has by now, and replaces it, whole or not at all. Any number of sessions may
   save into one file at once. A file that is no cache of this target is left as it is. */
TRESS_API tress_result tress_service_save(tress_service* service, const char* path) TRESS_NOTHROW;
/* Learns the coarsest rows of samples, so that the first pass gets answers. publish does so later. */
TRESS_API tress_result tress_service_prepare(tress_service* service) TRESS_NOTHROW;
/* on: 0 freezes the table (a host's last pass, a farm); else it learns, as it does at first. */
TRESS_API tress_result tress_service_set_learning(tress_service* service, int on) TRESS_NOTHROW;

/* A node of a slice by indices into its axes. */
typedef struct tress_node {
  uint32_t slice, a, b;
} tress_node;

enum { TRESS_ABSENT = 0, TRESS_OPEN = 1, TRESS_CONVERGED = 2, TRESS_REFUSED = 3 };

typedef struct tress_value {
  float azimuth, height; /* the place: radians in [-pi, pi); height 0 for densities */
  float density;         /* of the target, by row or target; 1/rad; for samples the sum of the parts, 1/rad/height */
  float parts[4];        /* for samples, the density of each; otherwise parts[0] is density */
  float pdf;             /* with which sample draws the place, same unit */
  uint32_t state;        /* of the row: TRESS_ABSENT and so on */
  int answered;          /* 0: no row of samples answers here yet; density, parts and pdf are 0 */
} tress_value;

/* Draws a place of a node: density / pdf is the weight. u: three uniforms in [0, 1), clamped; densities use u[0]. Open
   rows learn from it. Where value->answered is 0, draw from the target of samples itself, and pass the walk to
   tress_service_hear(). Any thread. */
TRESS_API tress_result tress_service_sample(const tress_service* service, tress_node node, const float u[3],
                                            tress_value* value) TRESS_NOTHROW;
/* The same values at a place of the host's, finite. Open rows learn from it. Any thread. */
TRESS_API tress_result tress_service_evaluate(const tress_service* service, tress_node node, float azimuth,
                                              float height, tress_value* value) TRESS_NOTHROW;
/* The pdf of evaluate alone; nothing is traced or learned. Any thread. */
TRESS_API tress_result tress_service_pdf(const tress_service* service, tress_node node, float azimuth, float height,
                                         float* pdf) TRESS_NOTHROW;
/* Both for arrays, with the answers of one call for each: three uniforms a node; heights may be null. What is wrong
   with one item does not keep the others from being answered; the result and message are those of the first. */
TRESS_API tress_result tress_service_sample_n(const tress_service* service, const tress_node* nodes, const float* u,
                                              size_t count, tress_value* values) TRESS_NOTHROW;
TRESS_API tress_result tress_service_evaluate_n(const tress_service* service, const tress_node* nodes,
                                                const float* azimuths, const float* heights, size_t count,
                                                tress_value* values) TRESS_NOTHROW;
/* Chooses a node around the place (a, b), by coordinates on the axes, such that the mean over xi of anything is its
   linear interpolation between the nodes. xi: two uniforms, clamped. Any thread. */
TRESS_API tress_result tress_service_choose(const tress_service* service, uint32_t slice, float a, float b,
                                            const float xi[2], tress_node* node) TRESS_NOTHROW;
/* The mean of the values over the nodes that may be chosen: up to four queries. state: TRESS_CONVERGED if all are.
   sample_mean draws from its pdf; u: as for sample, then xi. Any thread. */
TRESS_API tress_result tress_service_mean(const tress_service* service, uint32_t slice, float a, float b, float azimuth,
                                          float height, tress_value* value) TRESS_NOTHROW;
TRESS_API tress_result tress_service_sample_mean(const tress_service* service, uint32_t slice, float a, float b,
                                                 const float u[5], tress_value* value) TRESS_NOTHROW;
/* Reports how much of the picture's light `events` queries of a node stood for: the throughput of their paths times the
   share of the node, >= 0, finite. Rows are created in this order. Any thread. */
TRESS_API tress_result tress_service_credit(const tress_service* service, tress_node node, float light,
                                            uint32_t events) TRESS_NOTHROW;
/* Reports a walk of the host's own, drawn from the target of a node of samples and used in its picture; weight 0 if it
   did not leave. Any thread. */
TRESS_API tress_result tress_service_hear(const tress_service* service, tress_node node,
                                          const tress_exit* exit) TRESS_NOTHROW;

/* What a publish did, and the table after it. */
typedef struct tress_report {
  uint64_t queries;           /* of this pass */
  uint64_t converged_queries; /* those answered by a converged row */
  uint64_t answered_queries;  /* those answered without the target */
  uint64_t rows_open, rows_converged, rows_refused;
  uint64_t bytes;              /* of rows, and of what is made of them */
  int at_ceiling;              /* whether the memory limit holds rows back, or answers had to be made again at each
                                  query, which is slower than no rows: give more memory_bytes */
  double objective_p90;        /* error of the rows, nine in ten are below it */
  double bias_bound;           /* bound of the relative error of the picture's mean; 0 if no light was credited */
  double learning_cpu_seconds; /* of all threads of the process, during this publish */
} tress_report;

/* Ends a pass: tests, fits, publication; parallel inside. paths: the paths of the pass whose light was credited.
   report: may be null. With TRESS_MISUSE and TRESS_CANCELLED the pass has ended, too. */
TRESS_API tress_result tress_service_publish(tress_service* service, uint64_t paths,
                                             tress_report* report) TRESS_NOTHROW;
/* 1 if a publish now would make answers better, for one query in a hundred or more. Ask after each part of the first
   sample, and then after each sample. Any thread, between parts: while others query, the answer depends on them. */
TRESS_API int tress_service_publish_pays(const tress_service* service) TRESS_NOTHROW;
/* Everything about the last publish as one JSON object, with the service's fields of a line of type "pass"
   (adaptive/telemetry/README.md); "" before the first, so also where nothing is published. Valid until the next publish
   or release. */
TRESS_API const char* tress_service_telemetry(const tress_service* service) TRESS_NOTHROW;

/* ---- Fibers ----------------------------------------------------------------------------------------------------- */

typedef struct tress_fibers tress_fibers;

enum { TRESS_ROUGH = 0, TRESS_ELLIPTICAL = 1 };
enum {
  TRESS_FITTED = 0,   /* converged rows answer; the others are traced */
  TRESS_EXACT = 1,    /* always traced, without a service */
  TRESS_CORRECTED = 2 /* TRESS_ELLIPTICAL: unbiased at nearly the cost of fitted; values may be negative */
};
/* Laws of the longitudinal lobes, of equal half width at half maximum for one lambda. */
enum { TRESS_LOGISTIC = 0, TRESS_GAUSSIAN = 1, TRESS_CAUCHY = 2 };

/* A set of fibers of one model. service: made for fibers; null for TRESS_EXACT alone. The service outlives its handle
   where fibers are on it. On failure *fibers is null. */
TRESS_API tress_result tress_fibers_create(tress_service* service, uint32_t model, uint32_t estimator,
                                           tress_fibers** fibers) TRESS_NOTHROW;
TRESS_API void tress_fibers_release(tress_fibers* fibers) TRESS_NOTHROW;

/* Angles are radians; lengths are in major semi-axes of the cross-section; colors are linear RGB. */
typedef struct tress_fiber {
  float eta;          /* index of refraction, [1.05, 3] */
  float eccentricity; /* minor over major semi-axis, [0.5, 1] */
  float roughness;    /* Beckmann slope of the surface, [0.01, 1]; down to 0.001 with all widths given */
  float tilt;         /* of the cuticle, >= 0; R is turned towards the root */
  float sigma_a[3];   /* absorption per major semi-axis, >= 0 */
  float medulla_radius, medulla_scattering, medulla_asymmetry, medulla_absorption; /* TRESS_ROUGH; radius 0: none */
  float cortex_scattering, cortex_asymmetry; /* TRESS_ROUGH; per major semi-axis, [0, 20]; mean cosine */
  float wetness;                             /* TRESS_ROUGH; share of the surface under a film of water, [0, 1] */
  float azimuthal_sigma[3];     /* TRESS_ELLIPTICAL: blur of TT, TRT, TRRT, [0.5, 45] degrees; 0: by the roughness */
  float longitudinal_lambda[4]; /* of R, TT, TRT, TRRT, [0.25, 45] degrees; 0: by the roughness */
  float gain[6][3];             /* artistic factor, 0 to 1e15, of R, TT, TRT, TRRT, the residual, the glint */
  int split_glint;              /* whether the glint is a lobe of its own */
  uint32_t longitudinal_shape;  /* TRESS_ELLIPTICAL: the law of the longitudinal lobes, TRESS_LOGISTIC */
} tress_fiber;

/* Sets the defaults: brown hair. */
TRESS_API void tress_fiber_init(tress_fiber* fiber) TRESS_NOTHROW;
/* Sets fiber->sigma_a so that a lock of these fibers has `color` in even light. Any thread. */
TRESS_API tress_result tress_fiber_set_color(tress_fiber* fiber, const float color[3]) TRESS_NOTHROW;
/* Makes the fiber round and all but smooth, with the widths and the law by which TRESS_ELLIPTICAL looks like the lobes
   of Chiang et al. 2016, which are those of Principled Hair and of pbrt. roughness: longitudinal beta_M;
   radial_roughness: azimuthal beta_N; coat: share of its roughness that R lacks; each in [0, 1]. Any thread. */
TRESS_API tress_result tress_fiber_set_principled(tress_fiber* fiber, float roughness, float radial_roughness,
                                                  float coat) TRESS_NOTHROW;
/* Rounds the shape to one of few (eccentricity 0.01, roughness 1 degree, tilt 0.5 degrees), so that its mean over u,
   uniform in [0, 1)^3, is kept: a host whose shapes vary adds these ahead, and chooses one at each hit. Any thread. */
TRESS_API tress_result tress_fiber_round(tress_fiber* fiber, const float u[3]) TRESS_NOTHROW;
/* Makes a fiber usable; equal parameters give the same id. Takes up to a second for a new shape. On failure *id is
   UINT32_MAX, which no fiber has. */
TRESS_API tress_result tress_fibers_add(tress_fibers* fibers, const tress_fiber* fiber, uint32_t* id) TRESS_NOTHROW;

/* A direction that points away from the fiber: theta in [-pi/2, pi/2] from the normal plane towards the tip, phi in
   [-pi, pi) from the major axis towards the minor one (tangent, major, minor: a right-handed frame). */
typedef struct tress_direction {
  float theta, phi;
} tress_direction;

/* One shading vertex. Plain data that may be copied; valid until the next call that is not "any thread". */
typedef struct tress_event {
  TRESS_ALIGNED(16) unsigned char bytes[480];
} tress_event;

/* All densities are per dtheta dphi: f = value / cos^2 theta_i, solid-angle pdf = pdf / cos theta_i. */
typedef struct tress_fiber_value {
  float value[3]; /* S, 1/rad^2, by channel; finite */
  float pdf;      /* Q, 1/rad^2, with which sample draws the direction, >= 0; 0: black */
} tress_fiber_value;

typedef struct tress_fiber_sample {
  tress_direction direction;
  float weight[3]; /* S/Q by channel: what the throughput is multiplied by; 0 where pdf is 0 */
  tress_fiber_value at;
  uint32_t lobe; /* 0 to 5, as gain has them */
} tress_fiber_sample;

/* Begins an event for the known direction wr, towards the camera. xi1, xi2: uniform in [0, 1), they choose the node for
   every direction of this event. h: [-1, 1], where the ray meets the fiber over its half width, towards rising
   phi, uniform over all rays; TRESS_ROUGH with TRESS_EXACT traces from there, all others have the mean over it.
   importance: luminance of the path's throughput so far, 1 at its first hit; rows are credited with it. Numbers are
   clamped. Any thread. */
TRESS_API tress_result tress_fibers_begin(const tress_fibers* fibers, uint32_t fiber, tress_direction wr, float xi1,
                                          float xi2, float h, float importance, tress_event* event) TRESS_NOTHROW;
/* Draws a direction. u: four independent uniforms in [0, 1), clamped. Any thread. */
TRESS_API tress_result tress_fibers_sample(const tress_fibers* fibers, const tress_event* event, const float u[4],
                                           tress_fiber_sample* sample) TRESS_NOTHROW;
/* The values at a direction of the host's, clamped. Any thread. */
TRESS_API tress_result tress_fibers_evaluate(const tress_fibers* fibers, const tress_event* event, tress_direction wi,
                                             tress_fiber_value* value) TRESS_NOTHROW;
/* The three for arrays, with the answers of one call for each; four uniforms a sample. What is wrong with one item does
   not keep the others from being answered; the result and message are those of the first. Any thread. */
typedef struct tress_vertex {
  uint32_t fiber;
  tress_direction wr;
  float xi1, xi2, h, importance;
} tress_vertex;
TRESS_API tress_result tress_fibers_begin_n(const tress_fibers* fibers, const tress_vertex* vertices, size_t count,
                                            tress_event* events) TRESS_NOTHROW;
TRESS_API tress_result tress_fibers_sample_n(const tress_fibers* fibers, const tress_event* events, const float* u,
                                             size_t count, tress_fiber_sample* samples) TRESS_NOTHROW;
TRESS_API tress_result tress_fibers_evaluate_n(const tress_fibers* fibers, const tress_event* events,
                                               const tress_direction* wi, size_t count,
                                               tress_fiber_value* values) TRESS_NOTHROW;
/* The density alone: the pdf of evaluate, at less cost where that traces. Any thread. */
TRESS_API tress_result tress_fibers_pdf(const tress_fibers* fibers, const tress_event* event, tress_direction wi,
                                        float* pdf) TRESS_NOTHROW;
/* The two for other absorptions than the fiber's, of a texture or by wavelengths: `channels` numbers in sigma_a, >= 0,
   and in s, which gets S, or in weights, which gets S/Q. TRESS_ROUGH alone. The density stays that of the fiber's own
   color, so add fibers whose colors are near. Gains count by their luminance. pdf: may be null. Any thread. */
TRESS_API tress_result tress_fibers_evaluate_spectrum(const tress_fibers* fibers, const tress_event* event,
                                                      tress_direction wi, const float* sigma_a, size_t channels,
                                                      float* s, float* pdf) TRESS_NOTHROW;
TRESS_API tress_result tress_fibers_sample_spectrum(const tress_fibers* fibers, const tress_event* event,
                                                    const float u[4], const float* sigma_a, size_t channels,
                                                    tress_fiber_sample* sample, float* weights) TRESS_NOTHROW;
/* The values without an event, for path connections, reuse and guiding: the mean of evaluate over xi1 and xi2.
   TRESS_CORRECTED gives what TRESS_FITTED gives. pdf 0: not known, where no row answers yet; begin an event then.
   sample_mean draws from its pdf; u: as for sample, then xi1, xi2. Costs some four evaluations. Any thread. */
TRESS_API tress_result tress_fibers_mean(const tress_fibers* fibers, uint32_t fiber, tress_direction wr,
                                         tress_direction wi, tress_fiber_value* value) TRESS_NOTHROW;
TRESS_API tress_result tress_fibers_sample_mean(const tress_fibers* fibers, uint32_t fiber, tress_direction wr,
                                                const float u[6], float importance,
                                                tress_fiber_sample* sample) TRESS_NOTHROW;
/* 1 if lights are to be sampled at this event, weighted against drawn directions by the densities of both; else 0, and
   drawn directions alone find lights. Any thread. */
TRESS_API int tress_fibers_takes_lights(const tress_fibers* fibers, const tress_event* event) TRESS_NOTHROW;
/* Memory of the fibers, without the service's rows. */
TRESS_API size_t tress_fibers_bytes(const tress_fibers* fibers) TRESS_NOTHROW;

#ifdef __cplusplus
}
#endif
#endif
