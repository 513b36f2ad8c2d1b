#!/usr/bin/env python3
"""CPU time of recorded rays in trees that Embree builds otherwise, over the default one (bench_trees), scene by scene.

usage: bench/image/trees.py [BUILD] [-o FILE] [--size N] [--rounds N] [--only NAME]...

Writes JSON, `context` and one entry a scene, and prints a table: a row a tree, a column a scene. One thread, in turns; a minute or
two of CPU a scene.
"""
import argparse
import json
import os
import subprocess

from sources import ROOT, source_of

SCENES = {
    "straight": ["grooms/straight.hair", "--melanin", "0.6"],
    "bear": ["grooms/bear.hair", "--up", "y", "--melanin", "0.5"],
    "curly lock": ["scenes/curly_lock.json"],
    "ponytail": ["grooms/ponytail.hair", "--up", "y", "--melanin", "0.4"],
    "fur ball": ["scenes/fur_ball.json"],
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?", default=os.path.join(ROOT, "build", "release"))
    parser.add_argument("-o", "--output", default=os.path.join(ROOT, "bench", "results", "trees.json"))
    parser.add_argument("--size", default="64")
    parser.add_argument("--rounds", default="7")
    parser.add_argument("--only", action="append", choices=SCENES)
    options = parser.parse_args()
    program = os.path.join(os.path.abspath(options.build), "bench", "bench_trees")
    git = subprocess.run(["git", "-C", ROOT, "rev-parse", "HEAD"], capture_output=True, text=True)
    context = {"commit": git.stdout.strip(), "size": options.size, "rounds": options.rounds, "load": []}
    found, rows = {}, {}
    for name in options.only or SCENES:
        scene, *flags = SCENES[name]
        source = source_of(scene)
        if not source:
            continue
        done = subprocess.run([program, source, *flags, "--size", f"{options.size}x{options.size}", "--rounds", options.rounds],
                              check=True, capture_output=True, text=True)
        found[name] = json.loads(done.stdout)
        context["load"].append(round(os.getloadavg()[0], 1))
        for tree in found[name]["trees"]:
            rows.setdefault(tree["tree"], {})[name] = tree.get("all")
        for asked, ratio in found[name]["shadow_rays"].items():
            rows.setdefault(f"shadow rays: {asked}", {})[name] = ratio
        with open(options.output, "w") as out:
            json.dump({"context": context, "scenes": found}, out, indent=1)
            out.write("\n")
    print(f"{'':44}" + "".join(f"{name:>12}" for name in found))
    for row, values in rows.items():
        cells = [f"{values[name]:12.2f}" if isinstance(values.get(name), float) else f"{'refused':>12}" for name in found]
        print(f"{row:44}" + "".join(cells))


if __name__ == "__main__":
    main()
