#!/usr/bin/env python3
"""The paper's figure 3: azimuthal TRT (blue) and GLINT (red) against the eccentricity, darker towards e = 1.

Three panels, polar, the angle being the azimuth from the known direction, the radius the density: the traced ellipse
(elliptical, exact), Marschner et al. 2003, and pekelis2015's fits to Marschner's functions, which its own attenuation
multiplies. Clear hair, one known direction. Needs bench_azimuthal_curves beside tress (target `bench_azimuthal_curves`).
"""
import json

import numpy

import figures

MODELS = (("traced", "traced ellipse (ours)"), ("marschner2003", "Marschner et al. 2003"),
          ("pekelis2015", "Pekelis et al. 2015, fitted"))


def main():
    def add(parser):
        parser.add_argument("--theta", default="0", help="inclination, degrees (%(default)s)")
        parser.add_argument("--phi", default="40", help="known azimuth from the major axis, degrees (%(default)s)")
        parser.add_argument("--sigma", default="15", help="azimuthal width, degrees (%(default)s)")

    options = figures.parse(__doc__, add=add)
    program = figures.bench(options, "azimuthal_curves")
    curves = json.loads(figures.run([program, "--theta", options.theta, "--phi", options.phi, "--sigma", options.sigma]))
    azimuth = numpy.radians(curves["phi_deg"])
    figure, axes = figures.pyplot.subplots(1, 3, figsize=(13, 5), subplot_kw={"projection": "polar"})
    for panel, (model, title) in zip(axes, MODELS):
        for curve in curves["curves"]:
            if curve["model"] != model:
                continue
            shade = 0.3 + 0.7 * (curve["e"] - 0.85) / 0.15
            for lobe, map_ in (("TRT", "Blues"), ("GLINT", "Reds")):
                panel.plot(azimuth, curve[lobe], color=figures.matplotlib.colormaps[map_](shade), linewidth=1.2,
                           label=f"{lobe}, e {curve['e']:.2f}")
        panel.set_title(title, fontsize=10)
        panel.tick_params(labelsize=7)
        panel.set_rlabel_position(100)
    largest = max(panel.get_rmax() for panel in axes)
    for panel in axes:
        panel.set_rmax(largest)
    axes[1].legend(loc="upper center", bbox_to_anchor=(0.5, -0.08), ncol=4, fontsize=7)
    figure.suptitle(f"theta {options.theta}, known azimuth {options.phi}, sigma {options.sigma} degrees; 1/rad", fontsize=9)
    figure.tight_layout()
    figures.save_plot(options, "figure3", figure)


if __name__ == "__main__":
    main()
