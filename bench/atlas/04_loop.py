"""The loop inside a render: 200 passes at epsilon 1e-6, and a camera that keeps touching new rows.

Passes: one picture of a curly lock from near, pass by pass (bench_atlas_loop): CPU time, memory, share of the queries that were
answered by g, and whether every block of samples has the mean that it should. `fitted` is held against `nodes`, the same
program with a table that never learns (same grid, no fit, so that only the loop and the fits can differ; the difference may
be as large as telemetry's bias_bound, and the test is of what exceeds it); `corrected` against `exact`, with no allowance.
The block means of independent seeds give the standard error, pooled over the blocks; all tests together raise a false alarm
in FALSE_ALARM of such studies (Bonferroni, Student's t).

Camera: a turntable in small pictures, one process a frame, all appending to one cache; the second turn has other seeds. Rows,
file, memory, CPU of learning and of starting, share of g; growth over the second turn.
"""
import json
import math
import os

import charts
import numpy

TITLE = "The loop inside a render"
FALSE_ALARM = 0.01
PAIRS = (("fitted, epsilon 1e-6", "nodes"), ("fitted, epsilon .01", "nodes"), ("corrected, epsilon 1e-6", "exact"))
FLAGS = {"fitted, epsilon 1e-6": ("fitted", 1e-6), "fitted, epsilon .01": ("fitted", 1e-2),
         "corrected, epsilon 1e-6": ("corrected", 1e-6), "nodes": ("nodes", 1e-2), "exact": ("exact", 1e-2)}


def student_limit(chance, freedom):
    """|t| that is exceeded with this chance (two sides), by bisection of the integral of the density."""
    scale = math.exp(math.lgamma((freedom + 1) / 2) - math.lgamma(freedom / 2)) / math.sqrt(freedom * math.pi)
    t = numpy.linspace(0, 60, 600001)
    density = scale * (1 + t * t / freedom) ** (-(freedom + 1) / 2)
    inside = 2 * numpy.concatenate([[0], numpy.cumsum((density[1:] + density[:-1]) / 2) * (t[1] - t[0])])
    return float(t[numpy.searchsorted(inside, 1 - chance)])


def block_means(means, blocks):
    """[seed][block] of [seed][sample]."""
    return numpy.array([[part.mean() for part in numpy.array_split(numpy.asarray(one), blocks)] for one in means])


def tests(found, blocks):
    """Every block of every pair: difference, standard error, t, and what was allowed, relative to the mean."""
    result, count = [], len(PAIRS) * blocks
    for learned, against in PAIRS:
        a, b = block_means(found[learned]["means"], blocks), block_means(found[against]["means"], blocks)
        seeds, others = len(a), len(b)
        truth = b.mean()
        spread = (a.var(axis=0, ddof=1).mean() + b.var(axis=0, ddof=1).mean()) / 2  # both estimate the noise of a block
        error = math.sqrt(spread / seeds + spread / (others * blocks))
        allowed = found[learned]["passes"][-1]["bias_bound"] if against == "nodes" else 0.0
        limit = student_limit(FALSE_ALARM / count, (seeds - 1 + others - 1) * blocks)
        off = a.mean(axis=0) / truth - 1
        beyond = numpy.sign(off) * numpy.maximum(abs(off) - allowed, 0) / (error / truth)
        whole_error = math.sqrt(spread / (seeds * blocks) + spread / (others * blocks)) / truth
        result.append({"learned": learned, "against": against, "difference": off.tolist(), "error": error / truth,
                       "allowed": allowed, "t": beyond.tolist(), "limit": limit, "whole": float(off.mean()),
                       "whole_error": whole_error})
    return result


def settings_of(run):
    if run.quick:
        return {"size": "16x20", "samples": 40, "seeds": 2, "blocks": 4, "frames": 6, "false_alarm": FALSE_ALARM}
    return {"size": "32x40", "samples": 200, "seeds": 3, "blocks": 10, "frames": 12, "false_alarm": FALSE_ALARM}


