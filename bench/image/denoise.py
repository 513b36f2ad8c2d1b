#!/usr/bin/env python3
"""What tress denoise brings: squared error of the filtered picture over that of the picture as it was, scene by scene.

usage: bench/image/denoise.py [BUILD] [-o FILE] [--folder FOLDER] [--only NAME]...

Crops of 80 x 80 pixels of 16 and 64 samples a pixel, held against 160 (straight: 512) of another seed; the expected square of the
reference's own noise, by its halves, is taken off. The standard error of what is found is by blocks of the picture. `straight` and
`curly` are what the filter's constants were chosen on; the others are not. Pictures that FOLDER has are not rendered again. Writes JSON;
some 3 minutes of CPU a scene. Needs numpy.
"""
import argparse
import json
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "scenes", "blender", "tress_render"))
import numpy as np  # noqa: E402

import files  # noqa: E402

DATA = os.path.join(os.path.dirname(ROOT), "shared", "data")
SCENES = {
    "straight": ("scenes/straight_groom.json", "--resolution", "400x500", "--crop", "150,200,230,280"),
    "curly": ("scenes/curly_lock.json", "--resolution", "200x600", "--melanin", "0.1,0.3", "--crop", "60,250,140,330"),
    "bear": ("grooms/bear.hair", "--resolution", "400x500", "--up", "y", "--melanin", "1.3,0", "--crop", "160,200,240,280"),
    "demo": ("scenes/demo.json", "--resolution", "512x512", "--crop", "200,200,280,280"),
    "wavy": ("scenes/wavy.json", "--resolution", "400x500", "--crop", "160,210,240,290"),
    "fur": ("scenes/fur_ball.json", "--resolution", "360x360", "--crop", "40,140,120,220"),
}
CHOSEN_ON = ("straight", "curly")
LAYERS = "albedo,N,tangent,Z,coverage,variance,half"


def colors(channels, layer=""):
    return np.stack([channels[layer + c].astype(float) for c in "RGB"], 2)


def render(tress, name, what, samples, seed, folder):
    picture = os.path.join(folder, f"{name}.{what}.exr")
    if not os.path.exists(picture):
        scene, *flags = SCENES[name]
        source = next(path for path in (os.path.join(ROOT, scene), os.path.join(DATA, scene)) if os.path.exists(path))
        subprocess.run([tress, "render", source, *flags, "-o", picture, "--spp", str(samples), "--seed", str(seed), "--layers", LAYERS,
                        "--precision", "float", "--threads", "1", "--quiet", "--warm-cache", os.path.join(folder, name + ".cache")],
                       check=True)
    return picture


def measured(tress, name, folder):
    reference = files.read_exr(render(tress, name, "ref", 512 if name == "straight" else 160, 9, folder)).channels
    truth, own = colors(reference), (colors(reference, "half_a.") - colors(reference, "half_b.")) ** 2 / 4
    weight = 1 / (truth ** 2 + 0.01 * truth.mean() ** 2)

    def errors(picture):
        squares = (colors(files.read_exr(picture).channels) - truth) ** 2 - own
        off = np.sqrt(max(squares.mean(), 0)) / truth.mean()
        blocks = squares.mean(2).reshape(8, 10, 8, 10).mean((1, 3))  # of 10 x 10 pixels, past the filter's reach
        return (squares * weight).mean(), off, blocks.std(ddof=1) / 8 / (2 * off * truth.mean() ** 2)

    entry = {"scene": name, "chosen_on": name in CHOSEN_ON, "samples": []}
    for what, samples, seed in (("t16", 16, 1), ("t64", 64, 2)):
        noisy, clean = render(tress, name, what, samples, seed, folder), os.path.join(folder, f"{name}.{what}.clean.exr")
        done = subprocess.run([tress, "denoise", noisy, "-o", clean, "--precision", "float", "--threads", "1"], check=True,
                              capture_output=True, text=True)
        reported = float(re.search(r"off by ([0-9.e-]+) of", done.stderr)[1])
        (before, off_before, _), (after, off_after, uncertain) = errors(noisy), errors(clean)
        entry["samples"].append({"samples": samples, "relative_mse": before, "denoised_relative_mse": after, "off": off_before,
                                 "denoised_off": off_after, "denoised_off_error": uncertain, "reported": reported})
        print(f"{name:9} {samples:3} samples: {before:.4f} -> {after:.4f}, {before / after:.1f} times less; root mean square "
              f"{off_before:.3f} -> {off_after:.3f} +- {uncertain:.3f} of the mean, reported {reported:.3f}", flush=True)
    return entry


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?", default=os.path.join(ROOT, "build", "release"))
    parser.add_argument("-o", "--output", default=os.path.join(ROOT, "bench", "results", "denoise.json"))
    parser.add_argument("--folder", default=os.path.join(ROOT, "build", "denoise"))
    parser.add_argument("--only", action="append", choices=SCENES)
    options = parser.parse_args()
    os.makedirs(options.folder, exist_ok=True)
    git = subprocess.run(["git", "-C", ROOT, "rev-parse", "HEAD"], capture_output=True, text=True)
    found = {"context": {"commit": git.stdout.strip(), "load": os.getloadavg()[0]}, "scenes": []}
    for name in options.only or SCENES:
        found["scenes"].append(measured(os.path.join(os.path.abspath(options.build), "tress"), name, options.folder))
        with open(options.output, "w") as out:
            json.dump(found, out, indent=1)
            out.write("\n")


if __name__ == "__main__":
    main()
