#!/usr/bin/env python3
"""Spectra of melanin in three colors, in the three bands of a spectral render (src/base/bands.h), and wave by wave.

usage: bench/figures/spectral.py [--paths] [--cost] [-o FOLDER] [--tress PROGRAM]

Without an option: renders of 24 wavelengths, eight times three as absorptions of three channels, make the picture of the
whole spectrum (CIE 1931, D65, 400 to 700 nm). Prints how far the same renders in colors and in bands are from it, in
blocks of 8 x 8 pixels, and writes a sheet of a dark blond lock. --paths: light that passed a length of pigment, without
renders, also with the best rates of three colors; fits wavelengths and matrix anew. --cost: CPU time of a spectral
render over that of colors, and the variance of both.
"""
import json
import os
import statistics
import sys

import numpy
from scipy.optimize import lsq_linear, minimize, minimize_scalar

import figures

sys.path.insert(0, os.path.join(figures.ROOT, "bench", "image"))
from calibration import cpu_of  # noqa: E402

NM = numpy.arange(380.0, 721, 10)
# CIE 1931, 2 degrees, and the illuminant D65, 380 to 720 nm; of z what is left is 0
X = [.0014, .0042, .0143, .0435, .1344, .2839, .3483, .3362, .2908, .1954, .0956, .0320, .0049, .0093, .0633, .1655, .2904,
     .4334, .5945, .7621, .9163, 1.0263, 1.0622, 1.0026, .8544, .6424, .4479, .2835, .1649, .0874, .0468, .0227, .0114, .0058,
     .0029]
Y = [0, .0001, .0004, .0012, .0040, .0116, .0230, .0380, .0600, .0910, .1390, .2080, .3230, .5030, .7100, .8620, .9540, .9950,
     .9950, .9520, .8700, .7570, .6310, .5030, .3810, .2650, .1750, .1070, .0610, .0320, .0170, .0082, .0041, .0021, .0010]
Z = [.0065, .0201, .0679, .2074, .6456, 1.3856, 1.7471, 1.7721, 1.6692, 1.2876, .8130, .4652, .2720, .1582, .0782, .0422, .0203,
     .0087, .0039, .0021, .0017, .0011, .0008, .0003, .0002] + [0] * 10
D65 = [49.98, 54.65, 82.75, 91.49, 93.43, 86.68, 104.87, 117.01, 117.81, 114.86, 115.92, 108.81, 109.35, 107.80, 104.79, 107.69,
       104.41, 104.05, 100.0, 96.33, 95.79, 88.69, 90.01, 89.60, 87.70, 83.29, 83.70, 80.03, 80.21, 82.28, 78.28, 69.72, 71.61,
       74.35, 61.60]
TO_709 = numpy.array([[3.2406, -1.5372, -.4986], [-.9689, 1.8758, .0415], [.0557, -.2040, 1.0570]])

# src/scene/model/absorption.cpp and src/base/bands.h
EUMELANIN, PHEOMELANIN = numpy.array([.419, .697, 1.37]), numpy.array([.187, .4, 1.05])
BANDS_NM = numpy.array([615.0, 538, 448])
TO_BANDS = numpy.array([[.74, .245, .015], [0, .951, .049], [.035, 0, .965]])


def eumelanin(nm):
    return EUMELANIN[1] * (nm / 550) ** -3.33


def pheomelanin(nm):
    return PHEOMELANIN[1] * (nm / 550) ** -4.75


def sigma(nm, pigment):
    return pigment[0] * eumelanin(nm) + pigment[1] * pheomelanin(nm)


def weights(nm):
    """By channel of Rec. 709: what a wavelength of white light adds; the sum over nm is 1."""
    by = TO_709 @ numpy.array([numpy.interp(nm, NM, numpy.array(c) * D65) for c in (X, Y, Z)])
    return by / by.sum(axis=1, keepdims=True)


