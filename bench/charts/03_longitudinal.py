"""The shape of the longitudinal lobe (the paper's section 3.1 and figure 4): logistic, Gaussian, Cauchy. How far the other
two are from the Gaussian, how far all three are from a rough fiber traced in three dimensions, and what they cost."""
import json
import statistics

import charts
import numpy

TITLE = "Longitudinal lobe: logistic, Gaussian, Cauchy"
SHAPES = ("logistic", "gaussian", "cauchy")
STYLES = {"logistic": {"color": "#d62728", "marker": "o"}, "gaussian": {"color": "#1f77b4", "marker": "s"},
          "cauchy": {"color": "#2ca02c", "marker": "^"}, "gaussian, Box-Muller": {"color": "#9ecae1", "marker": "s"}}
DRAWN = (0.1, 30)  # roughness and theta_r of the fiber whose lobes are drawn


def measure(run):
    paths = 60_000 if run.quick else 2_000_000
    shapes = json.loads(run.bench("longitudinal_shapes", "--paths", paths).stdout)
    times = charts.by_name(run.google_benchmark("lobes", "shape_", 0.01 if run.quick else 0.05, 3 if run.quick else 9))
    cost = {shape: {what: times[f"shape_{what}/{shape}"] for what in ("first", "next", "evaluate")} for shape in SHAPES}
    cost["gaussian, Box-Muller"] = {what: times[f"shape_{what}_box_muller"] for what in ("first", "next")}
    for one in shapes["to_fiber"]:
        one["theta_i"] = " ".join(f"{x:.3g}" for x in one["theta_i"])
    return {"settings": {"paths": paths, "distance": "relative squared L2 over theta_i, noise of the traced fiber taken out",
                         "fiber": "round, clear, no tilt, eta 1.55; phi_r does not matter",
                         "gaussian": "exact inversion by Newton's method; Box-Muller with rejection beside it",
                         "cost": "ns of CPU; first: make the lobe, sample it, density there; next: sample, density"},
            "to_gaussian": shapes["to_gaussian"], "to_fiber": shapes["to_fiber"], "cost": cost}


def draw(data, path):
    chart = charts.Chart("Longitudinal lobe (the paper's figure 4 in the first column): relative squared L2 distances and cost",
                         columns=3, rows=2, width=4.8, height=3.9)
    draw_to_gaussian(chart.axes[0], data["to_gaussian"])
    draw_cost(chart.axes[3], data["cost"])
    for axis, kind, title in ((chart.axes[1], "best", "width and shift that fit best"),
                              (chart.axes[4], "rule", "width and shift by the program's rule")):
        draw_to_fiber(axis, data["to_fiber"], kind)
        axis.set_title(f"distance to a traced rough fiber,\n{title}", fontsize=10)
    for axis, lobe in ((chart.axes[2], "TT"), (chart.axes[5], "TRT")):
        draw_lobe(axis, data["to_fiber"], lobe)
    chart.save(path)


def draw_to_gaussian(axis, found):
    for shape in ("logistic", "cauchy"):
        for theta, line in ((0, "-"), (60, "--")):
            rows = [one for one in found if one["theta_r_deg"] == theta]
            axis.plot([one["lambda_deg"] for one in rows], [one[shape]["best"] for one in rows], line, markersize=4, linewidth=1,
                      label=f"{shape}, theta_r {theta}", **STYLES[shape])
    axis.set(yscale="log", xlabel="width of the Gaussian, as logistic scale, degrees", ylabel="least distance to it")
    axis.set_title("distance to the Gaussian at best width\n(paper: two orders of magnitude apart)", fontsize=10)
    axis.grid(True, linewidth=0.3)
    axis.legend(fontsize=7)


def draw_cost(axis, cost):
    samples = numpy.array([1, 2, 4, 8, 16, 32, 64])
    for shape, found in cost.items():
        first, following = found["first"]["median"], found["next"]["median"]
        axis.plot(samples, (first + (samples - 1) * following) / samples, markersize=4, linewidth=1, label=shape, **STYLES[shape])
    axis.set(xscale="log", yscale="log", xlabel="samples of one lobe", ylabel="ns of CPU a sample, with its density")
    axis.set_xticks(samples, [str(n) for n in samples])
    axis.set_yticks([50, 100, 200, 400], ["50", "100", "200", "400"])
    axis.minorticks_off()
    axis.set_title("cost, making the lobe included", fontsize=10)
    axis.grid(True, linewidth=0.3)
    axis.legend(fontsize=7)


def draw_to_fiber(axis, found, kind):
    lobes, alphas = ("R", "TT", "TRT", "TRRT"), sorted({one["alpha"] for one in found})
    ticks = []
    for i, lobe in enumerate(lobes):
        for j, alpha in enumerate(alphas):
            x = i * (len(alphas) + 1) + j
            ticks.append((x, f"{alpha:g}".lstrip("0")))
            for k, shape in enumerate(SHAPES):
                values = [max(one[shape][kind], 1e-4) for one in found if (one["lobe"], one["alpha"]) == (lobe, alpha)]
                at = x + 0.25 * (k - 1)
                axis.vlines(at, min(values), max(values), color=STYLES[shape]["color"], linewidth=0.8)
                axis.plot([at], [statistics.median(values)], linestyle="", markersize=4,
                          label=shape if i + j == 0 else None, **STYLES[shape])
        axis.text(i * (len(alphas) + 1) + 1.5, 2.2, lobe, ha="center", fontsize=9)
    axis.set(yscale="log", ylim=(2e-5, 4), xlabel="roughness alpha (lines: over theta_r 0, 30, 60, 80)", ylabel="distance")
    axis.set_xticks([x for x, _ in ticks], [text for _, text in ticks], fontsize=7)
    axis.grid(True, axis="y", linewidth=0.3)
    axis.legend(fontsize=7, loc="lower center", ncol=3)


def draw_lobe(axis, found, lobe):
    one = next(one for one in found if (one["lobe"], one["alpha"], one["theta_r_deg"]) == (lobe, *DRAWN))
    truth = numpy.array(one["theta_i"].split(), float)
    theta = numpy.linspace(-90, 90, len(truth), endpoint=False) + 90 / len(truth)
    axis.plot(theta, truth, color="black", linewidth=1, label="traced rough fiber")
    for shape in SHAPES:
        axis.plot(theta, lobe_of(shape, *DRAWN[1:], one[shape]["best_lambda_deg"], one[shape]["best_shift_deg"], theta),
                  linewidth=1, color=STYLES[shape]["color"], label=f"{shape}, {one[shape]['best']:.2g}")
    centre = theta[truth.argmax()]
    axis.set(xlim=(max(-90, centre - 45), min(90, centre + 45)), yscale="log", ylim=(truth.max() * 2e-4, truth.max() * 2),
             xlabel="theta_i, degrees", ylabel="share of the light, a degree")
    axis.set_title(f"{lobe}, alpha {DRAWN[0]:g}, theta_r {DRAWN[1]}: best fits and their distance", fontsize=9)
    axis.grid(True, linewidth=0.3)
    axis.legend(fontsize=7)


def lobe_of(shape, theta_r, scale, shift, theta_i):
    """Share of each bin of theta_i, degrees, under a law of that half width in theta_h, cut off at +-90."""
    x = ((theta_i + theta_r) / 2 - shift) / scale
    if shape == "gaussian":
        height = numpy.exp(-0.5 * (x / 1.4971) ** 2)
    elif shape == "cauchy":
        height = 1 / (1 + (x / 1.7627) ** 2)
    else:
        height = 1 / numpy.cosh(x / 2) ** 2
    return height / height.sum()
