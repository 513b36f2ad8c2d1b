#!/usr/bin/env python3
"""The paper's figures 1 and 12: contact sheets of one lock and one groom under several environments.

As the paper: 64 light and 256 BCSDF samples at the first hit, by default with one sample a pixel. The three lights
of the studio and the sky with sun come with the program; latitude-longitude pictures are taken from --environments FOLDER
(every .exr and .hdr in it).
"""
import glob
import os

import figures

LIGHT_SAMPLES, BCSDF_SAMPLES = 64, 256


def main():
    options = figures.parse(__doc__, samples=1, size="200x280",
                            add=lambda parser: parser.add_argument("--environments", metavar="FOLDER"))
    environments = [("three lights", {"studio": True}),
                    ("sky", {"sky": {"sun": {"azimuth_deg": 215, "elevation_deg": 28, "angle_deg": 2,
                                             "irradiance": [2.6, 2.2, 1.7]}}})]
    for file in sorted(glob.glob(os.path.join(options.environments or "", "*.exr")) +
                       glob.glob(os.path.join(options.environments or "", "*.hdr"))):
        environments.append((os.path.splitext(os.path.basename(file))[0], {"file": os.path.abspath(file)}))
    rows = []
    for base in ("curly_lock", "straight_groom"):
        row = []
        for label, environment in environments:
            name = f"environments_{base}_{label.replace(' ', '_')}"
            scene = figures.variant(options, f"scenes/{base}.json", name,
                                    lambda content, light=environment: content.update(environment=light))
            exr = figures.render(options, scene, name, "--light-samples", LIGHT_SAMPLES, "--bcsdf-samples",
                                 BCSDF_SAMPLES)
            row.append((label, figures.read(exr)))
        rows.append(row)
    figures.sheet(options, "environments", rows, f"{LIGHT_SAMPLES} light and {BCSDF_SAMPLES} BCSDF samples")


if __name__ == "__main__":
    main()
