"""What every model's density, energy, weights and error do over slices of the domain: heat maps, and who fails where.
bench/atlas/maps.cpp says what is measured, bench/accuracy/far_field.cpp how the last two slices compare with the traced
rough fiber."""
import concurrent.futures
import json
import math

import charts
import numpy
from matplotlib import colors, patches

TITLE = "Maps of models: density, energy, weights, chi-square, error"
SLICES = ("e", "sigma", "alpha", "eta", "sigma_a", "lambda", "sigma_e")
QUICK_SLICES = ("e", "sigma", "lambda")
# Of chi-square the chance that any cell of a right sampler fails.
FAMILY = 0.001
# What counts as bad, and how it is shown. Scales: lowest and highest color, logarithmic or not.
MEASURES = {
    "mass": ("mass of the pdf", "off 1 by more than .005", (0.95, 1.05, False)),
    "energy": ("energy reflected", "above 1.01", (0.5, 1.5, False)),
    "weight": ("largest weight", "above 10", (1, 100, True)),
    "variance": ("variance of the weight", "above 1", (0.001, 10, True)),
    "p": ("chi-square, p", "below the level", (1e-6, 1, True)),
    "own": ("error against itself", "above .15", (0.001, 1, True)),
    "ellipse": ("error against the ellipse", "above .5", (0.001, 2, True)),
    "truth": ("error against fiber3d", "above .5", (0.01, 2, True)),
    "unsound": ("unsound answers", "any", (0, 1, False)),
}
COLUMNS = ("mass", "energy", "weight", "variance", "p", "own", "ellipse")


def is_bad(measure, value, level, error=0.0):
    """Whether a value fails; `error` of an energy that is noisy, of which three are allowed."""
    if value is None:
        return False
    return {"mass": lambda: abs(value - 1) > 0.005, "energy": lambda: value > 1.01 + 3 * error, "weight": lambda: value > 10,
            "variance": lambda: value > 1, "p": lambda: value < level, "own": lambda: value > 0.15,
            "ellipse": lambda: value > 0.5, "truth": lambda: value > 0.5, "unsound": lambda: value > 0}[measure]()


def measure(run):
    found = {"slices": []}

    def one(name):
        arguments = ["--slice", name, "--seed", max(run.seed, 1), *(["--quick", "--samples", 600] if run.quick else [])]
        part = json.loads(run.bench("atlas_maps", *arguments).stdout)
        run.say(f"slice {name}")
        return part

    # Nothing is timed: side by side.
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        for part in pool.map(one, QUICK_SLICES if run.quick else SLICES):
            found["slices"] += part.pop("slices")
            found.update(part)
    run.say("against fiber3d")
    found["slices"] += against_fiber3d(run)
    return found


def against_fiber3d(run):
    """Two slices of bench_far_field: the whole far field, not normalised, of clear fibers without tilt. Learned rows are
    bench_rough_far_field's, whose cells take turns with the sign of theta_r, phi_r and a tilt of 3 degrees."""
    thetas = (0, 80) if run.quick else (0, 30, 60, 75, 80, 85)
    slices = []
    for name, es, alphas in (("e, whole fiber", (1, 0.5) if run.quick else (1, 0.85, 0.7, 0.5), (0.2,)),
                             ("alpha, whole fiber", (0.85,), (0.05, 0.5) if run.quick else (0.03, 0.1, 0.2, 0.5))):
        ys = es if len(es) > 1 else alphas
        cells = {}
        for bench, options, names in (("far_field", ["--paths", 40_000 if run.quick else 400_000, "--phi", 45], {}),
                                      ("rough_far_field", ["--model", "rough"], {"rough": "rough fitted"})):
            path = run.path(bench + ".json")
            run.bench(bench, *options, "--e", ",".join(map(str, es)), "--alpha", ",".join(map(str, alphas)), "--theta",
                      ",".join(map(str, thetas)), "--json", path)
            with open(path) as file:
                found = json.load(file)
            whole = found["context"]["parts"].index("whole")
            for y in ys:
                for theta in thetas:
                    cell = next(one for one in found["cells"] if abs(one["theta_deg"]) == theta and
                                (abs(one["e"] - y) < 1e-6 if len(es) > 1 else abs(one["alpha"] - y) < 1e-6))
                    for model, errors in cell["models"].items():
                        value = errors["l2"][0][whole]
                        cells.setdefault(names.get(model, model), {}).setdefault("truth", []).append(
                            "-" if value is None else f"{value:.2g}")
        slices.append({"name": name, "x": {"name": "theta_r", "unit": "degrees", "values": thetas},
                       "y": {"name": name.split(",")[0], "unit": "", "values": ys},
                       "cells": {model: {"truth": " ".join(one["truth"])} for model, one in cells.items()}})
    return slices


# ---- what failed ----------------------------------------------------------------------------------------------------

