#!/usr/bin/env python3
"""What it costs that colors vary: CPU time of renders whose melanin differs from place to place, over that of its mean.

usage: bench/image/varying_cost.py [BUILD] [--seeds N] [--spp N] [--before TRESS]

6,000 straight strands, 96 x 120 pixels, one thread, the ways in turns, a seed each turn; CPU of the whole process. The melanin is
0.6 to within 3 %, so that the light is the same. --before: also the ratio to another program, of the same seeds.
"""
import argparse
import json
import os
import statistics
import tempfile

from calibration import cpu_of
from sources import ROOT

MASK = os.path.join(ROOT, "scenes", "gallery", "streaks_mask.png")
UP, DOWN = ({"ramp": [[0, a], [1, b]]} for a, b in ((0.58, 0.62), (0.62, 0.58)))
WAYS = {"nothing varies": 0.6, "ramp": UP, "random": {"random": [0.58, 0.62]},
        "ramps by texture": {"mix": [UP, DOWN], "share": {"texture": MASK, "space": "linear"}}}


def shown(of, to):
    ratios = [a / b for a, b in zip(of, to)]
    error = statistics.stdev(ratios) / len(ratios) ** 0.5 if len(ratios) > 1 else 0
    return f"{statistics.mean(ratios):.3f} +- {error:.3f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?", default=os.path.join(ROOT, "build", "release"))
    parser.add_argument("--seeds", type=int, default=6)
    parser.add_argument("--spp", type=int, default=24)
    parser.add_argument("--before", metavar="TRESS")
    args = parser.parse_args()
    programs = [os.path.join(args.build, "tress")] + ([args.before] if args.before else [])
    with tempfile.TemporaryDirectory() as folder:
        for way, melanin in WAYS.items():
            material = {"name": "m", "eccentricity": 0.8, "roughness": 0.2, "melanin": {"eumelanin": melanin}}
            scene = {"camera": {"frame": True}, "image": {"width": 96, "height": 120, "samples": args.spp},
                     "environment": {"studio": True}, "materials": [material],
                     "grooms": [{"generate": "straight", "strands": 6000, "radius_cm": 0.01, "material": "m"}]}
            with open(os.path.join(folder, way + ".json"), "w") as file:
                json.dump(scene, file)
        cpu = {(program, way): [] for program in programs for way in WAYS}
        for seed in range(args.seeds):
            for program, way in cpu:
                cpu[program, way].append(cpu_of([program, "render", os.path.join(folder, way + ".json"), "-o",
                                                 os.path.join(folder, "x.exr"), "--threads", "1", "--seed", str(seed)]))
    plain = cpu[programs[0], "nothing varies"]
    for way in WAYS:
        now = cpu[programs[0], way]
        before = f", over before {shown(now, cpu[args.before, way])}" if args.before else ""
        print(f"{way}: {statistics.mean(now):.2f} s, over nothing {shown(now, plain)}{before}")


if __name__ == "__main__":
    main()
