#!/usr/bin/python3
"""CPU time to equal noise of two programs: variance times time, paired, in turns, each at its own defaults.

usage: bench/image/before.py OLD NEW [-o FILE] [--spp N] [--seeds N] [--size N] [--model NAME] [--only NAME]...

OLD, NEW: two `tress`. Each renders every scene once to learn its rows, which are kept (--warm-cache); then both take turns
under one seed after another, at `--spp`; so does the new one with `--adaptive on`, which is what its `--noise` does. Time is CPU
time of the passes, on one thread, by the program's own telemetry. Variance is that of a pixel across the seeds, over the
squared mean, where there is hair. Errors: jackknife over the seeds. `learning` is what the first render took more.
A scene that OLD cannot read would have to be written for it: those here are read by both. Writes JSON.
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "figures"))
import figures  # noqa: E402
import numpy  # noqa: E402
from sources import ROOT, source_of  # noqa: E402

SCENES = {
    "straight, brown": ["grooms/straight.hair", "--melanin", "0.6", "--environment", "hdri/city.exr"],
    "bear, brown": ["grooms/bear.hair", "--up", "y", "--melanin", "0.5", "--environment", "hdri/studio.exr"],
    "ponytail, brown": ["grooms/ponytail.hair", "--up", "y", "--melanin", "0.4", "--environment", "hdri/courtyard.exr"],
    "curly lock": ["scenes/curly_lock.json"],
    "straight, white": ["scenes/straight_groom.json", "--melanin", "0.01,0.01"],
    "fur ball": ["scenes/fur_ball.json"],
}


def resolve(word):
    """A file where it is, None if it is absent; any other word as it is."""
    return source_of(word) if "/" in word else word


def render(program, scene, picture, cache, options, seed, flags):
    """CPU seconds of the passes; the picture, linear; its coverage."""
    telemetry = picture + ".jsonl"
    subprocess.run([program, "render", *scene, "-o", picture, "--quiet", "--threads", "1", "--resolution",
                    f"{options.size}x{options.size}", "--spp", str(options.spp), "--seed", str(seed), "--warm-cache", cache,
                    "--telemetry", telemetry, *flags], check=True, capture_output=True)
    with open(telemetry) as lines:
        events = [json.loads(line) for line in lines]
    os.remove(telemetry)
    return (sum(event["cpu_seconds"] for event in events if event["type"] == "pass"),
            figures.read(picture).astype(numpy.float64), figures.coverage(picture))


def relative_variance(pictures, hair):
    pictures = numpy.stack(pictures)[:, hair]
    return pictures.var(axis=0, ddof=1).mean() / pictures.mean() ** 2


def jackknifed(value, count):
    """value(seeds) of all seeds, and its standard error."""
    every = list(range(count))
    left_out = numpy.array([value([i for i in every if i != out]) for out in every])
    return float(value(every)), float(((count - 1) / count * ((left_out - left_out.mean()) ** 2).sum()) ** 0.5)


def measured(scene, rivals, options, folder):
    times, pictures, hair, learning, brightness = {}, {}, None, {}, {}
    caches = {name: os.path.join(folder, f"{name}.cache") for name in rivals}
    for name, (program, flags) in rivals.items():
        if os.path.exists(caches[name]):
            os.remove(caches[name])
        learning[name], _, _ = render(program, scene, os.path.join(folder, "first.exr"), caches[name], options, 999, flags)
        times[name], pictures[name] = [], []
    for seed in range(1, options.seeds + 1):
        for name in list(rivals) if seed % 2 else list(rivals)[::-1]:
            program, flags = rivals[name]
            seconds, picture, coverage = render(program, scene, os.path.join(folder, f"{name}.exr".replace(", ", "_")),
                                                caches[name], options, seed, flags)
            times[name].append(seconds)
            pictures[name].append(picture)
            hair = coverage > 0.5 if hair is None else hair & (coverage > 0.5)
    found = {}
    for name in rivals:
        brightness[name] = float(numpy.stack(pictures[name])[:, hair].mean())
        found[name] = {"variance": float(relative_variance(pictures[name], hair)), "seconds": float(numpy.mean(times[name])),
                       "learning_seconds": learning[name] - float(numpy.mean(times[name])), "mean": brightness[name]}
    old = list(rivals)[0]
    for name in list(rivals)[1:]:
        def over(what, seeds, name=name):
            variance = [relative_variance([pictures[rival][i] for i in seeds], hair) for rival in (name, old)]
            seconds = [numpy.mean([times[rival][i] for i in seeds]) for rival in (name, old)]
            return {"variance": variance[0] / variance[1], "time": seconds[0] / seconds[1],
                    "both": variance[0] * seconds[0] / variance[1] / seconds[1]}[what]
        for what in ("variance", "time", "both"):
            value, error = jackknifed(lambda seeds, what=what: over(what, seeds), options.seeds)
            found[name][f"{what}_over_old"] = {"value": value, "error": error}
    return found


def version_of(program):
    return subprocess.run([program, "--version"], capture_output=True, text=True).stdout.strip()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("-o", "--output", default=os.path.join(ROOT, "bench", "results", "before.json"))
    parser.add_argument("--old-commit", default="", help="written into the file")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--seeds", type=int, default=6)
    parser.add_argument("--size", type=int, default=64)
    parser.add_argument("--model", help="of both, in place of what each takes where none is named")
    parser.add_argument("--only", action="append", choices=SCENES)
    options = parser.parse_args()
    git = subprocess.run(["git", "-C", ROOT, "rev-parse", "HEAD"], capture_output=True, text=True)
    context = {"commit": git.stdout.strip(), "old_commit": options.old_commit, "old": version_of(options.old),
               "new": version_of(options.new), "model": options.model, "samples": options.spp,
               "seeds": options.seeds, "size": options.size, "load": []}
    model = ["--model", options.model] if options.model else []
    rivals = {"old": (options.old, model), "new": (options.new, model), "new, adaptive": (options.new, [*model, "--adaptive", "on"])}
    scenes = {}
    for name in options.only or SCENES:
        scene = [resolve(word) for word in SCENES[name]]
        if None in scene:
            continue
        with tempfile.TemporaryDirectory() as folder:
            scenes[name] = measured(scene, rivals, options, folder)
        context["load"].append(round(os.getloadavg()[0], 1))
        for rival in list(rivals)[1:]:
            words = [f"{what} {scenes[name][rival][what + '_over_old']['value']:.2f} +- "
                    f"{scenes[name][rival][what + '_over_old']['error']:.2f}" for what in ("variance", "time", "both")]
            print(f"{name:16} {rival:14} {', '.join(words)}", flush=True)
        with open(options.output, "w") as out:
            json.dump({"context": context, "scenes": scenes}, out, indent=1)
            out.write("\n")


if __name__ == "__main__":
    main()
