#!/usr/bin/env python3
"""A turntable: eight of its frames for flat (e = .7) and for round fibers, all from one warm cache.

The table that the first frame fills serves the others: the share of queries that converged rows answered is printed for
each frame.
"""
import json
import os

import figures

FRAMES, SHOWN = 48, 8


def main():
    options = figures.parse(__doc__, samples=48, size="200x250")
    rows = []
    for e in (0.7, 1.0):
        scene = figures.variant(options, "scenes/turntable.json", f"turntable_{e:g}", figures.materials(eccentricity=e))
        cache = figures.path(options, f"turntable_{e:g}.cache")
        if not options.reuse and os.path.exists(cache):
            os.remove(cache)
        row = []
        for frame in range(0, FRAMES, FRAMES // SHOWN):
            name = f"turntable_{e:g}_{frame:02d}"
            telemetry = figures.path(options, name + ".jsonl")
            exr = figures.render(options, scene, name, "--frame", frame, "--warm-cache", cache, "--telemetry", telemetry)
            with open(telemetry) as lines:
                summary = [json.loads(line) for line in lines][-1]
            share = 1 - summary["exact_queries"] / max(1, summary["queries"])
            row.append((f"e = {e:g}, frame {frame}: {share:.1%}", figures.read(exr, behind=0.5)))
        rows.append(row)
    figures.sheet(options, "turntable", rows, "share of queries answered by converged rows, one warm cache a row")


if __name__ == "__main__":
    main()