FINE = numpy.arange(380.0, 721, 2)
LENGTHS = numpy.concatenate([[0], numpy.geomspace(.02, 60, 60)])
PIGMENTS = [(1, 0), (.8, .6), (.4, 1.2), (0, 1.75)]
LIGHTS = {"white": (1, 1, 1), "lamp": (1, .72, .42), "low sun": (1, .4, .12), "sky": (.3, .55, 1.2), "red": (1, .05, .05),
          "green": (.05, 1, .05), "blue": (.05, .05, 1), "magenta": (1, .1, 1)}


def smooth_light(rgb):
    """The light of this color, over white, that is smoothest: at FINE."""
    bend = numpy.diff(numpy.eye(len(FINE)), 2, axis=0)
    return lsq_linear(numpy.vstack([30 * bend, 1e4 * weights(FINE)]), numpy.r_[numpy.zeros(len(bend)), 1e4 * numpy.array(rgb)],
                      bounds=(0, numpy.inf)).x


def passed(nm, pigment):
    return numpy.exp(-numpy.outer(LENGTHS, sigma(nm, pigment)))


def best_rate(channel, pigment):
    true = (passed(FINE, pigment) @ weights(FINE).T)[:, channel]
    now = EUMELANIN[channel] * pigment[0] + PHEOMELANIN[channel] * pigment[1]
    found = minimize_scalar(lambda rate: abs(numpy.exp(-rate * LENGTHS) - true).max(), bounds=(.3 * now, 2 * now),
                            method="bounded")
    return found.fun


def fit_bands():
    true = numpy.concatenate([passed(FINE, p) @ weights(FINE).T for p in PIGMENTS])

    def parts(q):
        to_bands = numpy.eye(3)
        to_bands[~numpy.eye(3, dtype=bool)] = q[3:] ** 2
        return q[:3], to_bands / to_bands.sum(axis=1, keepdims=True)

    def error(q, power):
        nm, to_bands = parts(q)
        off = abs(numpy.concatenate([passed(nm, p) for p in PIGMENTS]) @ numpy.linalg.inv(to_bands).T - true) / .01
        return numpy.mean(off ** power) ** (1 / power)
    q = numpy.r_[616, 531, 445, .5, .1, .1, .2, .2, .1]
    for power in (16, 16, 60, 60):
        q = minimize(error, q, (power,), method="Nelder-Mead",
                     options={"maxiter": 6000, "xatol": 1e-4, "fatol": 1e-7, "adaptive": True}).x
    return parts(q)


def print_paths():
    to_rgb = numpy.linalg.inv(TO_BANDS)
    print("largest error over all lengths, over the light's largest channel: colors, bands")
    for name, rgb in LIGHTS.items():
        light, line = smooth_light(rgb), f"{name:8}"
        for pigment in ((1, 0), (.4, .4), (0, 1)):
            true = (passed(FINE, pigment) * light) @ weights(FINE).T
            rates = pigment[0] * EUMELANIN + pigment[1] * PHEOMELANIN
            colors = numpy.exp(-numpy.outer(LENGTHS, rates)) * numpy.array(rgb)
            bands = (passed(BANDS_NM, pigment) * (TO_BANDS @ numpy.array(rgb))) @ to_rgb.T
            line += f"  {pigment}: {abs(colors - true).max() / max(rgb):.4f} {abs(bands - true).max() / max(rgb):.4f}"
        print(line)
    print("best rates of three colors, white:", {p: [round(best_rate(c, p), 4) for c in range(3)] for p in ((1, 0), (0, 1))})
    nm, to_bands = fit_bands()
    print("fitted anew:", nm.round(1), to_bands.round(3).tolist())


def scene(absorption, light=1.0, spectral=False):
    light = [float(x) for x in numpy.broadcast_to(light, 3)]
    return {"camera": {"frame": True, "vertical_fov_deg": 26}, "image": {"width": 56, "height": 96},
            "integrator": {"spectral": spectral}, "environment": {"constant": [.4 * x for x in light]},
            "lights": [{"distant": {"direction": [-1, 2, 1], "radiance": [30 * x for x in light], "angle_deg": 20}}],
            "materials": [{"name": "m", "eccentricity": .85, "roughness": .2, **absorption}],
            "grooms": [{"generate": "wavy", "strands": 6000, "radius_cm": .01, "material": "m"}]}


