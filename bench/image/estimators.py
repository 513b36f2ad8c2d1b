#!/usr/bin/env python3
"""What `corrected` and `exact` cost beside `fitted`, in one run: variance, CPU time, their product, and bias.

usage: bench/image/estimators.py TRESS SCENE [--samples N] [--teach N] [--repeat N] [--size WxH] [-- render options]
A first render teaches a table; then each estimator renders with it, frozen, by turns and under seeds of its own.
Variance is the square of the picture's noise (telemetry, summary/noise); CPU time is that of the passes, so without
start-up. `bias` is the mean over channels, pixels and repeats of the picture minus that of exact under the same
seed, in radiance, with its standard error by the repeats: nothing is said where that is larger than the bias.
"""
import argparse
import json
import math
import os
import subprocess
import sys
import tempfile


def main():
    words = sys.argv[1:]
    extra = words[words.index("--") + 1:] if "--" in words else []
    words = words[:words.index("--")] if "--" in words else words
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tress")
    parser.add_argument("scene")
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--teach", type=int, default=32, help="samples of the render that fills the table")
    parser.add_argument("--repeat", type=int, default=4, help="two at least")
    parser.add_argument("--size", default="64x64")
    options = parser.parse_args(words)

    with tempfile.TemporaryDirectory() as folder:
        cache = os.path.join(folder, "table.cache")

        def render(name, *flags):
            picture = os.path.join(folder, name + ".exr")
            telemetry = os.path.join(folder, name + ".jsonl")
            subprocess.run([options.tress, "render", options.scene, "-o", picture, "--resolution", options.size,
                            "--telemetry", telemetry, "--quiet", *flags, *extra],
                           check=True, stderr=subprocess.DEVNULL)
            with open(telemetry) as lines:
                events = [json.loads(line) for line in lines]
            summary = [event for event in events if event["type"] == "summary"][0]
            return {"picture": picture, "noise": summary["noise"],
                    "exact_share": summary["exact_queries"] / max(1, summary["queries"]),
                    "cpu": sum(event["cpu_seconds"] for event in events if event["type"] == "pass")}

        def bias(name_a, name_b):
            text = subprocess.run([options.tress, "diff", name_a, name_b, "--json"], check=True, capture_output=True,
                                  text=True).stdout
            return sum(json.loads(text)["bias"]) / 3

        render("teach", "--model", "elliptical", "--warm-cache", cache, "--spp", str(options.teach))
        frozen = ["--warm-cache", cache, "--cache-mode", "frozen", "--spp", str(options.samples)]
        runs = {name: [] for name in ("fitted", "corrected", "exact")}
        for turn in range(options.repeat):
            for name in runs:
                flags = ["--model", "elliptical", "--estimator", name, "--seed", str(100 + turn)]
                flags += frozen if name != "exact" else ["--spp", str(options.samples)]
                runs[name].append(render(f"{name}{turn}", *flags))
        def mean_of(name, key):
            return sum(run[key] for run in runs[name]) / options.repeat

        table = {}
        for name, list_of_runs in runs.items():
            variance = sum(run["noise"] ** 2 for run in list_of_runs) / options.repeat
            row = {"relative_variance": variance, "cpu_seconds": mean_of(name, "cpu"),
                   "exact_share": mean_of(name, "exact_share")}
            if name != "exact":
                each = [bias(runs["exact"][turn]["picture"], run["picture"]) for turn, run in enumerate(list_of_runs)]
                middle = sum(each) / len(each)
                spread = math.sqrt(sum((x - middle) ** 2 for x in each) / max(1, len(each) - 1) / len(each))
                row["bias"], row["bias_error"] = middle, spread
            table[name] = row
        fitted = table["fitted"]
        for row in table.values():
            row["variance_over_fitted"] = row["relative_variance"] / fitted["relative_variance"]
            row["cpu_over_fitted"] = row["cpu_seconds"] / fitted["cpu_seconds"]
            row["product_over_fitted"] = row["variance_over_fitted"] * row["cpu_over_fitted"]
        print(json.dumps({"scene": options.scene, "size": options.size, "samples": options.samples,
                          "teach": options.teach, "repeat": options.repeat, "load": os.getloadavg()[0],
                          "estimators": table}, indent=1))


if __name__ == "__main__":
    main()
