#!/usr/bin/env python3
"""Figure 8 of the paper: d'Eon et al. with 10 quadrature points and with 100, as pictures and as curves.

usage: bench/figures/figure8.py [-o FOLDER] [--tress PROGRAM] [--azimuth PROGRAM]
figure8.png shows a lock of blond hair under two small lights (figure8.json, detectors of one degree) with 10 and with
100 points: beauty, TRT and TT. figure8_curves.png and .svg show N of TT and TRT against the azimuth with 10, 35 and 100
points beside the exact reference of `tress-lab fit`, and print the relative L2 error of each. With ten points the Gaussians do
not overlap, so that the azimuth has one spike for each: hair glints in stripes and is dark between them.
The curves come from the program bench_azimuth beside tress (`cmake --build build/release --target bench_azimuth`).
"""
import json
import math

import figures
from figures import pyplot

SCENE = "bench/figures/figure8.json"
THETA_DEG = 20


def pictures(options):
    rows = []
    for points in (10, 100):
        # What lights and the hair next to it light: further bounces would hide the stripes.
        exr = figures.render(options, SCENE, f"figure8_{points}", "--model", "deon2011", "--quadrature-points", points,
                             "--max-depth", 3)
        rows.append([(f"{points} points", figures.read(exr)), ("TRT alone", figures.read(exr, "TRT") * 2),
                     ("TT alone", figures.read(exr, "TT") * 2)])
    figures.sheet(options, "figure8", rows, title="d'Eon et al. 2011, TRT and TT twice as bright")


def curve(options, lobe, points, sigma):
    text = figures.run([figures.bench(options, "azimuth"), "deon2011", lobe, str(THETA_DEG), str(sigma), str(points)])
    return json.loads(text)


def reference(options, lobe, sigma, samples):
    """What the traced circle sends where: tress-lab fit's target (a Fourier series, no quadrature of Gaussians)."""
    text = figures.run([options.tress, "fit", "--lobe", lobe, "--e", "1", "--theta-d", str(THETA_DEG), "--phi", "0",
                        "--sigma", str(sigma), "--samples", str(samples), "--json"])
    return json.loads(text)["target"]


def relative_l2(values, truth):
    return math.sqrt(sum((a - b) ** 2 for a, b in zip(values, truth)) / sum(b * b for b in truth))


def curves(options):
    figure, axes = pyplot.subplots(2, 2, figsize=(11, 7), constrained_layout=True)
    for row, (lobe, limits) in enumerate((("TT", (-180, 180)), ("TRT", (-60, 60)))):
        for column, sigma in enumerate((2, 6)):
            plot = axes[row][column]
            for points, style in ((10, "C3-"), (35, "C1-"), (100, "C0-")):
                data = curve(options, lobe, points, sigma)
                truth = reference(options, lobe, sigma, len(data["phi_deg"]))
                error = relative_l2(data["density"], truth)
                plot.plot(data["phi_deg"], data["density"], style, linewidth=1, label=f"{points} points ({error:.1g})")
                print(f"{lobe} {sigma} degrees, {points} points: relative L2 {error:.3g}")
            plot.plot(data["phi_deg"], truth, "k--", linewidth=0.8, label="exact")
            plot.set(xlim=limits, xlabel="phi_i - phi_r, degrees", ylabel="N, 1/rad",
                     title=f"{lobe}, detector {sigma} degrees, theta {THETA_DEG}")
            plot.legend(fontsize=8, title="relative L2 in brackets", title_fontsize=7)
    figures.save_plot(options, "figure8_curves", figure)


def main():
    options = figures.parse(__doc__, samples=64, size="300x400")
    curves(options)
    pictures(options)


if __name__ == "__main__":
    main()
