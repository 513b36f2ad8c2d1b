#!/usr/bin/env python3
"""CPU time to equal noise of `rough` over that of `elliptical`, both warm, and how far both are from the traced fiber.

usage: bench/image/models.py [BUILD] [-o FILE] [--spp N] [--seeds N] [--truth N] [--only NAME]... [--cold] [-- FLAG...]

The scenes of chart 4, and blond hair in a city, whose hits are all answered by rows (near=nowhere). Each model is taught by
one render, then rendered with its table frozen, the models taking turns, a seed each turn. Noise n^2 is the variance over seeds, mean of the pixels that are lit, over the square of
their mean; the time to 5 % noise is once + sample N (n / 0.05)^2 as in chart 4 (bench/charts/pictures.py). The error is the
root mean square difference of means of 8 x 8 pixels from the truth's over its mean, what variances over seeds show of noise
taken out. The truth is `rough` without a row, --truth seeds (0: none) of four times the samples: every hit is a traced path and
sees lights without bias, which fiber3d, the same in the mean, does with much more noise under small lights. Standard errors are
by leaving out one seed at a time. FLAG: more options of every `rough` render.

--cold: `rough` alone, without a cache: its error, its brightness and the noise of a picture in the same blocks. Such a picture is
as good as one without bias if the square of the error is small against that of the noise.
"""
import argparse
import json
import os
import sys

import numpy

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path[:0] = [os.path.join(ROOT, "bench", "charts"), os.path.join(ROOT, "bench", "figures")]
import charts  # noqa: E402
import figures  # noqa: E402
import pictures  # noqa: E402

BLOCK = 8
ROWS = ("--set", "integrator/near=nowhere")
SCENES = {f"{groom}, {color}" if color else groom: (groom, color, None) for groom, color in
          [("curly lock", "light"), ("straight groom", "brown"), ("straight.hair", "light"), ("bear.hair", "dark"), ("varied", None)]}
SCENES["straight groom, light, city"] = ("straight groom", "light", "hdri/city.exr")


def scene_of(run, groom, color, environment):
    path = pictures.scene(run, groom, color)
    found = run.scene(environment) if environment else None
    if not path or (environment and not found):
        return None
    if not environment:
        return path

    def change(content):
        content["environment"] = {"file": found}

    return run.variant(path, os.path.basename(path)[:-5] + "_city", change)


class Renders:
    """Pictures of one model under seeds of their own, flattened, and the CPU of their passes."""

    def __init__(self):
        self.pictures, self.once, self.sample = [], [], []

    def add(self, done, samples):
        cost = pictures.costs(done, samples)
        self.pictures.append(figures.read(done.picture).astype(numpy.float64))
        self.once.append(cost["once"])
        self.sample.append(cost["sample"])

    def without(self, left_out):
        kept = [i for i in range(len(self.pictures)) if i != left_out]
        return numpy.array([self.pictures[i] for i in kept]), numpy.array(self.once)[kept], numpy.array(self.sample)[kept]

    def cost(self, samples, left_out=None):
        """Seconds to 5 % noise, noise^2, seconds a sample, seconds once."""
        some, once, sample = self.without(left_out)
        mean = some.mean(axis=0)
        lit = mean.mean(axis=-1) > 0
        noise = some.var(axis=0, ddof=1)[lit].mean() / mean[lit].mean() ** 2
        steady, first = sample.mean(), max(0.0, once.mean())
        return first + steady * samples * noise / pictures.TARGET ** 2, noise, steady, first


def coarse(renders, left_out=None):
    some = renders.without(left_out)[0]
    return numpy.array([figures.blocks(picture, BLOCK) for picture in some])


def error_of(renders, truth, left_out=None, left_out_truth=None):
    a, t = coarse(renders, left_out), coarse(truth, left_out_truth)
    mean, center = t.mean(axis=0), a.mean(axis=0)
    square = (center - mean) ** 2 - a.var(axis=0, ddof=1) / len(a) - t.var(axis=0, ddof=1) / len(t)
    lit = mean.mean(axis=-1) > 1e-3 * mean.max()
    return max(0.0, square[lit].mean()) ** 0.5 / mean[lit].mean()


def with_error(value, without):
    """value: of all seeds; without: of all but one each."""
    without = numpy.array(without)
    n = len(without)
    return {"value": float(value), "standard_error": float(((n - 1) / n * ((without - without.mean()) ** 2).sum()) ** 0.5)}


def plain(name):
    return name.replace(" ", "_").replace(",", "").replace(".", "_")


def rendered(run, scene, name, samples, seeds, *flags):
    """Renders of `rough`, a seed each."""
    renders = Renders()
    for seed in seeds:
        renders.add(run.render(scene, name, "--model", "rough", *ROWS, "--spp", samples, "--layers", "beauty", *flags, seed=seed), samples)
    return renders


