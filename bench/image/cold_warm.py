#!/usr/bin/env python3
"""Cold against warm against exact, in one run: time, error, g evaluations, share of queries on converged rows.

usage: bench/image/cold_warm.py TRESS SCENE [--samples N] [--reference-samples N] [--size WxH] [-- render options]
The reference is `--estimator exact` with another seed, so that errors of the two are independent. relMSE of an
unbiased picture is noise alone; what the fit adds shows in `bias`, the mean of B - A per channel.
"""
import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile


def children_cpu():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def main():
    words = sys.argv[1:]
    extra = words[words.index("--") + 1:] if "--" in words else []
    words = words[:words.index("--")] if "--" in words else words
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tress")
    parser.add_argument("scene")
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--reference-samples", type=int, default=256)
    parser.add_argument("--size", default="128x128")
    options = parser.parse_args(words)

    with tempfile.TemporaryDirectory() as folder:
        def render(name, samples, *flags):
            picture = os.path.join(folder, name + ".exr")
            telemetry = os.path.join(folder, name + ".jsonl")
            before = children_cpu()
            subprocess.run([options.tress, "render", options.scene, "-o", picture, "--spp", str(samples),
                            "--resolution", options.size, "--telemetry", telemetry, "--quiet", *flags, *extra],
                           check=True)
            with open(telemetry) as lines:
                events = [json.loads(line) for line in lines]
            passes = [event for event in events if event["type"] == "pass"]
            return {"picture": picture, "cpu_seconds": children_cpu() - before,
                    "g_evaluations": sum(event.get("g_evaluations", 0) for event in passes),
                    "learning_cpu_seconds": sum(event.get("learning_cpu_seconds", 0) for event in passes),
                    "converged_query_share": [round(event.get("converged_query_share", 0), 4) for event in passes[:10]]}

        cache = os.path.join(folder, "table.cache")
        reference = render("reference", options.reference_samples, "--estimator", "exact", "--seed", "1000")
        runs = {
            "cold": render("cold", options.samples, "--warm-cache", cache),
            "warm": render("warm", options.samples, "--warm-cache", cache, "--cache-mode", "frozen"),
            "exact": render("exact", options.samples, "--estimator", "exact"),
        }
        for run in runs.values():
            text = subprocess.run([options.tress, "diff", reference["picture"], run["picture"], "--json"], check=True,
                                  capture_output=True, text=True).stdout
            difference = json.loads(text)
            run["relMSE"], run["bias"] = difference["relMSE"], difference["bias"]
            run["cpu_over_warm"] = run["cpu_seconds"] / runs["warm"]["cpu_seconds"]
            run.pop("picture")
        print(json.dumps({"scene": options.scene, "size": options.size, "samples": options.samples,
                          "reference_samples": options.reference_samples, "load": os.getloadavg()[0],
                          "runs": runs}, indent=1))


if __name__ == "__main__":
    main()
