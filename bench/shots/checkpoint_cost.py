#!/usr/bin/env python3
"""What checkpoints cost: a render with and without them, in turns, by the CPU time of the program.

usage: bench/shots/checkpoint_cost.py [BUILD] [-o FILE] [--rounds 8] [--size 256x256] [--spp 16] [--interval 30]

Each round renders twice, with `--checkpoint` and without, the first of the two in turns; user and system time, one thread. Reported
are the mean of the rounds' ratios less 1, its standard error, how many checkpoints were written, and what the program itself
counts in them, as a share of the render with them: of one thread, and without the noise of two renders. With the interval 0 a
checkpoint is written as often as one may be: once 100 times what the last one took has passed.
"""
import argparse
import json
import math
import os
import re
import resource
import subprocess
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def run(command):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stderr
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    saves = [float(one) for one in re.findall(r"checkpoint .*: \d+ passes, saved in ([0-9.]+) s", printed)]
    return cpu, saves


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?", default=os.path.join(ROOT, "build", "release"))
    parser.add_argument("-o", "--output")
    parser.add_argument("--rounds", type=int, default=8)
    parser.add_argument("--size", default="256x256")
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--interval", type=float, default=30)
    options = parser.parse_args()
    program = os.path.join(os.path.abspath(options.build), "tress")
    ratios, saves, seconds, saving, all_seconds = [], 0, 0.0, 0.0, 0.0
    with tempfile.TemporaryDirectory() as folder:
        plain = [program, "render", os.path.join(ROOT, "scenes", "straight_groom.json"), "-o", os.path.join(folder, "a.exr"),
                 "--resolution", options.size, "--spp", str(options.spp), "--threads", "1"]
        saved = plain + ["--checkpoint", "--checkpoint-interval", str(options.interval)]
        for number in range(options.rounds):
            first, second = (plain, saved) if number % 2 == 0 else (saved, plain)
            times = {len(command): run(command) for command in (first, second)}
            (without, _), (with_them, written) = times[len(plain)], times[len(saved)]
            ratios.append(with_them / without - 1)
            saves += len(written)
            saving += sum(written)
            seconds += without
            all_seconds += with_them
    mean = sum(ratios) / len(ratios)
    error = math.sqrt(sum((x - mean) ** 2 for x in ratios) / max(1, len(ratios) - 1) / len(ratios))
    found = {"size": options.size, "samples": options.spp, "rounds": options.rounds, "cpu_seconds": seconds / options.rounds,
             "interval": options.interval, "checkpoints": saves / options.rounds, "cost": mean, "standard_error": error,
             "counted": saving / all_seconds, "load": os.getloadavg()[0]}
    print(json.dumps(found))
    if options.output:
        with open(options.output, "w") as out:
            json.dump(found, out, indent=1)
            out.write("\n")


if __name__ == "__main__":
    main()
