#!/usr/bin/env python3
"""Brightness, noise and CPU of fur whose hits are traced nowhere, as usual, where fibers touch and everywhere, over `fiber3d`.

usage: bench/image/near.py GROOM [BUILD] [--up AXIS] [--melanin X] [--light LIGHT] [--seeds N] [--spp N] [--size N] [--depth N] [-- FLAG...]

GROOM stands, framed, in a white surround that the camera does not see (LIGHT white, the default), under the lamps of a studio, in a
sun or in the map of a file. `fiber3d` meets lights by chance, so under small ones (studio, sun) the truth is `everywhere`. The renders take turns, a seed each turn. Standard errors are over
seeds; the error of a block (8 x 8 pixels) is the root mean square difference from the truth's mean over its mean, what variances
over seeds show of noise taken out. CPU is of whole processes. FLAG: more options of every render.
"""
import argparse
import json
import os
import resource
import subprocess
import sys

import numpy

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "bench", "figures"))
import figures  # noqa: E402

WAYS = {"fiber3d": ["--model", "fiber3d"], "nowhere": ["--near", "nowhere"], "usual": [], "touching": ["--near", "touching"],
        "everywhere": ["--near", "everywhere"]}
LIGHTS = {"white": {"environment": {"constant": [1, 1, 1]}, "environment_visible": False}, "studio": {"environment": {"studio": True}, "environment_visible": False},
          "sun": {"environment": {"constant": [0, 0, 0]}, "environment_visible": False, "lights": [{"distant": {"azimuth_deg": 60, "elevation_deg": 35, "irradiance": [3, 3, 3]}}]}}


def children_cpu():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("groom")
    parser.add_argument("build", nargs="?", default=os.path.join(ROOT, "build", "release"))
    parser.add_argument("--up", default="z")
    parser.add_argument("--melanin", type=float, default=8)
    parser.add_argument("--light", default="white", help="white, studio, sun or the file of a map")
    for name, usual in (("--seeds", 4), ("--spp", 64), ("--size", 64), ("--depth", 256)):
        parser.add_argument(name, type=int, default=usual)
    parser.add_argument("flags", nargs="*", help="after --")
    options = parser.parse_args()
    folder = os.path.join(ROOT, "build", "near")
    os.makedirs(folder, exist_ok=True)
    scene, output = os.path.join(folder, "scene.json"), os.path.join(folder, "picture.exr")
    light = LIGHTS.get(options.light) or {"environment": {"file": os.path.abspath(options.light)}, "environment_visible": False}
    with open(scene, "w") as out:
        json.dump({"camera": {"frame": True}, "image": {"width": options.size, "height": options.size}, **light,
                   "materials": [{"name": "m", "eccentricity": 0.85, "roughness": 0.2, "melanin": {"eumelanin": options.melanin}}],
                   "grooms": [{"file": os.path.abspath(options.groom), "up": options.up, "material": "m"}]}, out)
    ways = {way: flags for way, flags in WAYS.items() if way != "fiber3d" or options.light == "white"}
    pictures, seconds = {way: [] for way in ways}, {way: [] for way in ways}
    for seed in range(1, options.seeds + 1):
        for way, flags in ways.items():
            before = children_cpu()
            subprocess.run([os.path.join(options.build, "tress"), "render", scene, "-o", output, "--quiet", "--layers", "beauty", "--seed",
                            str(seed), "--spp", str(options.spp), "--max-depth", str(options.depth), *flags, *options.flags], check=True)
            seconds[way].append(children_cpu() - before)
            pictures[way].append(figures.read(output).astype(numpy.float64))
    truth = numpy.array([figures.blocks(picture, 8) for picture in pictures["fiber3d" if "fiber3d" in ways else "everywhere"]])
    center, lit = truth.mean(axis=0), truth.mean(axis=(0, 3)) > 1e-3 * truth.mean(axis=0).max()
    relative = {}
    for way in ways:
        some = numpy.array([figures.blocks(picture, 8) for picture in pictures[way]])
        ratio = some.mean() / truth.mean()
        means = [s.mean(axis=(1, 2, 3)) for s in (some, truth)]
        error = ratio * sum(m.var(ddof=1) / m.mean() ** 2 / len(m) for m in means) ** 0.5
        square = (some.mean(axis=0) - center) ** 2 - some.var(axis=0, ddof=1) / len(some) - truth.var(axis=0, ddof=1) / len(truth)
        whole = numpy.array(pictures[way])
        relative[way] = whole.var(axis=0, ddof=1).mean() ** 0.5 / whole.mean()
        cost = numpy.array(seconds[way]) / numpy.array(seconds["nowhere"])
        print(f"{way:10} brightness {ratio:.4f} +- {error:.4f}, block error {max(0.0, square[lit].mean()) ** 0.5 / center[lit].mean():.4f}, "
              f"noise {relative[way]:.3f}, CPU over nowhere {numpy.median(cost):.2f}", flush=True)
    for way in ("usual", "touching"):
        equal = numpy.median(numpy.array(seconds[way]) / numpy.array(seconds["nowhere"])) * (relative[way] / relative["nowhere"]) ** 2
        print(f"CPU to equal noise, {way} over nowhere: {equal:.2f}")


main()
