#!/usr/bin/env python3
"""The paper's figure 6: increasingly elliptical fibers. One lock, e = .85, .9, .95 and 1, everything else alike.

Below each picture its TRT layer, where the shape of the cross-section shows first: the caustics of a flat fiber turn with
the strand and glint, those of a round one stand still.
"""
import figures

ECCENTRICITIES = (0.85, 0.9, 0.95, 1.0)


def main():
    options = figures.parse(__doc__, samples=96, size="300x450")
    whole, trt = [], []
    for e in ECCENTRICITIES:
        scene = figures.variant(options, "scenes/curly_lock.json", f"figure6_{e:g}", figures.materials(eccentricity=e))
        exr = figures.render(options, scene, f"figure6_{e:g}")
        whole.append((f"e = {e:g}", figures.read(exr, behind=0.5)))
        trt.append(("TRT (2 stops up)", 4 * figures.read(exr, "TRT")))
    figures.sheet(options, "figure6", [whole, trt])


if __name__ == "__main__":
    main()
