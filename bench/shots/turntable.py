#!/usr/bin/env python3
"""Whether a turntable flickers where its tables are learned, and what calibration costs by frame and by shot.

usage: /usr/bin/python3 bench/shots/turntable.py [BUILD] [-o FILE] [--frames 24] [--size 32x32] [--spp 16] [--seed 1]

A turntable of straight hair is rendered six times: `exact` twice, with other seeds; cold, each frame by itself; carried, a
warm cache from frame to frame; frozen, by the cache that was carried; and on two machines, two processes at the same time
with half of the frames and a cache each, which are merged. Each frame has a seed of its own.

Flicker: a picture is cut into 4 x 4 blocks, and each block of each frame is divided by that of the second `exact`. How much
that moves from frame to frame, as a variance about its mean over the frames, is noise of both, and flicker. The first
`exact` has noise alone. Variances are added over the blocks, and their ratio is held to the quantile of the F distribution; its
degrees of freedom are those of sums of unequal variances (Satterthwaite 1946). With no flicker it is larger in one of 10,000
runs of all four ways together, as far as means of blocks are normal. Exit status 1 if it is.

Needs python3-openimageio and python3-numpy.
"""
import argparse
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile

import numpy
import OpenImageIO as oiio

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
FALSE_ALARM = 1e-4
BLOCKS = 4
WAYS = ("cold", "carried", "frozen", "two machines")


def scene(frames, environment=None, height_cm=0):
    return {
        "camera": {"turntable": {"frames": frames, "look_at": [0, 0, -9], "distance_cm": 78, "height_cm": height_cm}},
        "image": {"width": 32, "height": 32, "samples": 16},
        "environment": environment or {"studio": True},
        "materials": [{"name": "brown", "eccentricity": 0.85, "roughness": 0.2}],
        "grooms": [{"generate": "straight", "strands": 1200, "radius_cm": 0.025, "material": "brown"}],
    }


def f_quantile(p, n, m):
    """Of F with n and m degrees of freedom: n F/m is tan^2 u, the density of u sin^(n - 1) u cos^(m - 1) u."""
    u = (numpy.arange(1_000_000) + 0.5) * (math.pi / 2 / 1_000_000)
    log_density = (n - 1) * numpy.log(numpy.sin(u)) + (m - 1) * numpy.log(numpy.cos(u))
    below = numpy.cumsum(numpy.exp(log_density - log_density.max()))
    return m / n * math.tan(u[numpy.searchsorted(below, p * below[-1])]) ** 2


def blocks(path):
    """Mean luminance of each block of a picture."""
    picture = oiio.ImageBuf(path)
    names = picture.spec().channelnames
    pixels = picture.get_pixels(oiio.FLOAT)
    y = sum(weight * pixels[..., names.index(c)] for c, weight in zip("RGB", (0.2126, 0.7152, 0.0722)))
    return numpy.array([[part.mean() for part in numpy.array_split(row, BLOCKS, axis=1)]
                        for row in numpy.array_split(y, BLOCKS, axis=0)])


class Renders:
    def __init__(self, program, folder, options):
        self.program, self.folder, self.options = program, folder, options

    def of(self, name):
        return os.path.join(self.folder, name)

    def command(self, name, scene_file, frames, seed, more):
        return [self.program, "render", self.of(scene_file), "-o", self.of(name + ".####.exr"), "--frames", frames,
                "--resolution", self.options.size, "--spp", str(self.options.spp), "--telemetry", self.of(name + ".jsonl"),
                "--layers", "beauty", "--precision", "float", "--seed", str(seed), "--threads", "1", "--quiet", *more]

    def render(self, name, scene_file, frames, seed, more):
        """Frame by frame: of one command all frames would have one seed, and their noise one grain."""
        for frame in frames:
            subprocess.run(self.command(f"{name}.{frame}", scene_file, str(frame), seed * 1000 + frame, more), check=True)

    def pictures(self, name, frames):
        return numpy.array([blocks(self.of(f"{name}.{frame}.{frame:04d}.exr")) for frame in frames])

    def costs(self, name, frame):
        with open(self.of(f"{name}.{frame}.jsonl")) as lines:
            passes = [line for line in map(json.loads, lines) if line["type"] == "pass"]
        return {"learning_cpu_seconds": sum(one["learning_cpu_seconds"] for one in passes),
                "cpu_seconds": sum(one["cpu_seconds"] for one in passes),
                "first_pass_share": passes[0]["converged_query_share"],
                "rows_converged": passes[-1]["rows"]["converged"]}


def mean_costs(all_costs):
    return {key: sum(costs[key] for costs in all_costs) / len(all_costs) for key in all_costs[0]}


