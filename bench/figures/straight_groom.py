#!/usr/bin/env python3
"""One straight groom with e from .85 to 1, with and without the rotation phi_0 of the major axis along the strand.

Without the rotation all of a strand shows the camera one side of its ellipse, so that strands differ as wholes; with it
the glints of flat fibers break up along the strand. A round fiber must not care (last column).
"""
import figures

ECCENTRICITIES = (0.85, 0.9, 0.95, 1.0)
NO_ROTATION_CM = 1000  # curl diameter: a turn in 31 m of strand


def main():
    options = figures.parse(__doc__, samples=96, size="280x380")
    rows = []
    for rotates in (True, False):
        row = []
        for e in ECCENTRICITIES:
            changes = {"eccentricity": e} if rotates else {"eccentricity": e, "curl_diameter_cm": NO_ROTATION_CM}
            name = f"straight_{e:g}_{'turned' if rotates else 'unturned'}"
            scene = figures.variant(options, "scenes/straight_groom.json", name, figures.materials(**changes))
            label = f"e = {e:g}, {'rotating' if rotates else 'no rotation'}"
            row.append((label, figures.read(figures.render(options, scene, name), behind=0.5)))
        rows.append(row)
    figures.sheet(options, "straight_groom", rows)


if __name__ == "__main__":
    main()
