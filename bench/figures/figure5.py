#!/usr/bin/env python3
"""The paper's figure 5: the R lobe alone, with the Fresnel reflectance that each variant gives it.

none: reflectance 1. exact: by the angle of incidence in three dimensions, azimuth and inclination. longitudinal: by the
inclination alone. bravais: eta' and eta'' by the azimuthal angle (Marschner et al. 2003). The first row is as bright as it
is; the second has every picture scaled to the mean of `none`, so that the distribution over the lock can be compared.
"""
import figures


def main():
    options = figures.parse(__doc__, samples=128, size="240x360")
    pictures = []
    for variant in ("none", "exact", "longitudinal", "bravais"):
        scene = figures.variant(options, "scenes/brown_lock.json", f"figure5_{variant}",
                                figures.materials(fresnel=variant))
        exr = figures.render(options, scene, f"figure5_{variant}", "--max-depth", "1")
        pictures.append((variant, figures.read(exr, "R")))
    bright = dict(pictures)["none"].mean()
    scaled = [(f"{name} x {bright / picture.mean():.3g}", picture * (bright / picture.mean())) for name, picture in pictures]
    figures.sheet(options, "figure5", [pictures, scaled], "R, first scattering only")


if __name__ == "__main__":
    main()
