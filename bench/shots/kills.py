#!/usr/bin/env python3
"""Kills a render at random moments until it has gone on from its checkpoint so often, and compares what it leaves in the end.

usage: bench/shots/kills.py [BUILD] [--scene FILE] [--kills 100] [--model elliptical] [--seed 1] [--spp N] [--within 0.6] [-o FILE]

Picture, cache and telemetry must be, to the byte but for times and whether the last save was a merge, those of a render that nobody killed. A kill is a SIGKILL
after a time that is uniform between 0 and `--within` seconds, start of the program included; every fifth one is a
SIGTERM. A scene of a file is rendered at its frame 2, as scenes/moving.json wants it. Renders that end are begun anew, so that there are as many kills as asked for. One thread.
"""
import argparse
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SCENE = {
    "camera": {"frame": True},
    "image": {"width": 48, "height": 48, "samples": 64},
    "environment": {"constant": [1, 0.9, 0.8]},
    "materials": [{"name": "brown"}],
    "grooms": [{"generate": "straight", "strands": 300, "radius_cm": 0.04, "material": "brown"}],
}
# After a SIGTERM, which saves the cache, the last run merges with it: `saved` is "merged", not "saved".
OUTCOMES = {"saved"}
TIMES = {"seconds", "cpu_seconds", "deeper_cpu_seconds", "learning_cpu_seconds", "cpu_seconds_spared_estimate"}
NAMES = {"image", "file"}


def without_times(value):
    if isinstance(value, dict):
        return {key: without_times(item) for key, item in value.items() if key not in TIMES | NAMES | OUTCOMES}
    return value


def telemetry(path):
    with open(path) as lines:
        return [without_times(json.loads(line)) for line in lines]


def pixels(program, one, other):
    compared = subprocess.run([program, "diff", one, other, "--json"], check=True, capture_output=True, text=True)
    return json.loads(compared.stdout)["identical"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?", default=os.path.join(ROOT, "build", "release"))
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--scene")
    parser.add_argument("--within", type=float, default=0.6)
    parser.add_argument("--model", default="elliptical")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("-o", "--output")
    options = parser.parse_args()
    program = os.path.join(os.path.abspath(options.build), "tress")
    folder = tempfile.mkdtemp(prefix="tress_kills_")
    scene, more = os.path.join(folder, "scene.json"), []
    with open(scene, "w") as file:
        json.dump(SCENE, file)
    if options.scene:
        scene, more = os.path.abspath(options.scene), ["--resolution", "48x48", "--frame", "2"]

    def command(name):
        of = lambda ending: os.path.join(folder, name + ending)
        return [program, "render", scene, *more, "-o", of(".exr"), "--warm-cache", of(".cache"),
                "--telemetry", of(".jsonl"), "--threads", "1", "--spp", str(options.spp), "--model", options.model]

    subprocess.run(command("whole"), check=True, capture_output=True)
    chance = random.Random(options.seed)
    kills, resumed, rounds, wrong = 0, 0, 0, []

    def compare():
        one, other = os.path.join(folder, "whole"), os.path.join(folder, "killed")
        if not pixels(program, one + ".exr", other + ".exr"):
            wrong.append(f"round {rounds}: other pixels")
        with open(one + ".cache", "rb") as a, open(other + ".cache", "rb") as b:
            if a.read() != b.read():
                wrong.append(f"round {rounds}: another cache")
        a, b = telemetry(one + ".jsonl"), telemetry(other + ".jsonl")
        if a != b:
            differing = next(((x, y) for x, y in zip(a, b) if x != y), (len(a), len(b)))
            wrong.append(f"round {rounds}: other telemetry: {differing[0]}, {differing[1]}")
        if os.path.exists(other + ".checkpoint"):
            wrong.append(f"round {rounds}: the checkpoint is left")
        left = [name for name in os.listdir(folder) if ".tmp-" in name and not name.startswith("whole")]
        for ending in (".exr", ".png", ".cache", ".jsonl"):
            os.remove(other + ending)
        for name in left:
            os.remove(os.path.join(folder, name))

    while True:
        last = kills >= options.kills
        process = subprocess.Popen(command("killed") + ["--checkpoint", "--checkpoint-interval", "0"], stderr=subprocess.PIPE,
                                   text=True)
        try:
            process.communicate(timeout=None if last else chance.uniform(0, options.within))
        except subprocess.TimeoutExpired:
            kind = signal.SIGTERM if kills % 5 == 4 else signal.SIGKILL
            process.send_signal(kind)
            printed = process.communicate()[1]
            kills += process.returncode != 0
            resumed += "goes on after" in printed
            if process.returncode not in (0, -kind, 128 + kind):
                wrong.append(f"kill {kills}: exit {process.returncode}: {printed}")
            if process.returncode != 0:
                continue
        if process.returncode != 0:
            wrong.append(f"round {rounds}: exit {process.returncode}")
            break
        rounds += 1
        compare()
        if last:
            break
    shutil.rmtree(folder)
    found = {"kills": kills, "went_on_from_a_checkpoint": resumed, "renders_that_ended": rounds, "wrong": wrong,
             "scene": options.scene or "its own", "model": options.model, "seed": options.seed}
    print(json.dumps(found))
    if options.output:
        with open(options.output, "w") as out:
            json.dump(found, out, indent=1)
            out.write("\n")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
