"""Fits src/fiber/lock_color_table.h to the absorptions that `bench_lock_color --json FILE` has measured.

    build/release/bench/bench_lock_color --json lock_color.json
    /usr/bin/python3 bench/figures/lock_color.py lock_color.json src/fiber/lock_color_table.h [--only-untilted]

With --only-untilted the rows of tilted fibers stay as the header has them, to the digit: pictures of theirs do not change.
`bench_lock_color --tilt 0` is then enough.
Of each fiber ln(sigma_a / y), y = -ln(color), is a cubic in the root of y, fitted so that the color is off least. Prints how
far the fit is from what was measured, in units of the color.
"""

import json
import math
import re
import sys

import numpy

TERMS = 4
DARKEST, LIGHTEST = 0.045, 0.985
ABOVE_SURFACE = 0.012  # a color nearer to what the surface alone reflects says nothing of the absorption


def fit(colors, fiber):
    log_sigma = numpy.log(fiber["sigma_a"])
    slope = numpy.abs(numpy.gradient(colors, log_sigma))
    good = (colors > max(DARKEST, fiber["surface"] + ABOVE_SURFACE)) & (colors < LIGHTEST)
    y = -numpy.log(colors)
    powers = numpy.vander(numpy.sqrt(y), TERMS, increasing=True)
    wanted = log_sigma - numpy.log(y)
    coefficients = numpy.linalg.lstsq((powers * slope[:, None])[good], (wanted * slope)[good], rcond=None)[0]
    return coefficients, numpy.abs((powers @ coefficients - wanted) * slope)[good].max()


def array(name, values, comment):
    return f"inline constexpr std::array<double, {len(values)}> {name}{{{', '.join(f'{x:.8g}' for x in values)}}};  ///< {comment}"


def rows_of(header):
    """The table's rows as text."""
    with open(header) as file:
        table = file.read().split("lock_color_table{{")[1]
    return re.findall(r"\{([^{}]+)\}", table)


def tilts_of(header):
    """Of the table's axis, degrees."""
    with open(header) as file:
        axis = re.search(r"lock_color_tilts\{([^{}]+)\}", file.read()).group(1)
    return [round(math.degrees(float(x)), 3) for x in axis.split(",")]


def main(source, header, *options):
    with open(source) as file:
        data = json.load(file)
    colors = numpy.array(data["colors"])
    axes = [sorted({fiber[key] for fiber in data["fibers"]}) for key in ("eta", "tilt_deg", "eccentricity", "roughness")]
    if "--only-untilted" in options:
        axes[1] = tilts_of(header)
    fits = {}
    worst = 0
    for fiber in data["fibers"]:
        key = (fiber["eta"], fiber["tilt_deg"], fiber["eccentricity"], fiber["roughness"])
        fits[key], off = fit(colors, fiber)
        worst = max(worst, off)
    keys = [(a, b, c, d) for a in axes[0] for b in axes[1] for c in axes[2] for d in axes[3]]
    kept = rows_of(header) if "--only-untilted" in options else [None] * len(keys)
    rows = [old if old is not None and key[1] != 0 else ", ".join(f"{x:.4g}" for x in fits[key])
            for key, old in zip(keys, kept, strict=True)]
    lines = [
        "// What a lock's color says of its absorption: made by bench/figures/lock_color.py from `bench_lock_color`.",
        f"// Locks {data['depth']:g} mean free paths deep, {data['paths']} paths a fiber.",
        "#pragma once", "", "#include <array>", "#include <cstddef>", "", "namespace tress::inline v0_2::fiber {", "",
        array("lock_color_etas", axes[0], "indices of refraction"),
        array("lock_color_tilts", [math.radians(x) for x in axes[1]], "radians"),
        array("lock_color_eccentricities", axes[2], "minor over major semi-axis"),
        array("lock_color_log_roughnesses", [math.log(x) for x in axes[3]], "logarithms of alpha"),
        f"inline constexpr std::size_t lock_color_terms = {TERMS};", "",
        "/// By eta, tilt, eccentricity and roughness, the last one fastest: coefficients, from the constant one up, of",
        "/// ln(sigma_a / y) as a polynomial in the root of y = -ln(color).",
        f"inline constexpr std::array<std::array<double, lock_color_terms>, {len(rows)}> lock_color_table{{{{",
    ]
    lines += ["    {" + row + "}," for row in rows]
    lines += ["}};", "", "}  // namespace tress::inline v0_2::fiber", ""]
    with open(header, "w") as file:
        file.write("\n".join(lines))
    print(f"{len(rows)} fibers, the fit is off by {worst:.4f} at most")


if __name__ == "__main__":
    main(*sys.argv[1:])
