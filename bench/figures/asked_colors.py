#!/usr/bin/env python3
"""The color that was asked for against the color that a dense lock returns, for fibers of every shape and both models.

    bench/figures/asked_colors.py ../shared/data/grooms/straight.hair [--json FILE]

Renders the middle of the groom in constant light 1: means over the columns 32 to 47 and the rows 40 to 55 of 80 x 80
pixels. Prints a row a fiber and model: what was returned, and the largest difference to what was asked.
"""
import json
import os

import figures

ASKED = [(0.95, 0.5, 0.05), (0.8, 0.3, 0.15)]
FIBERS = [(0.85, 0.2, 3), (0.5, 0.1, 0), (1, 0.4, 3), (0.7, 0.3, 8), (0.5, 0.6, 3), (0.6, 0.2, 8), (1, 0.05, 3),
          (1, 0.1, 0), (0.75, 0.2, 0), (0.5, 0.3, 0), (0.75, 0.1, 8), (1, 0.3, 8), (0.5, 0.1, 8), (1, 0.1, 8), (0.5, 0.2, 8)]
MODELS = ["elliptical", "rough"]
CROP = "32,40,48,56"


def returned(options, groom, fiber, model, color, seed):
    e, alpha, tilt = fiber
    name = "asked_%s_%g_%g_%g_%g_%d" % (model, e, alpha, tilt, color[0], seed)
    scene = {"environment": {"constant": [1, 1, 1]}, "grooms": [{"file": os.path.abspath(groom), "up": "z"}],
             "materials": [{"name": "lock", "eccentricity": e, "roughness": alpha, "tilt_deg": tilt, "color": list(color)}]}
    file = figures.path(options, name + ".json")
    with open(file, "w") as stream:
        json.dump(scene, stream)
    exr = figures.render(options, file, name, "--model", model, "--crop", CROP, "--seed", seed,
                         *options.flags)
    pixels = figures.read(exr)
    if pixels.shape[0] > 16:  # the data window of a crop may be the whole
        pixels = pixels[40:56, 32:48]
    return pixels.reshape(-1, 3).mean(axis=0)


def main():
    options = figures.parse(__doc__, samples=64, size="80x80", add=lambda p: (
        p.add_argument("groom"), p.add_argument("--json", help="write the figures there"),
        p.add_argument("--flags", nargs="*", default=[], help="more of tress render's"),
        p.add_argument("--models", nargs="*", default=MODELS),
        p.add_argument("--fibers", type=int, nargs="*", default=range(len(FIBERS)), help="which of them, from 0"),
        p.add_argument("--asked", nargs="*", help="colors, R,G,B each; default: two from 0.05 to 0.95")))
    asked = [tuple(float(x) for x in one.split(",")) for one in options.asked] if options.asked else ASKED
    rows = []
    for fiber in (FIBERS[i] for i in options.fibers):
        for model in options.models:
            row = {"fiber": fiber, "model": model, "returned": [], "off": 0.0}
            for color in asked:
                mean = returned(options, options.groom, fiber, model, color, options.seed)
                row["returned"] += [float(x) for x in mean]
                row["off"] = max([row["off"], *(abs(float(x) - c) for x, c in zip(mean, color))])
            rows.append(row)
            words = ", ".join("%.3f" % x for x in row["returned"])
            print("| %g, %g, %g | %s | %s | %.3f |" % (*fiber, model, words, row["off"]), flush=True)
    if options.json:
        with open(options.json, "w") as stream:
            json.dump({"asked": asked, "rows": rows}, stream, indent=1)
    print("off by %.3f at most" % max(row["off"] for row in rows))


if __name__ == "__main__":
    main()