def grid_of(part, rival, name):
    """Values by row of y and column of x; None where no value was measured."""
    text = part["cells"].get(rival, {}).get(name)
    if text is None:
        return None
    values = [None if word == "-" else float(word) for word in text.split()]
    columns = len(part["x"]["values"])
    return [values[k:k + columns] for k in range(0, len(values), columns)]


def level_of(data):
    tests = sum(value is not None for part in data["slices"] for rival in part["cells"]
                for row in grid_of(part, rival, "p") or [] for value in row)
    return -math.expm1(math.log1p(-FAMILY) / max(tests, 1)), tests


def failures(data):
    """{(rival, measure): (bad cells, cells, worst value, where)} over all slices."""
    level, _ = level_of(data)
    found = {}
    for part in data["slices"]:
        for rival in part["cells"]:
            errors = grid_of(part, rival, "error")
            for name in MEASURES:
                for j, row in enumerate(grid_of(part, rival, name) or []):
                    for i, value in enumerate(row):
                        if value is None:
                            continue
                        bad, cells, worst, place = found.get((rival, name), (0, 0, None, ""))
                        error = (errors[j][i] or 0) if errors and name == "energy" else 0
                        if worst is None or badness(name, value) > badness(name, worst):
                            worst = value
                            place = ", ".join(f"{axis['name']} {axis['values'][k]:g}" for axis, k in
                                              ((part["x"], i), (part["y"], j)))
                        found[rival, name] = (bad + is_bad(name, value, level, error), cells + 1, worst, place)
    return found


def badness(name, value):
    return {"mass": abs(value - 1), "p": -value}.get(name, value)


def rivals_of(data):
    names = list(data["rivals"])
    for part in data["slices"]:
        names += [name for name in part["cells"] if name not in names]
    return names


def table(data):
    """Who fails where, in Markdown."""
    found = failures(data)
    lines = ["| | " + " | ".join(MEASURES[name][0] for name in MEASURES) + " |", "|---" * (len(MEASURES) + 1) + "|"]
    for rival in rivals_of(data):
        row = []
        for name in MEASURES:
            bad, cells, worst, place = found.get((rival, name), (0, 0, None, ""))
            row.append("" if cells == 0 else f"0 of {cells} ({worst:.3g})" if bad == 0 else
                       f"**{bad} of {cells}**: {worst:.3g} at {place}")
        lines.append(f"| {rival} | " + " | ".join(row) + " |")
    return "\n".join(lines)


# ---- drawing --------------------------------------------------------------------------------------------------------

def draw(data, path):
    draw_summary(data, path)
    with open(path + ".md", "w") as file:
        file.write(table(data) + "\n")
    for part in data["slices"]:
        suffix = part["name"].replace(", whole fiber", "_fiber3d")
        if "fiber3d" in suffix:
            continue
        draw_slice(data, part, f"{path}_{suffix}")
    draw_truth(data, path + "_fiber3d")


def draw_map(axis, part, grid, name, level, errors=None):
    title, _, (low, high, logarithmic) = MEASURES[name]
    values = numpy.array([[numpy.nan if value is None else value for value in row] for row in grid], float)
    norm = colors.LogNorm(low, high) if logarithmic else colors.Normalize(low, high)
    palette = "RdBu_r" if name in ("mass", "energy") else "Blues_r" if name == "p" else "Blues"
    axis.set_facecolor("#d0d0d0")
    axis.imshow(numpy.clip(values, low, high), norm=norm, cmap=palette, aspect="auto", origin="lower")
    for j, row in enumerate(grid):
        for i, value in enumerate(row):
            if value is None:
                continue
            bad = is_bad(name, value, level, (errors[j][i] or 0) if errors else 0)
            if bad:
                axis.add_patch(patches.Rectangle((i - 0.5, j - 0.5), 1, 1, facecolor="#ffd92f", edgecolor="#d62728",
                                                 hatch="////", linewidth=0.6))
            axis.text(i, j, short(value), ha="center", va="center", fontsize=7.5,
                      color="black", fontweight="bold" if bad else "normal",
                      bbox={"facecolor": "white", "alpha": 0.65, "linewidth": 0, "pad": 0.6})
    axis.set_xticks(range(len(part["x"]["values"])), [f"{x:g}" for x in part["x"]["values"]], fontsize=8)
    axis.set_yticks(range(len(part["y"]["values"])), [f"{y:g}" for y in part["y"]["values"]], fontsize=8)


def short(value):
    if value == 0 or 0.01 <= abs(value) < 1000:
        text = f"{value:.3g}" if abs(value) >= 0.1 else f"{value:.2g}"
        return text[1:] if text.startswith("0.") else text
    return f"{value:.0e}".replace("e-0", "e-").replace("e+0", "e")