def one_picture(run, settings):
    """{name: what bench_atlas_loop says} of every FLAGS."""
    scene = run.scene("scenes/curly_lock.json")
    # From near and under a sky without a sun: every pixel has hair, and light depends on the direction with little noise.
    small = run.variant(scene, "lock", lambda content: content.update(
        camera={"turntable": {"frames": 1, "distance_cm": 25}, "vertical_fov_deg": 12},
        environment={"sky": {"zenith": [1, 1, 1], "horizon": [0.4, 0.4, 0.4], "ground": [0.05, 0.05, 0.05]}},
        grooms=[{"generate": "curly_lock", "strands": 1000, "radius_cm": 0.012, "material": "blond"}]))
    found = {}
    for name, (estimator, epsilon) in FLAGS.items():
        run.say(f"{settings['samples']} samples, {name}")
        found[name] = json.loads(run.bench("atlas_loop", small, "--size", settings["size"], "--spp", settings["samples"],
                                           "--seeds", settings["seeds"], "--first-seed", 100 * (1 + list(FLAGS).index(name)), "--estimator", estimator,
                                           "--epsilon", epsilon).stdout)
    return found


def moving_camera(run, frames, epsilons=(1e-2, 1e-6)):
    """{name: [what is recorded of each frame]}."""
    turning = run.variant(run.scene("scenes/curly_lock.json"), "turning", lambda content: (
        content.update(camera={"turntable": {"frames": frames}}),
        content["grooms"][0].update(strands=600, radius_cm=0.015)))
    camera = {}
    for epsilon in epsilons:
        name = f"epsilon {epsilon:g}"
        cache = run.path(f"turning_{epsilon:g}.tress")
        if os.path.exists(cache):
            os.remove(cache)
        camera[name] = []
        run.say(f"{2 * frames} frames, {name}")
        for i in range(2 * frames):
            rendered = run.render(turning, "turning", "--frame", i % frames, "--resolution", "30x40", "--spp", 8,
                                  "--model", "elliptical", "--epsilon", epsilon, "--warm-cache", cache, seed=i, threads=1)
            last, summary = rendered.passes[-1], rendered.summary
            camera[name].append({
                "rows": summary["warm_cache"]["rows_saved"], "births": sum(p["births"] for p in rendered.passes),
                "file_bytes": os.path.getsize(cache), "peak_bytes": rendered.peak_bytes, "table_bytes": last["bytes"],
                "g_share": summary["exact_queries"] / max(summary["queries"], 1), "refits": sum(
                    p["refits"] for p in rendered.passes), "open": last["rows"]["open"],
                "learning_cpu": sum(p["learning_cpu_seconds"] for p in rendered.passes),
                "start_and_save_cpu": rendered.cpu - rendered.pass_cpu, "cpu": rendered.cpu})
    return camera


