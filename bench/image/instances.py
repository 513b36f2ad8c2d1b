#!/usr/bin/env python3
"""Memory and CPU of a meadow of instances over those of its strands written out, and whether both pictures are as bright.

usage: bench/image/instances.py [BUILD] [--instances N] [--spread CM] [--spp N]

A tuft of 40 strands, placed at random over a square. CPU is of whole processes, memory the largest resident size; the difference of
the means is in standard errors by the spread of the pixels.
"""
import argparse
import json
import os
import random
import subprocess
import sys
import tempfile

import numpy

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "bench", "figures"))
import figures  # noqa: E402


def scene(groom, width):
    return {"camera": {"eye": [0, -60, 25], "look_at": [0, 0, 0], "vertical_fov_deg": 35},
            "image": {"width": width, "height": width * 9 // 16}, "environment": {"constant": [0.5, 0.6, 0.8]},
            "materials": [{"name": "grass", "color": [0.2, 0.3, 0.08]}], "grooms": [{"material": "grass", **groom}]}


def run(command):
    process = subprocess.Popen(command)
    _, status, used = os.wait4(process.pid, 0)
    if status != 0:
        raise SystemExit(f"instances: failed: {' '.join(command)}")
    return used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?", default=os.path.join(ROOT, "build", "release"))
    parser.add_argument("--instances", type=int, default=10000)
    parser.add_argument("--spread", type=float, default=60, help="side of the square")
    parser.add_argument("--spp", type=int, default=2)
    parser.add_argument("--width", type=int, default=240)
    options = parser.parse_args()
    draw, half = random.Random(2026), options.spread / 2
    instances = [{"translate": [draw.uniform(-half, half), draw.uniform(-half, half), 0], "scale": draw.uniform(0.6, 1.3),
               "rotate_deg": [draw.uniform(-8, 8), draw.uniform(-8, 8), draw.uniform(0, 360)]} for _ in range(options.instances)]
    tress = os.path.join(options.build, "tress")
    with tempfile.TemporaryDirectory() as folder:
        def path(name):
            return os.path.join(folder, name)
        tuft = {"generate": "straight", "strands": 40, "length_cm": 4, "radius_cm": 0.03, "rotate_deg": [180, 0, 0], "instances": instances}
        grooms = {"instances": tuft, "written": {"file": path("all.hair"), "cm_per_unit": 1, "up": "z", "widths": "file"}}
        for name, groom in grooms.items():
            with open(path(name + ".json"), "w") as out:
                json.dump(scene(groom, options.width), out)
        run([tress, "convert", path("instances.json"), path("all.hair")])
        found = {}
        for name in grooms:
            cpu, memory = run([tress, "render", path(name + ".json"), "-o", path(name + ".exr"), "--spp", str(options.spp), "--quiet",
                               "--layers", "beauty"])
            pixels = figures.read(path(name + ".exr")).mean(axis=2)
            found[name] = pixels.mean(), pixels.std() / pixels.size ** 0.5
            print(f"{name:9} CPU {cpu:.1f} s, memory {memory:.0f} MB, mean {pixels.mean():.4f}")
        (a, e), (b, f) = found.values()
        print(f"means differ by {a - b:+.4f}, {abs(a - b) / numpy.hypot(e, f):.1f} standard errors")


if __name__ == "__main__":
    main()
