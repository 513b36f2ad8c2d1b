"""Do 500 renders on one cache creep in memory, bytes, time or error?

Short renders of changing shots (grooms, frames of a turning camera, materials of eight pages' shapes, colors that never come
back, resolutions, seeds) append to one warm cache, a process each. Recorded of each: CPU time, peak memory, bytes of the file,
rows, share of the queries answered by tracing. Every tenth is one of two probes, held against its own picture by `exact`; at
checkpoints every converged row of the file is held against its target (bench_atlas_loop --table). Creep is the slope of the
second half, by least squares, with twice its standard error. The first shots again with 1, 2 and 8 threads in turn must leave
the same bytes and pixels. Then a cache gets a new material with every shot, which is what makes it grow. Last, one process
lives through loading, rendering, saving and destroying many times (bench_atlas_soak): what it holds must not grow; the
allocator keeps no freed blocks aside meanwhile, which would count as held.
"""
import json
import os
import shutil

import charts
import figures
import numpy

TITLE = "Soak: short renders on one cache"
SHAPES = [(e, r) for e in (0.75, 0.85, 0.9, 1.0) for r in (0.2, 0.3)]
KINDS = ("curly_lock", "wavy", "straight", "curly")
SIZES = ("16x20", "20x26", "24x32")
PROBE_EVERY, CHECK_EVERY, PROBE_SPP = 10, 50, 8


def write(path, content):
    with open(path, "w") as file:
        json.dump(content, file)
    return path


def scene_of(kind, material):
    return {"camera": {"turntable": {"frames": 24}}, "image": {"samples": 4}, "environment": {"studio": True},
            "environment_visible": False, "materials": [{"name": "hair", **material}],
            "grooms": [{"generate": kind, "strands": 150, "radius_cm": 0.05, "material": "hair"}]}


def material_of(shape, i):
    color = 0.2 + 1.5 * ((i * 0.6180339887) % 1)
    return {"eccentricity": SHAPES[shape][0], "roughness": SHAPES[shape][1], "melanin": {"eumelanin": round(color, 6)}}


def shot(run, i):
    """(scene file, flags, seed) of render i; a probe (0 or 1) every tenth."""
    if i % PROBE_EVERY == PROBE_EVERY - 1:
        which = i // PROBE_EVERY % 2
        path = write(run.path(f"probe_{which}.json"), scene_of(KINDS[which], material_of(3 * which, which)))
        return path, ["--resolution", "24x32", "--frame", 5 * which, "--spp", PROBE_SPP], i, which
    draw = numpy.random.default_rng(1000 + i)  # its own, so that a part of the sequence is the same
    path = write(run.path("shot.json"), scene_of(KINDS[draw.integers(4)], material_of(draw.integers(8), i)))
    flags = ["--resolution", SIZES[draw.integers(3)], "--frame", int(draw.integers(24))]
    return path, flags, i, None


def pixels_of(path):
    return figures.read(path).tobytes()


def sequence(run, name, many, threads_of, each):
    """Renders `many` shots on a new cache; each(i, rendered, cache, probe)."""
    cache = run.path(name + ".tress")
    for old in (cache, cache + ".lock"):
        if os.path.exists(old):
            os.remove(old)
    for i in range(many):
        path, flags, seed, probe = shot(run, i)
        # A name of its own: the reader of pictures keeps them by name, and may miss one that is replaced within a second.
        rendered = run.render(path, f"{name}_{i}", *flags, "--model", "elliptical", "--warm-cache", cache, seed=seed,
                              threads=threads_of(i))
        each(i, rendered, cache, probe)
        for ending in (".exr", ".png", ".jsonl"):
            os.remove(run.path(f"{name}_{i}{ending}"))


def slope(xs, ys):
    """Least squares of ys/mean over xs in units of the range of xs: change along it and twice its standard error."""
    x, y = numpy.asarray(xs, float), numpy.asarray(ys, float)
    scale = abs(y.mean()) or 1.0
    x = (x - x.mean()) / max(x.max() - x.min(), 1)
    b = (x * y).sum() / (x * x).sum()
    rest = y - y.mean() - b * x
    error = (rest ** 2).sum() / max(len(x) - 2, 1) / (x * x).sum()
    return {"mean": float(y.mean()), "change": float(b / scale), "twice_error": float(2 * error ** 0.5 / scale)}


