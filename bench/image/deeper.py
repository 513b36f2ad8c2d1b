#!/usr/bin/env python3
"""Variance times CPU time of roulette by what lies deeper over roulette by the throughput (bench_deeper), scene by scene.

usage: bench/image/deeper.py [BUILD] [-o FILE] [--spp N] [--pairs N] [--size N] [--deep-light] [--only NAME]...

--deep-light: of learned light in place of deep paths over traced.

Writes JSON, `context` and one entry a scene. One thread, in turns; 10 to 40 s of CPU a scene.
"""
import argparse
import json
import os
import subprocess

from sources import ROOT, source_of

BLOND, BROWN = ["--melanin", "0.1,0.3"], ["--melanin", "1.3,0"]
SCENES = {
    "straight, brown": ["scenes/straight_groom.json"],
    "straight, blond": ["scenes/straight_groom.json", *BLOND],
    "straight, white": ["scenes/straight_groom.json", "--white"],
    "curly lock, blond": ["scenes/curly_lock.json", *BLOND],
    "fur ball": ["scenes/fur_ball.json"],
    "bear, brown": ["grooms/bear.hair", "--up", "y", *BROWN],
    "bear, blond": ["grooms/bear.hair", "--up", "y", *BLOND],
    "ponytail, brown": ["grooms/ponytail.hair", "--up", "y", *BROWN],
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?", default=os.path.join(ROOT, "build", "release"))
    parser.add_argument("-o", "--output", default=os.path.join(ROOT, "bench", "results", "deeper.json"))
    parser.add_argument("--spp", default="24")
    parser.add_argument("--pairs", default="6")
    parser.add_argument("--size", default="48")
    parser.add_argument("--deep-light", action="store_true")
    parser.add_argument("--only", action="append", choices=SCENES)
    options = parser.parse_args()
    program = os.path.join(os.path.abspath(options.build), "bench", "bench_deeper")
    git = subprocess.run(["git", "-C", ROOT, "rev-parse", "HEAD"], capture_output=True, text=True)
    context = {"commit": git.stdout.strip(), "load": os.getloadavg()[0]}
    found = []
    for name in options.only or SCENES:
        scene, *flags = SCENES[name]
        source = source_of(scene)
        if not source:
            continue
        command = [program, source, *flags, "--spp", options.spp, "--pairs", options.pairs, "--size", options.size]
        command += ["--deep-light", "learned"] if options.deep_light else []
        done = subprocess.run(command, check=True, capture_output=True, text=True)
        measured = json.loads(done.stdout.splitlines()[-1])
        measured["scene"] = name
        found.append(measured)
        ratio = measured["variance_x_time"]
        print(f"{name:18} variance {measured['variance']['value']:.2f}, time {measured['time']['value']:.2f}, "
              f"both {ratio['value']:.2f} +- {ratio['error']:.2f}", flush=True)
        if options.deep_light:
            bias = measured["told_bias"]
            print(f"{'':18} bias {bias['value']:+.3f} +- {bias['error']:.3f}, blocks {measured['block_bias']:.3f}", flush=True)
        with open(options.output, "w") as out:
            json.dump({"context": context, "scenes": found}, out, indent=1)
            out.write("\n")


if __name__ == "__main__":
    main()