def draw_slice(data, part, path):
    level, tests = level_of(data)
    names = [name for name in data["rivals"] if name in part["cells"]]
    unit = {"x": part["x"]["unit"] and ", " + part["x"]["unit"], "y": part["y"]["unit"] and ", " + part["y"]["unit"]}
    title = (f"{part['x']['name']}{unit['x']} (across) by {part['y']['name']}{unit['y']} (up). Yellow, hatched: bad. Gray: not "
             f"resolved, or has none. Chi-square: p below {level:.1g}, a chance of {FAMILY:g} in all {tests} tests")
    chart = charts.Chart(title, columns=len(COLUMNS), rows=len(names), width=3.3, height=1.9)
    chart.figure.suptitle(title, y=0.997, fontsize=14)
    for k, rival in enumerate(names):
        for m, name in enumerate(COLUMNS):
            axis = chart.axes[k * len(COLUMNS) + m]
            grid = grid_of(part, rival, name)
            if grid is None:
                axis.set_facecolor("#d0d0d0")
                axis.set(xticks=[], yticks=[])
                axis.text(0.5, 0.5, "none", ha="center", transform=axis.transAxes, fontsize=7)
            else:
                draw_map(axis, part, grid, name, level, grid_of(part, rival, "error") if name == "energy" else None)
            if k == 0:
                axis.set_title(f"\n\n{MEASURES[name][0]}\nbad: {MEASURES[name][1]}", fontsize=11)
            if m == 0:
                axis.set_ylabel(rival.replace(" ", "\n"), fontsize=11, fontweight="bold")
    if part["name"] == "sigma":
        mark_figure8(chart, part, names)
    chart.save(path)


def mark_figure8(chart, part, names):
    """Figure 8 of the paper: d'Eon with 10 points and with 100, of detectors of one degree."""
    cell = figure8_cell(part)
    for rival in ("deon2011 10", "deon2011 100"):
        if cell is None or rival not in names:
            continue
        axis = chart.axes[names.index(rival) * len(COLUMNS) + COLUMNS.index("own")]
        i, j = cell
        axis.add_patch(patches.Rectangle((i - 0.5, j - 0.5), 1, 1, fill=False, edgecolor="black", linewidth=2))
        axis.set_xlabel("black frame: the paper's figure 8", fontsize=7)


def figure8_cell(part):
    """Column and row of theta_r 20, sigma 1; None if the slice has no such cell."""
    try:
        return part["x"]["values"].index(20), part["y"]["values"].index(1)
    except ValueError:
        return None


def draw_truth(data, path):
    parts = [part for part in data["slices"] if "whole fiber" in part["name"]]
    names = [name for name in rivals_of(data) if any(name in part["cells"] for part in parts)]
    if not parts:
        return
    level, _ = level_of(data)
    chart = charts.Chart("The whole far field against fiber3d, the traced rough fiber (relative L2, clear, phi_r 45, no tilt).\n"
                         "Yellow, hatched: above .5. theta_r, degrees, across; e (alpha .2) or alpha (e .85) up",
                         columns=len(names), rows=len(parts), width=3.0, height=2.3)
    for k, part in enumerate(parts):
        for m, rival in enumerate(names):
            axis = chart.axes[k * len(names) + m]
            draw_map(axis, part, grid_of(part, rival, "truth"), "truth", level)
            if k == 0:
                axis.set_title(rival, fontsize=9)
            if m == 0:
                axis.set_ylabel(part["y"]["name"], fontsize=9)
    chart.save(path)


def draw_summary(data, path):
    found = failures(data)
    names = rivals_of(data)
    chart = charts.Chart("Who fails where: share of cells that are bad, over all slices, and the worst value",
                         width=15, height=0.42 * len(names) + 1.9)
    axis = chart.axes[0]
    for k, rival in enumerate(names):
        for m, name in enumerate(MEASURES):
            bad, cells, worst, place = found.get((rival, name), (0, 0, None, ""))
            share = bad / cells if cells else 0
            color = "#e4e4e4" if cells == 0 else "#b7e1b0" if bad == 0 else matplotlib_red(share)
            axis.add_patch(patches.Rectangle((m, k), 1, 1, facecolor=color, edgecolor="white", linewidth=1.5,
                                             hatch="////" if bad else None))
            text = "" if cells == 0 else f"0 of {cells}, worst {short(worst)}" if bad == 0 else \
                f"{100 * share:.0f} % of {cells}, worst {short(worst)}\n{place}"
            axis.text(m + 0.5, k + 0.5, text, ha="center", va="center", fontsize=6.5,
                      bbox={"facecolor": "white", "alpha": 0.75, "linewidth": 0, "pad": 1} if bad else None)
    axis.set(xlim=(0, len(MEASURES)), ylim=(len(names), 0))
    axis.set_xticks([m + 0.5 for m in range(len(MEASURES))],
                    [f"{title}\nbad: {rule}" for title, rule, _ in MEASURES.values()], fontsize=8)
    axis.set_yticks([k + 0.5 for k in range(len(names))], names, fontsize=9)
    axis.tick_params(length=0, top=True, labeltop=True, bottom=False, labelbottom=False)
    chart.save(path)


def matplotlib_red(share):
    return colors.to_hex(numpy.array([1, 0.85, 0.75]) * (1 - share) + numpy.array([0.84, 0.15, 0.16]) * share)