def new_materials(run, many):
    """A cache that meets another material with every shot: what is recorded after each."""
    run.say(f"{many} materials on one cache")
    growth = []
    cache = run.path("materials.tress")
    if os.path.exists(cache):
        os.remove(cache)
    for i in range(many):
        material = {"eccentricity": round(0.99 - 0.01 * i, 2), "roughness": 0.25, "melanin": {"eumelanin": 1}}
        path = write(run.path("material.json"), scene_of("wavy", material))
        rendered = run.render(path, "material", "--resolution", "24x32", "--model", "elliptical", "--warm-cache", cache, seed=i, threads=1)
        growth.append({"materials": i + 1, "file_bytes": os.path.getsize(cache), "peak_bytes": rendered.peak_bytes,
                       "outside_passes_cpu": rendered.cpu - rendered.pass_cpu})
    return growth


def summed(recorded, probes, checks, references, same, growth, one_process):
    """The JSON. references: mean and its standard error, of each probe."""
    many = len(recorded["cpu"])
    names = list(recorded)
    half = many // 2
    at = list(range(half, many))
    plain = [i for i in at if i % PROBE_EVERY != PROBE_EVERY - 1]
    creep = {name: slope(plain, [recorded[name][i] for i in plain]) for name in names if name != "paths"}
    creep["cpu_a_path"] = slope(plain, [recorded["cpu"][i] / recorded["paths"][i] for i in plain])
    creep["probe_noise"] = slope([p["render"] for p in probes], [p["noise"] for p in probes])
    bias = numpy.array([p["bias"] for p in probes])
    x = numpy.array([p["render"] for p in probes], float)
    x = (x - x.mean()) / max(x.max() - x.min(), 1)
    b = (x * bias).sum() / (x * x).sum()
    rest = bias - bias.mean() - b * x
    error = ((rest ** 2).sum() / max(len(x) - 2, 1) / (x * x).sum()) ** 0.5
    reference_error = max(error / mean for mean, error in references)
    creep["probe_bias"] = {"mean": float(bias.mean()), "change": float(b), "twice_error": float(2 * error),
                           "twice_error_of_mean": float(2 * ((bias.std(ddof=1) ** 2 / len(bias)) +
                                                             reference_error ** 2) ** 0.5)}
    return {"settings": {"renders": many, "strands": 150, "samples": 4, "materials": len(SHAPES)},
            "renders": recorded, "probes": probes, "rows_against_target": checks, "same_again": same, "materials": growth,
            "one_process": one_process, "creep_of_the_second_half": creep}


def measure(run):
    many = 30 if run.quick else 500
    again = 12 if run.quick else 100
    lives = 12 if run.quick else 500
    reference_spp = 64 if run.quick else 512
    check = 10 if run.quick else CHECK_EVERY

    run.say("references of the probes")
    references = []
    for which in (0, 1):
        path, flags, _, _ = shot(run, PROBE_EVERY * (which + 1) - 1)
        flags = flags[:-1] + [reference_spp]
        exact = [run.render(path, f"exact_{which}_{k}", *flags, "--model", "exact", seed=90_000 + k, threads=1)
                 for k in range(4)]
        pictures = [figures.read(one.picture).astype(numpy.float64) for one in exact]
        references.append({"mean": float(numpy.mean(pictures)), "pixels": numpy.mean(pictures, axis=0),
                           "error": float(numpy.std([p.mean() for p in pictures], ddof=1) / 2)})

    run.say(f"{many} renders on one cache")
    names = ("cpu", "learning_cpu", "peak_bytes", "file_bytes", "table_bytes", "rows", "open", "g_share", "paths")
    recorded = {name: [] for name in names}
    probes, checks, keeps = [], [], {}

    def one(i, rendered, cache, probe):
        last = rendered.passes[-1]
        queries, exact = rendered.summary["queries"], rendered.summary["exact_queries"]
        for name, value in (("cpu", rendered.cpu), ("peak_bytes", rendered.peak_bytes),
                            ("learning_cpu", sum(p["learning_cpu_seconds"] for p in rendered.passes)),
                            ("file_bytes", os.path.getsize(cache)), ("table_bytes", last["bytes"]),
                            ("rows", rendered.summary["warm_cache"]["rows_saved"]), ("open", last["rows"]["open"]),
                            ("g_share", exact / max(queries, 1)), ("paths", last["samples"])):
            recorded[name].append(value)
        if probe is not None:
            picture = figures.read(rendered.picture).astype(numpy.float64)
            truth = references[probe]
            probes.append({"render": i, "probe": probe, "bias": float(picture.mean() / truth["mean"] - 1),
                           "noise": float(((picture - truth["pixels"]) ** 2).mean() ** 0.5 / truth["mean"])})
        if i < again:
            keeps[i] = (pixels_of(rendered.picture), charts.content_hash(cache))
        if (i + 1) % check == 0:
            copy = run.path(f"checkpoint_{i + 1}.tress")
            shutil.copy(cache, copy)
            truth = json.loads(run.bench("atlas_loop", "--table", copy, "--epsilon", 0.01).stdout)
            checks.append({"renders": i + 1, **truth})
            run.say(f"{i + 1}: {recorded['rows'][-1]} rows, {recorded['file_bytes'][-1]} bytes, {truth}")

    sequence(run, "soak", many, lambda i: 1, one)

    run.say(f"the first {again} again, with 1, 2 and 8 threads in turn")
    same = {"renders": again, "other_pixels": 0, "other_bytes": 0}

    def compare(i, rendered, cache, _):
        pixels, bytes_hash = keeps[i]
        same["other_pixels"] += pixels_of(rendered.picture) != pixels
        same["other_bytes"] += charts.content_hash(cache) != bytes_hash

    sequence(run, "again", again, lambda i: (8, 2, 1)[i % 3], compare)

    growth = new_materials(run, 6 if run.quick else 20)

    run.say(f"{lives} lives in one process")
    path, _, _, _ = shot(run, PROBE_EVERY - 1)
    one_process = json.loads(run.bench(
        "atlas_soak", path, "--lives", lives, environment={"GLIBC_TUNABLES": "glibc.malloc.tcache_count=0"}).stdout)

    return summed(recorded, probes, checks, [(one["mean"], one["error"]) for one in references], same, growth, one_process)