def summed(settings, found, camera):
    """The JSON, of the two parts."""
    frames = settings["frames"]
    block_tests = tests(found, settings["blocks"])
    passes = {name: found[name]["passes"] for name in FLAGS if name not in ("nodes", "exact")}
    growth = {}
    for name, events in passes.items():
        half, x = events[len(events) // 2:], numpy.arange(len(events) // 2, len(events)) + 1
        growth[name] = {key: charts.fit_growth(x, [max(event[key], 1e-9) for event in half])
                        for key in ("learning_cpu", "cpu", "bytes", "rss", "g_share")}
    turn = {}
    for name, events in camera.items():
        x = numpy.arange(frames, 2 * frames) + 1
        turn[name] = {key: charts.fit_growth(x, [max(event[key], 1e-9) for event in events[frames:]])
                      for key in ("rows", "file_bytes", "peak_bytes", "cpu", "start_and_save_cpu")}
    return {"settings": settings,
            "passes": {name: {key: [event[key] for event in events] for key in events[0]} for name, events in
                       passes.items()},
            "rows_against_target": {name: found[name]["rows"] for name in passes}, "growth_of_second_half": growth,
            "block_tests": block_tests, "camera": {name: {key: [event[key] for event in events] for key in events[0]}
                                            for name, events in camera.items()},
            "growth_of_second_turn": turn}


def measure(run):
    settings = settings_of(run)
    return summed(settings, one_picture(run, settings), moving_camera(run, settings["frames"]))


COLORS = {"fitted, epsilon 1e-6": "#d62728", "fitted, epsilon .01": "#1f77b4", "corrected, epsilon 1e-6": "#ff7f0e",
          "epsilon 0.01": "#1f77b4", "epsilon 1e-06": "#d62728"}


def draw(data, path):
    settings = data["settings"]
    chart = charts.Chart(f"{TITLE}: {settings['samples']} samples of {settings['size']} pixels; "
                         f"{2 * settings['frames']} frames of a turning camera on one cache", columns=3, rows=3,
                         width=4.9, height=3.2)
    axes = chart.axes

    def lines(axis, series, key, title, factor=1.0, log=False, x="pass"):
        for name, values in series.items():
            axis.plot(range(len(values[key])), [factor * v for v in values[key]], color=COLORS[name], linewidth=1,
                      label=name)
        axis.set_title(title, fontsize=9)
        axis.set_xlabel(x)
        if log:
            axis.set_yscale("log")
        else:
            axis.set_ylim(bottom=0)

    lines(axes[0], data["passes"], "cpu", "CPU seconds a pass (lower line: learning)", log=True)
    for name, values in data["passes"].items():
        axes[0].plot(range(len(values["learning_cpu"])), [max(v, 1e-4) for v in values["learning_cpu"]], ":",
                     color=COLORS[name], linewidth=1)
    axes[0].legend(fontsize=7)
    lines(axes[1], data["passes"], "bytes", "table, MB (dotted: rows refused, thousands)", 2.0 ** -20)
    for name, values in data["passes"].items():
        axes[1].plot([rows[2] / 1000 for rows in values["rows"]], ":", color=COLORS[name], linewidth=1)
    lines(axes[2], data["passes"], "g_share", "queries answered by g, %", 100)
    axis = axes[3]
    for one in data["block_tests"]:
        axis.plot(range(1, len(one["t"]) + 1), one["t"], "o-", color=COLORS[one["learned"]], markersize=3, linewidth=1,
                  label=f"{one['learned']} against {one['against']}")
    limit = max(one["limit"] for one in data["block_tests"])
    axis.axhspan(-limit, limit, color="#dddddd")
    axis.set_title(f"mean of each block: t (grey: false alarm {settings['false_alarm']:g} of all together)", fontsize=9)
    axis.set_xlabel("block of samples")
    axis.legend(fontsize=7)
    axis = axes[4]
    for one in data["block_tests"]:
        xs = range(1, len(one["t"]) + 1)
        axis.errorbar(xs, [100 * v for v in one["difference"]], 200 * one["error"], color=COLORS[one["learned"]], fmt="o",
                      markersize=3, linewidth=1)
    axis.axhline(0, color="black", linewidth=0.6)
    axis.set_title("difference of the means, %, with two standard errors", fontsize=9)
    axis.set_xlabel("block of samples")
    lines(axes[5], data["camera"], "rows", "rows in the cache", x="frame")
    axes[5].axvline(settings["frames"], color="black", linewidth=0.6)
    axes[5].legend(fontsize=7)
    lines(axes[6], data["camera"], "cpu", "CPU seconds a frame (dotted: start and save)", x="frame")
    for name, values in data["camera"].items():
        axes[6].plot(values["start_and_save_cpu"], ":", color=COLORS[name], linewidth=1)
    lines(axes[7], data["camera"], "peak_bytes", "peak memory, MB (dotted: cache file)", 2.0 ** -20, x="frame")
    for name, values in data["camera"].items():
        axes[7].plot([v / 2 ** 20 for v in values["file_bytes"]], ":", color=COLORS[name], linewidth=1)
    lines(axes[8], data["camera"], "g_share", "queries answered by g, %", 100, x="frame")
    chart.save(path)
