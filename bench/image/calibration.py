#!/usr/bin/env python3
"""What calibrating costs: a cold render beside a warm one and beside one without rows, to equal noise.

usage: bench/image/calibration.py [BUILD] [-o FILE] [--spp N]... [--seeds N] [--size N] [--only SCENE]... [--model NAME]
                                  [--no-off]

Each way renders the same seeds, in turns, on one thread: `cold` starts with an empty table; `warm` with the cache of a cold
render of another seed; `second` with the cache of another shot: another camera, half the eumelanin; `off` has no rows
(--table-memory 0). CPU is of the whole process, less that of a render of 2 x 2
pixels without rows, which builds strands, tree and energy tables. Two measures of noise: `pixel`, the variance that the
picture reports; `blocks`, the mean over seeds of the squared difference of 8 x 8 blocks from the mean of the other ways and seeds,
over the squared mean brightness. Printed: CPU x noise^2 over that of `warm`, with the standard error over seeds. What is
measured is added to FILE, where it takes the place of the same scene and samples; FILE.png is drawn of all that is there.
"""
import argparse
import json
import os
import resource
import statistics
import subprocess
import tempfile

import numpy
import OpenImageIO

from sources import ROOT, source_of

SCENES = ("demo", "curly_lock", "fur_ball", "varied", "wavy")
WAYS = ("cold", "warm", "second", "off")  # off: ten times the time, which --no-off spares