def picture(options, name, made, samples, flags=()):
    file = figures.path(options, name + ".json")
    with open(file, "w") as stream:
        json.dump(made, stream)
    return figures.read(figures.render(options, file, name, "--spp", str(samples), "--warm-cache",
                                       figures.path(options, "rows.cache"), "--cache-mode", "frozen", *flags))


def blocks(pixels):
    return pixels[:96, :56, :3].reshape(12, 8, 7, 8, 3).mean(axis=(1, 3))


def melanin(pigment):
    return {"melanin": {"eumelanin": pigment[0], "pheomelanin": pigment[1]}}


def print_renders(options):
    file = figures.path(options, "teacher.json")
    with open(file, "w") as stream:
        json.dump(scene(melanin((.3, .3))), stream)
    figures.render(options, file, "teacher", "--spp", "64", "--warm-cache", figures.path(options, "rows.cache"))
    nm = 400 + 12.5 * (numpy.arange(24) + .5)
    by = weights(nm)
    for name, pigment, rgb in (("dark blond", (.25, .35), (1, 1, 1)), ("brown", (1.3, 0), (1, 1, 1)),
                               ("red", (0, 1), (1, 1, 1)), ("dark blond, low sun", (.25, .35), (1, .4, .12))):
        key = name.replace(" ", "_").replace(",", "")
        light = numpy.interp(nm, FINE, smooth_light(rgb))
        true = 0
        for group in range(8):
            at = numpy.arange(3) * 8 + group
            part = picture(options, f"{key}_wave{group}", scene({"sigma_a": sigma(nm[at], pigment).tolist()}, light[at]),
                           options.samples // 2, ("--seed", str(100 + group)))
            true = true + part[..., :3] @ by[:, at].T
        colors, bands = (picture(options, key + end, scene(melanin(pigment), rgb, end == "_bands"), options.samples)
                         for end in ("_colors", "_bands"))
        unit = blocks(true).mean(axis=(0, 1)).max()
        for way, pixels in (("colors", colors), ("bands", bands)):
            off = (blocks(pixels) - blocks(true)) / unit
            print(f"{name}: {way}: mean {off.mean(axis=(0, 1)).round(4)}, blocks rms "
                  f"{numpy.sqrt((off ** 2).mean(axis=(0, 1))).round(4)}, largest {abs(off).max():.4f}")
        if key == "dark_blond":
            figures.sheet(options, "spectral", [[("three colors", colors), ("three bands", bands), ("24 wavelengths", true)]])


def print_cost(options):
    cpu, noise = {False: [], True: []}, {False: [], True: []}
    for seed in range(6):
        for spectral in cpu:
            file = figures.path(options, f"cost{spectral}.json")
            with open(file, "w") as stream:
                json.dump(scene(melanin((.25, .35)), spectral=spectral), stream)
            out = figures.path(options, f"cost{spectral}.exr")
            cpu[spectral].append(cpu_of([options.tress, "render", file, "-o", out, "--resolution", "112x192", "--spp", "32",
                                         "--threads", "1", "--quiet", "--seed", str(seed)]))
            noise[spectral].append(figures.read(out)[..., :3])
    ratios = [a / b for a, b in zip(cpu[True], cpu[False])]
    print(f"CPU of bands over colors {statistics.mean(ratios):.3f} +- {statistics.stdev(ratios) / 6 ** .5:.3f}")
    of = {s: numpy.var(noise[s], axis=0, ddof=1).mean(axis=(0, 1)) for s in noise}
    print("variance of bands over colors, R, G, B:", (of[True] / of[False]).round(3))


def main():
    options = figures.parse(__doc__, samples=1024, add=lambda p: (p.add_argument("--paths", action="store_true"),
                                                                 p.add_argument("--cost", action="store_true")))
    if options.paths:
        print_paths()
    elif options.cost:
        print_cost(options)
    else:
        print_renders(options)


if __name__ == "__main__":
    main()
