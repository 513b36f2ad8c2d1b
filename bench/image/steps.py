#!/usr/bin/env python3
"""Variance times CPU time of each step towards less noise (bench_steps), scene by scene.

usage: bench/image/steps.py [BUILD] [-o FILE] [--spp N] [--seeds N] [--only NAME]...

Writes JSON, `context` and one entry a scene. One thread; some 20 to 60 s of CPU a scene.
"""
import argparse
import json
import os
import subprocess

from sources import ROOT, source_of

BLOND, BROWN, WHITE = ["--melanin", "0.1,0.3"], ["--melanin", "1.3,0"], ["--melanin", "0.01,0.01"]
SCENES = {
    "straight, brown": ["scenes/straight_groom.json", "--size", "40x50"],
    "straight, blond": ["scenes/straight_groom.json", "--size", "40x50", *BLOND],
    "straight, white": ["scenes/straight_groom.json", "--size", "40x50", *WHITE],
    "curly lock, blond": ["scenes/curly_lock.json", "--size", "20x60", *BLOND],
    "fur ball": ["scenes/fur_ball.json", "--size", "36x36"],
    "bear, brown": ["grooms/bear.hair", "--size", "40x50", "--up", "y", *BROWN],
    "bear, blond": ["grooms/bear.hair", "--size", "40x50", "--up", "y", *BLOND],
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?", default=os.path.join(ROOT, "build", "release"))
    parser.add_argument("-o", "--output", default=os.path.join(ROOT, "bench", "results", "steps.json"))
    parser.add_argument("--spp", default="32")
    parser.add_argument("--seeds", default="4")
    parser.add_argument("--only", action="append", choices=SCENES)
    options = parser.parse_args()
    program = os.path.join(os.path.abspath(options.build), "bench", "bench_steps")
    git = subprocess.run(["git", "-C", ROOT, "rev-parse", "HEAD"], capture_output=True, text=True)
    context = {"commit": git.stdout.strip(), "samples": int(options.spp), "seeds": int(options.seeds), "load": os.getloadavg()[0]}
    found = []
    for name in options.only or SCENES:
        scene, *flags = SCENES[name]
        source = source_of(scene)
        if not source:
            continue
        command = [program, source, *flags, "--spp", options.spp, "--seeds", options.seeds]
        measured = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        measured["scene"] = name
        found.append(measured)
        for step in measured["steps"]:
            print(f"{name:18} {step['step']:32} {step['variance_times_time']:.2f} +- {step['standard_error']:.2f}, "
                  f"reported {step['told_over_true_variance']:.2f}", flush=True)
        with open(options.output, "w") as out:
            json.dump({"context": context, "scenes": found}, out, indent=1)
            out.write("\n")


if __name__ == "__main__":
    main()
