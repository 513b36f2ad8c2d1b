#!/usr/bin/env python3
"""What a farm of 1 to 1,000 workers spends on calibration and merging: costs measured here, workers simulated from them.

usage: bench/shots/workers.py [BUILD] [-o FILE] [--caches 100] [--frames 240] [--scene SCENE] [--size 64x64] [--spp 16]

Measured, CPU time of one thread: a frame cold and the same warm, in turns, so what calibration costs; `tress cache merge` of 1, 10 and
all of so many caches that were learned apart from the same hair under other seeds; bytes. Simulated: a shot of so many
frames, each of which costs what the warm one does, by workers that are all alike and start together. `cold`: every worker
calibrates for itself and carries its table; `first`: the first frame alone calibrates, the others wait for it
(--calibrate-first); `frozen`: the table was there. The merge comes after the last frame; its time grows linearly between
the measured counts and beyond them. What a worker of other speed, a disk or a network costs is not in it.
"""
import argparse
import json
import math
import os
import resource
import subprocess
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def cpu_seconds(command):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def merge_seconds(measured, count):
    """Linear between the measured counts, and past the last one at its slope from the one before."""
    counts = sorted(measured)
    if count <= 1:
        return 0.0
    for low, high in zip(counts, counts[1:]):
        if count <= high or high == counts[-1]:
            slope = (measured[high] - measured[low]) / (high - low)
            return measured[low] + slope * (count - low)
    return measured[counts[0]]


def simulate(workers, frames, frame, calibration, merges):
    most = math.ceil(frames / workers)
    busy = min(workers, frames)
    merge = merge_seconds(merges, busy)
    rest = math.ceil((frames - 1) / workers)
    return {
        "workers": workers,
        "cold": {"wall": calibration + most * frame + merge, "cpu": busy * calibration + frames * frame + merge,
                 "calibrations": busy},
        "first": {"wall": calibration + frame + rest * frame + merge, "cpu": calibration + frames * frame + merge,
                  "calibrations": 1},
        "frozen": {"wall": most * frame, "cpu": frames * frame, "calibrations": 0},
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?", default=os.path.join(ROOT, "build", "release"))
    parser.add_argument("-o", "--output", default=os.path.join(ROOT, "bench", "results", "workers.json"))
    parser.add_argument("--caches", type=int, default=100)
    parser.add_argument("--frames", type=int, default=240)
    parser.add_argument("--scene", default=os.path.join(ROOT, "scenes", "straight_groom.json"))
    parser.add_argument("--size", default="64x64")
    parser.add_argument("--spp", default="16")
    options = parser.parse_args()
    program = os.path.join(os.path.abspath(options.build), "tress")
    with tempfile.TemporaryDirectory() as folder:
        of = lambda name: os.path.join(folder, name)
        render = [program, "render", options.scene, "--resolution", options.size, "--threads", "1", "--quiet"]
        caches, cold, warm = [of(f"{seed}.cache") for seed in range(options.caches)], 0.0, 0.0
        learned = ["-o", of("a.exr"), "--spp", options.spp]
        for seed, cache in enumerate(caches):
            if seed >= 3:
                cpu_seconds(render + ["-o", of("a.exr"), "--seed", str(seed), "--spp", "2", "--warm-cache", cache])
                continue
            # In turns: the same work takes more CPU on a busier machine.
            cold += cpu_seconds(render + learned + ["--seed", str(seed), "--warm-cache", cache]) / 3
            warm += cpu_seconds(render + learned + ["--seed", str(100 + seed), "--warm-cache", cache, "--cache-mode",
                                                    "frozen"]) / 3
        merges, sizes = {}, {}
        for count in sorted({1, 10, options.caches}):
            merges[count] = cpu_seconds([program, "cache", "merge", *caches[:count], "-o", of("all.cache")])
            sizes[count] = os.path.getsize(of("all.cache"))
        bytes_in = [os.path.getsize(cache) for cache in caches]
    calibration = max(0.0, cold - warm)
    git = subprocess.run(["git", "-C", ROOT, "rev-parse", "HEAD"], capture_output=True, text=True)
    found = {
        "context": {"commit": git.stdout.strip(), "load": os.getloadavg()[0]},
        "scene": os.path.relpath(options.scene, ROOT), "size": options.size, "samples": int(options.spp),
        "frames": options.frames,
        "cpu_seconds": {"frame_cold": cold, "frame_warm": warm, "calibration": calibration},
        "merge": [{"caches": count, "cpu_seconds": merges[count], "bytes_read": sum(bytes_in[:count]), "bytes": sizes[count]}
                  for count in sorted(merges)],
        "simulated": [simulate(workers, options.frames, warm, calibration, merges) for workers in (1, 10, 100, 1000)],
        "simulated_of_frames_100_times_as_long": [simulate(workers, options.frames, 100 * warm, calibration, merges)
                                                  for workers in (1, 10, 100, 1000)],
    }
    with open(options.output, "w") as out:
        json.dump(found, out, indent=1)
        out.write("\n")
    print(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
