"""Adversarial queries: every model under every estimator, asked at the exact corners of all coordinates, one float beside
them, near them on a logarithmic scale and anywhere. How many answers are not finite, negative, without a density, not what
sample() said, out of range, or weighted above what is owed."""
import json

import charts
import matplotlib.colors
import numpy

TITLE = "Adversarial queries: who fails where"
KINDS = ("not finite", "negative S", "bad pdf", "light without pdf", "sample != evaluate", "bad direction",
         "weight over bound", "bad event")
THETAS = [f"{10 * i}..{10 * i + 10}" for i in range(8)] + ["80..89.5", "pole"]
SIGMAS = ((0, 3.99, "< 4"), (3.99, 4.02, "4"), (4.02, 15, "..15"), (15, 44.9, "..45"), (44.9, 181, "45"))
ES = ((0.4, 0.501, ".5"), (0.501, 0.85, "..85"), (0.85, 0.999, "..1"), (0.999, 1.1, "1"))


def measure(run):
    queries, fibers = (400_000, 48) if run.quick else (150_000_000, 64)
    found = json.loads(run.bench("atlas_queries", "--queries", queries, "--fibers", fibers, "--seed", run.seed).stdout)
    for case in found["cases"]:
        case["by_shape"] = by_shape(case.pop("by_fiber"))
        case["bad_by_theta"] = [sum(bad.values()) for bad in case["bad_by_theta"]]
    return {"settings": {"queries": queries, "fibers": fibers, "seed": run.seed,
                         "events": "one sample, its direction again, through the world and back, five adversarial directions",
                         "flush to zero": "every second block of 512 events",
                         "weight bound": "ours: by what its rows propose (tests/models/query_checks.h); chiang2016, deon2011: "
                                         "1; the others are not normalised: 100"},
            "cases": found["cases"]}


def by_shape(fibers):
    """Queries and bad ones by bins of e (rows) and sigma of TRT (columns)."""
    table = {"queries": numpy.zeros((len(ES), len(SIGMAS)), int), "bad": numpy.zeros((len(ES), len(SIGMAS)), int)}
    for e, sigma, queries, bad in fibers:
        row = next(i for i, (low, high, _) in enumerate(ES) if low <= e < high)
        column = next(i for i, (low, high, _) in enumerate(SIGMAS) if low <= sigma < high)
        table["queries"][row, column] += queries
        table["bad"][row, column] += bad
    return {name: values.tolist() for name, values in table.items()}


def draw(data, path):
    cases = data["cases"]
    chart = charts.Chart("Adversarial queries: share of answers that are wrong (white: none of those asked)", columns=3, rows=1,
                         width=6.6, height=2.2 + 0.42 * len(cases))
    names = [f"{case['case']}\n{count(case['queries'])}" for case in cases]
    kinds = numpy.array([[case["bad"].get(kind, 0) / max(case["queries"], 1) for kind in KINDS] for case in cases])
    heat(chart.axes[0], kinds, names, KINDS, "by what is wrong (queries below the name)")
    # A query of an inclination: events are asked eight times each, or once where a model can only be sampled.
    theta = []
    for case in cases:
        each = case["queries"] / max(case["events"], 1)
        theta.append([bad / max(events * each, 1) for bad, events in zip(case["bad_by_theta"], case["events_by_theta"])])
    heat(chart.axes[1], numpy.array(theta), [weight(case) for case in cases], THETAS,
         "by |theta_r|, degrees (left: largest weight S/Q)")
    shape, columns = [], [f"e {e[2]}, {s[2]}" for e in ES for s in SIGMAS]
    for case in cases:
        queries, bad = numpy.array(case["by_shape"]["queries"], float), numpy.array(case["by_shape"]["bad"], float)
        shape.append(numpy.where(queries > 0, bad / numpy.maximum(queries, 1), numpy.nan).ravel())
    heat(chart.axes[2], numpy.array(shape), ["" for _ in cases], columns, "by e and sigma of TRT, degrees (grey: not asked)",
         text=False)
    chart.save(path)


def heat(axis, rates, rows, columns, title, text=True):
    colors = matplotlib.colormaps["YlOrRd"].copy()
    colors.set_bad("#cccccc")
    colors.set_under("white")
    shown = numpy.where(rates > 0, rates, numpy.where(numpy.isnan(rates), numpy.nan, 1e-12))
    axis.imshow(shown, cmap=colors, norm=matplotlib.colors.LogNorm(1e-8, 1), aspect="auto")
    for i, row in enumerate(rates):
        for j, rate in enumerate(row):
            if text and rate > 0:
                axis.text(j, i, f"{rate:.0e}".replace("e-0", "e-"), ha="center", va="center", fontsize=7,
                          color="white" if rate > 0.02 else "black")
    axis.set_xticks(range(len(columns)), columns, fontsize=7, rotation=60, ha="right")
    axis.set_yticks(range(len(rows)), rows, fontsize=7)
    axis.set_xticks(numpy.arange(len(columns) + 1) - 0.5, minor=True)
    axis.set_yticks(numpy.arange(len(rows) + 1) - 0.5, minor=True)
    axis.grid(which="minor", color="#dddddd", linewidth=0.5)
    axis.tick_params(which="minor", length=0)
    axis.set_title(title, fontsize=9)


def count(queries):
    return f"{queries / 1e6:.3g} M" if queries >= 1e6 else f"{queries / 1e3:.3g} k"


def weight(case):
    return f"{case['largest_weight']:.3g}" if case["largest_weight"] > 0 else "-"
