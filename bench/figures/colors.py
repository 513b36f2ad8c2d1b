#!/usr/bin/env python3
"""One lock from black to white hair, by the names of natural hair: the picture of scenes/README.md (scenes/colors.png).

With --lock ../shared/data/grooms/straight.hair no picture: the color (linear) that the middle of that groom returns in
constant light 1, as bench/figures/asked_colors.py has it, for each name.
"""
import json
import os

import figures

COLORS = ["black", "dark brown", "brown", "light brown", "auburn", "red", "blond", "platinum", "grey", "white"]
CROP = "32,40,48,56"


def print_returned(options):
    for name in COLORS:
        scene = {"environment": {"constant": [1, 1, 1]}, "grooms": [{"file": os.path.abspath(options.lock), "up": "z"}],
                 "materials": [{"name": "lock", "hair": name}]}
        file = figures.path(options, "returned.json")
        with open(file, "w") as stream:
            json.dump(scene, stream)
        exr = figures.render(options, file, "returned_" + name.replace(" ", "_"), "--resolution", "80x80", "--crop", CROP,
                             "--spp", "8")
        pixels = figures.read(exr)
        if pixels.shape[0] > 16:  # the data window of a crop may be the whole
            pixels = pixels[40:56, 32:48]
        print("%-12s" % name, ", ".join("%.2f" % x for x in pixels.reshape(-1, 3).mean(axis=0)))


def main():
    options = figures.parse(__doc__, samples=48, size="104x160", add=lambda p: p.add_argument("--lock"))
    if options.lock:
        print_returned(options)
        return
    cells = []
    for name in COLORS:
        exr = figures.render(options, "scenes/brown_lock.json", "color_" + name.replace(" ", "_"), "--hair", name, "--denoise")
        cells.append((name, figures.read(exr, "denoised")))
    figures.sheet(options, "colors", [cells])


if __name__ == "__main__":
    main()