def cpu_of(command):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def blocks_of(file):
    buffer = OpenImageIO.ImageBuf(file)
    names = list(buffer.spec().channelnames)
    pixels = buffer.get_pixels(OpenImageIO.FLOAT)[:, :, [names.index(c) for c in "RGB"]].mean(axis=2)
    height, width = (n // 8 * 8 for n in pixels.shape)
    return pixels[:height, :width].reshape(height // 8, 8, width // 8, 8).mean(axis=(1, 3))


class Measured:
    def __init__(self):
        self.cpu, self.variance, self.blocks, self.learning = [], [], [], []

    def add(self, cpu, telemetry, picture):
        passes = [line for line in map(json.loads, open(telemetry)) if line["type"] == "pass"]
        self.cpu.append(cpu)
        self.variance.append(passes[-1]["noise"] ** 2)
        self.learning.append(sum(one["learning_cpu_seconds"] for one in passes))
        self.blocks.append(blocks_of(picture))


def ratio(a, b):
    """The ratio of two means and its standard error, from pairs of equal seeds."""
    value = statistics.mean(a) / statistics.mean(b)
    if len(a) < 2:
        return {"value": value, "error": None}
    off = [x / statistics.mean(b) - value * y / statistics.mean(b) for x, y in zip(a, b)]
    return {"value": value, "error": statistics.stdev(off) / len(a) ** 0.5}


def other_shot(source, folder):
    """The scene from another side, with half the eumelanin."""
    with open(source) as file:
        scene = json.load(file)
    fov = scene["camera"].get("vertical_fov_deg", 30)
    scene["camera"] = {"turntable": {"frames": 7}, "vertical_fov_deg": fov}
    for material in scene["materials"]:
        material["melanin"]["eumelanin"] *= 0.5
    for mesh in scene.get("meshes", []):
        mesh["file"] = os.path.join(os.path.dirname(source), mesh["file"])
    path = os.path.join(folder, os.path.basename(source))
    with open(path, "w") as file:
        json.dump(scene, file)
    return path


def measure(program, scene, spp, options, folder):
    source = source_of(f"scenes/{scene}.json")
    common = [program, "render", source, "--resolution", f"{options.size}x{options.size}", "--spp", str(spp), "--threads", "1"]
    common += ["--model", options.model] if options.model else []
    cache = os.path.join(folder, f"{scene}_{spp}.cache")
    picture, telemetry = os.path.join(folder, "a.exr"), os.path.join(folder, "a.jsonl")
    shot = os.path.join(folder, f"{scene}_{spp}_other.cache")
    flags = {"cold": [], "warm": ["--warm-cache", cache], "second": ["--warm-cache", shot], "off": ["--table-memory", "0"]}
    subprocess.run([*common, "-o", picture, "--seed", "1000", "--warm-cache", cache], check=True, capture_output=True)
    other = [program, "render", other_shot(source, folder), *common[3:], "--frame", "1"]
    subprocess.run([*other, "-o", picture, "--seed", "1000", "--warm-cache", shot], check=True, capture_output=True)
    ground = [program, "render", source, "--resolution", "2x2", "--spp", "1", "--threads", "1", "--table-memory", "0", "-o", picture]
    ways = tuple(way for way in WAYS if way != "off" or not options.no_off)
    measured = {way: Measured() for way in ways}
    start = min(cpu_of(ground) for _ in range(2))
    made = {file: open(file, "rb").read() for file in (cache, shot)}
    for seed in range(options.seeds):
        for way in ways:
            for file, content in made.items():  # a render adds to its cache
                open(file, "wb").write(content)
            cpu = cpu_of([*common, *flags[way], "-o", picture, "--seed", str(seed), "--telemetry", telemetry])
            measured[way].add(cpu - start, telemetry, picture)
    reference = numpy.mean([block for way in ways for block in measured[way].blocks], axis=0)
    brightness = float(reference.mean()) ** 2
    count = len(ways) * options.seeds
    found = {"scene": scene, "spp": spp, "startup": start}
    for way, one in measured.items():
        # The mean holds the picture itself: without it the difference is count/(count - 1) times as large.
        one.errors = [float(((block - reference) ** 2).mean()) / brightness * (count / (count - 1)) ** 2 for block in one.blocks]
        found[way] = {"cpu": statistics.mean(one.cpu), "noise": statistics.mean(one.variance) ** 0.5,
                      "learning_cpu": statistics.mean(one.learning), "block_error": statistics.mean(one.errors) ** 0.5}
    for way in ways:
        if way == "warm":
            continue
        one, warm = measured[way], measured["warm"]
        found[f"{way}_over_warm"] = {
            "cpu": ratio(one.cpu, warm.cpu),
            "pixel": ratio([c * v for c, v in zip(one.cpu, one.variance)], [c * v for c, v in zip(warm.cpu, warm.variance)]),
            "blocks": ratio([c * e for c, e in zip(one.cpu, one.errors)], [c * e for c, e in zip(warm.cpu, warm.errors)])}
    return found


def draw(found, path):
    """Cold over warm by samples, a line a scene, by both measures; beside it what renders without rows cost."""
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    panels = [("cold", "pixel", "Cold over warm, pixels"), ("cold", "blocks", "Cold over warm, blocks of 8 x 8"),
              ("off", "pixel", "Without rows over warm, pixels")]
    panels = [panel for panel in panels if any(f"{panel[0]}_over_warm" in one for one in found)]
    figure, axes = pyplot.subplots(1, len(panels), figsize=(4 * len(panels), 3.6), squeeze=False)
    axes = axes[0]
    for axis, (way, measure, title) in zip(axes, panels):
        for index, scene in enumerate(SCENES):
            ones = [one for one in found if one["scene"] == scene and f"{way}_over_warm" in one]
            ratios = [one[f"{way}_over_warm"][measure] for one in ones]
            if ones:
                axis.errorbar([one["spp"] * 1.04 ** (index - 2) for one in ones], [r["value"] for r in ratios],
                              [r["error"] or 0 for r in ratios], marker="o", markersize=3, linewidth=1.2, capsize=2, label=scene)
        axis.axhline(1, color="#888888", linewidth=0.8)
        axis.set_xscale("log", base=2)
        axis.set_xticks([2, 4, 16, 64], ["2", "4", "16", "64"])
        axis.set_xlabel("samples a pixel")
        axis.set_title(title, fontsize=9)
        if way == "off":
            axis.set_yscale("log")
    axes[0].set_ylabel("CPU x noise^2, relative")
    axes[0].legend(fontsize=7, frameon=False)
    figure.tight_layout()
    figure.savefig(path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?", default=os.path.join(ROOT, "build", "release"))
    parser.add_argument("-o", "--output", default=os.path.join(ROOT, "bench", "results", "calibration.json"))
    parser.add_argument("--spp", type=int, action="append")
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--size", type=int, default=160)
    parser.add_argument("--only", action="append", choices=SCENES)
    parser.add_argument("--model")
    parser.add_argument("--no-off", action="store_true", help="no renders without rows")
    options = parser.parse_args()
    if min(options.spp or [4]) < 2:
        parser.error("--spp: expected 2 or more, which noise is estimated from")
    program = os.path.join(os.path.abspath(options.build), "tress")
    git = subprocess.run(["git", "-C", ROOT, "rev-parse", "HEAD"], capture_output=True, text=True)
    context = {"commit": git.stdout.strip(), "load": os.getloadavg()[0], "seeds": options.seeds, "size": options.size}
    found = []
    if os.path.exists(options.output):
        with open(options.output) as stored:
            found = json.load(stored)["found"]
    with tempfile.TemporaryDirectory() as folder:
        for scene in options.only or SCENES:
            for spp in options.spp or (4, 16, 64):
                one = measure(program, scene, spp, options, folder)
                one["context"] = {**context, "load": os.getloadavg()[0]}
                found = [old for old in found if (old["scene"], old["spp"]) != (scene, spp)] + [one]
                found.sort(key=lambda any: (SCENES.index(any["scene"]), any["spp"]))
                text = ", ".join(f"{way} {measure} {one[f'{way}_over_warm'][measure]['value']:.2f}"
                                 + (f" +- {one[f'{way}_over_warm'][measure]['error']:.2f}" if options.seeds > 1 else "")
                                 for way in WAYS if f"{way}_over_warm" in one for measure in ("pixel", "blocks"))
                print(f"{scene:12} {spp:3} samples: warm {one['warm']['cpu']:.2f} s; {text}; learning {one['cold']['learning_cpu']:.3f} s", flush=True)
                with open(options.output, "w") as out:
                    json.dump({"context": context, "found": found}, out, indent=1)
                    out.write("\n")
                draw(found, os.path.splitext(options.output)[0] + ".png")


if __name__ == "__main__":
    main()