def turntable(renders, frames, seed):
    half = len(frames) // 2
    cache = lambda name: ["--warm-cache", renders.of(name + ".cache")]
    renders.render("exact", "turn.json", frames, seed + 1, ["--estimator", "exact"])
    renders.render("reference", "turn.json", frames, seed + 2, ["--estimator", "exact"])
    renders.render("cold", "turn.json", frames, seed + 3, [])
    renders.render("carried", "turn.json", frames, seed + 4, cache("carried"))
    renders.render("frozen", "turn.json", frames, seed + 5, cache("carried") + ["--cache-mode", "frozen"])
    machines = []
    for number, part in enumerate((frames[:half], frames[half:])):
        child = os.fork()
        if child == 0:
            try:
                renders.render("two machines", "turn.json", part, seed + 6, cache(f"machine{number}"))
                os._exit(0)
            finally:
                os._exit(1)
        machines.append(child)
    for child in machines:
        if os.waitpid(child, 0)[1] != 0:
            sys.exit("one of the two machines failed")
    subprocess.run([renders.program, "cache", "merge", renders.of("machine0.cache"), renders.of("machine1.cache"), "-o",
                    renders.of("merged.cache")], check=True, capture_output=True)
    renders.render("merged", "turn.json", frames[:1], seed + 7, cache("merged") + ["--cache-mode", "frozen"])

    reference = renders.pictures("reference", frames)
    lit = reference.mean(axis=0) > 0.01 * reference.mean()

    def moves(name):
        ratio = renders.pictures(name, frames) / reference - 1
        return ratio.var(axis=0, ddof=1)[lit], float(ratio.mean(axis=0)[lit].mean())

    of_exact, of_one = moves("exact")[0], len(frames) - 1
    noise = float(of_exact.sum())
    # The mean of a squared variance is 1 + 2/n of the square of its own.
    degrees = max(of_one, int(of_one * noise ** 2 / float((of_exact ** 2).sum()) * (1 + 2 / of_one)))
    degrees = min(degrees, of_one * len(of_exact))
    limit = f_quantile(1 - FALSE_ALARM / len(WAYS), degrees, degrees)
    found = {"degrees_of_freedom": degrees, "limit": limit, "false_alarm": FALSE_ALARM,
             "noise_of_a_block": math.sqrt(noise / int(lit.sum())), "ways": {}}
    for name in WAYS:
        variances, brighter = moves(name)
        ratio = float(variances.sum()) / noise
        # Two standard deviations of a ratio of two variances of so many degrees of freedom.
        most = max(0.0, ratio + 2 * ratio * math.sqrt(4 / degrees) - 1)
        found["ways"][name] = {"variance_over_noise": ratio, "brighter": brighter,
                               "flicker_at_most": math.sqrt(most * noise / int(lit.sum())),
                               "first_frame": renders.costs(name, frames[0]),
                               "later_frames": mean_costs([renders.costs(name, frame) for frame in frames[1:]])}
    found["merged"] = renders.costs("merged", frames[0])
    return found


def three_shots(renders, seed):
    """One groom: another camera and frame, another light. Each cold and by the cache of those before."""
    shots = [("turn.json", 0), ("above.json", 7), ("sun.json", 13)]
    found = []
    for number, (scene_file, frame) in enumerate(shots):
        renders.render(f"shot{number}", scene_file, [frame], seed + 8, [])
        renders.render(f"warm{number}", scene_file, [frame], seed + 8, ["--warm-cache", renders.of("shots.cache")])
        found.append({"shot": scene_file[:-5], "cold": renders.costs(f"shot{number}", frame),
                      "by_the_shots_before": renders.costs(f"warm{number}", frame)})
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?", default=os.path.join(ROOT, "build", "release"))
    parser.add_argument("-o", "--output", default=os.path.join(ROOT, "bench", "results", "turntable.json"))
    parser.add_argument("--frames", type=int, default=24)
    parser.add_argument("--size", default="32x32")
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    folder = tempfile.mkdtemp(prefix="tress_turntable_")
    renders = Renders(os.path.join(os.path.abspath(options.build), "tress"), folder, options)
    sun = {"constant": [0.3, 0.35, 0.4]}
    for name, content in {"turn": scene(options.frames), "above": scene(options.frames, height_cm=40),
                          "sun": scene(options.frames, environment=sun)}.items():
        with open(renders.of(name + ".json"), "w") as file:
            json.dump(content, file)
    git = subprocess.run(["git", "-C", ROOT, "rev-parse", "HEAD"], capture_output=True, text=True)
    found = {"context": {"commit": git.stdout.strip(), "load": os.getloadavg()[0]}, "frames": options.frames,
             "size": options.size, "samples": options.spp, "seed": options.seed,
             "turntable": turntable(renders, list(range(options.frames)), 10 * options.seed),
             "shots": three_shots(renders, 10 * options.seed)}
    shutil.rmtree(folder)
    with open(options.output, "w") as out:
        json.dump(found, out, indent=1)
        out.write("\n")
    print(json.dumps(found, indent=1))
    worst = max(way["variance_over_noise"] for way in found["turntable"]["ways"].values())
    sys.exit(1 if worst > found["turntable"]["limit"] else 0)


if __name__ == "__main__":
    main()