def traced(run, scene, name, size, options):
    return rendered(run, scene, f"{plain(name)}_truth", 4 * options.spp, range(101, 101 + options.truth), "--resolution", size,
                    "--table-memory", 0)


def measure(run, name, options):
    groom, color, environment = SCENES[name]
    scene = scene_of(run, groom, color, environment)
    if not scene:
        return None
    size = pictures.size_of(groom, False)
    models, caches = {"elliptical": Renders(), "rough": Renders()}, {}
    more = {"elliptical": [], "rough": [*ROWS, *options.flags]}
    for model in models:
        caches[model] = run.path(f"{plain(name)}_{model}.cache")
        if os.path.exists(caches[model]):
            os.remove(caches[model])
        run.render(scene, f"{plain(name)}_{model}_taught", "--model", model, "--resolution", size, "--spp", 32, "--warm-cache", caches[model],
                   *more[model], seed=9000)
    for seed in range(1, options.seeds + 1):
        for model, renders in models.items():
            renders.add(run.render(scene, f"{plain(name)}_{model}", "--model", model, "--resolution", size, "--spp", options.spp, "--warm-cache",
                                   caches[model], "--cache-mode", "frozen", "--layers", "beauty", *more[model], seed=seed), options.spp)
    a, b = models["rough"], models["elliptical"]
    whole = [renders.cost(options.spp) for renders in (a, b)]
    parts = [[renders.cost(options.spp, k) for renders in (a, b)] for k in range(options.seeds)]
    found = {"scene": name, "size": size, "once": {"rough": float(whole[0][3]), "elliptical": float(whole[1][3])}}
    for i, quantity in enumerate(("time_to_5_percent", "noise_squared", "time_a_sample")):
        found[quantity] = with_error(whole[0][i] / whole[1][i], [one[i] / other[i] for one, other in parts])
    if options.truth > 0:
        truth = traced(run, scene, name, size, options)
        for model, renders in models.items():
            found[model + "_error"] = with_error(error_of(renders, truth),
                                                 [error_of(renders, truth, None, k) for k in range(options.truth)])
            found[model + "_brightness"] = float(numpy.mean(renders.pictures) / numpy.mean(truth.pictures))
    return found


def measure_cold(run, name, options):
    groom, color, environment = SCENES[name]
    scene = scene_of(run, groom, color, environment)
    if not scene:
        return None
    size = pictures.size_of(groom, False)
    truth = traced(run, scene, name, size, options)
    cold = rendered(run, scene, f"{plain(name)}_cold", options.spp, range(1, 1 + options.seeds), "--resolution", size, *options.flags)
    mean = coarse(truth).mean(axis=0)
    lit = mean.mean(axis=-1) > 1e-3 * mean.max()

    def noise(left_out=None):
        return float(coarse(cold, left_out).var(axis=0, ddof=1)[lit].mean() ** 0.5 / mean[lit].mean())

    def brightness(left_out=None):
        return float(cold.without(left_out)[0].mean() / numpy.mean(truth.pictures))

    without = range(options.seeds)
    return {"scene": name, "samples": options.spp,
            "error": with_error(error_of(cold, truth), [error_of(cold, truth, k) for k in without]),
            "noise": with_error(noise(), [noise(k) for k in without]),
            "brightness": with_error(brightness(), [brightness(k) for k in without])}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?", default=os.path.join(ROOT, "build", "release"))
    parser.add_argument("-o", "--output", help="bench/results/default_model.json; build/default_model/cold.json by --cold")
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--seeds", type=int, default=12)
    parser.add_argument("--truth", type=int, default=4)
    parser.add_argument("--only", action="append", choices=SCENES)
    parser.add_argument("--cold", action="store_true")
    parser.add_argument("flags", nargs="*", help="after --")
    options = parser.parse_args()
    if not options.output:
        options.output = os.path.join(ROOT, *(["build", "default_model", "cold.json"] if options.cold else
                                              ["bench", "results", "default_model.json"]))
    run = charts.Run(os.path.join(os.path.abspath(options.build), "tress"), os.path.join(ROOT, "build", "default_model"))
    scenes = []
    for name in options.only or SCENES:
        found = (measure_cold if options.cold else measure)(run, name, options)
        if not found:
            continue
        scenes.append(found)
        shown = {key: f"{value['value']:.3f} +- {value['standard_error']:.3f}" for key, value in found.items() if "standard_error" in str(value)}
        print(name, shown, {key: value for key, value in found.items() if key.endswith("_brightness")}, flush=True)
        with open(options.output, "w") as out:
            json.dump({"context": charts.context(run), "scenes": scenes}, out, indent=1)
            out.write("\n")


if __name__ == "__main__":
    main()