def draw(data, path):
    chart = charts.Chart(f"{TITLE}: {data['settings']['renders']} renders, {data['settings']['materials']} materials",
                         columns=3, rows=2, width=4.9, height=3.5)
    recorded, n = data["renders"], len(data["renders"]["cpu"])
    creep = data["creep_of_the_second_half"]

    def trend(axis, ys, name, unit, color):
        axis.plot(range(1, n + 1), ys, ".", markersize=2, color=color, alpha=0.4)
        width = max(1, n // 25)
        blocks = [sum(ys[i:i + width]) / width for i in range(0, n - width + 1, width)]
        axis.plot([width * (i + 0.5) for i in range(len(blocks))], blocks, color=color)
        if name in creep:
            c = creep[name]
            axis.set_title(f"{unit}: second half {100 * c['change']:+.1f} +- {100 * c['twice_error']:.1f} %", fontsize=9)
        axis.set_ylim(bottom=0)
        axis.set_xlabel("render")

    trend(chart.axes[0], recorded["cpu"], "cpu", "CPU seconds a render", "#d62728")
    chart.axes[0].plot(range(1, n + 1), recorded["learning_cpu"], ".", markersize=2, color="#1f77b4")
    chart.axes[0].text(0.98, 0.12, "blue: learning", transform=chart.axes[0].transAxes, ha="right", fontsize=8,
                       color="#1f77b4")
    trend(chart.axes[1], [b / 2 ** 20 for b in recorded["peak_bytes"]], "peak_bytes", "peak memory, MB", "#9467bd")
    trend(chart.axes[2], [b / 1024 for b in recorded["file_bytes"]], "file_bytes", "cache file, KB", "#2ca02c")
    trend(chart.axes[3], [100 * s for s in recorded["g_share"]], "g_share", "queries traced, %", "#ff7f0e")
    axis = chart.axes[4]
    for probe, marker in ((0, "o"), (1, "s")):
        mine = [p for p in data["probes"] if p["probe"] == probe]
        axis.plot([p["render"] for p in mine], [100 * p["bias"] for p in mine], marker, markersize=3,
                  label=f"probe {probe}: mean against exact, %")
    axis.axhline(0, color="black", linewidth=0.6)
    c = creep["probe_bias"]
    axis.set_title(f"error: mean {100 * c['mean']:+.2f} +- {100 * c['twice_error_of_mean']:.2f} %, "
                   f"trend {100 * c['change']:+.2f} +- {100 * c['twice_error']:.2f} %", fontsize=9)
    axis.legend(fontsize=7)
    axis.set_xlabel("render")
    axis = chart.axes[5]
    materials = [g["materials"] for g in data["materials"]]
    axis.plot(materials, [g["file_bytes"] / 1024 for g in data["materials"]], color="#2ca02c", label="file, KB")
    axis.plot(materials, [g["peak_bytes"] / 2 ** 20 for g in data["materials"]], color="#9467bd", label="memory, MB")
    axis.set_title("a new material with every shot", fontsize=9)
    axis.set_xlabel("materials that the cache has met")
    axis.set_ylim(bottom=0)
    axis.legend(fontsize=8)
    same = data["same_again"]
    chart.figure.text(0.5, 0.005, f"{same['renders']} renders again with 1, 2 and 8 threads: {same['other_pixels']} other "
                      f"pictures, {same['other_bytes']} other caches. One process, {len(data['one_process']['rss_bytes'])} "
                      f"lives: heap {data['one_process']['heap_change_bytes']:+d} bytes over the second half",
                      ha="center", fontsize=8)
    chart.save(path)
