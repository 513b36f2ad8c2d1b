"""Learning: the error of rows against what they have cost, how many have converged, and the paper's figures 7, 9 and 10 on
its own rows. bench/accuracy/learning.cpp and pekelis_rows.cpp say what exactly is measured."""
import json

import charts
import numpy
from matplotlib.colors import LogNorm

TITLE = "Learning: error against samples, vertices and CPU; the paper's figures 7, 9 and 10"
LEARNERS = ("eager", "ais", "table", "em", "appendix", "appendix-literal", "sketch")  # the last is drawn on top
DOMAINS = {"wide": "sigma 5 to 25 degrees, e .7 to 1", "narrow": "sigma 1 to 10 degrees, e .7 to 1"}
MAPPED = ("sketch", "ais", "em", "appendix")
BINS = numpy.logspace(-7, 1, 81)  # of pekelis_rows' histograms
PAPER = (0.1, 0.82)  # of its rows are below .1 (figure 7)


def measure(run):
    rows, rounds = (120, 1) if run.quick else (600, 3)
    runs = {}

    def curve(domain, learner):
        def once(_):
            found = json.loads(run.bench("learning", "--rows", rows, "--domain", domain, "--learner", learner).stdout)
            runs[domain, learner] = found  # but for CPU times every round finds the same
            return {"cpu_us": found["passes"][-1]["cpu_us"]}
        return once

    cpu = charts.interleaved({(domain, learner): curve(domain, learner) for domain in DOMAINS for learner in LEARNERS}, rounds)
    curves = {}
    for (domain, learner), found in runs.items():
        whole = cpu[domain, learner]["cpu_us"]
        scale = whole["median"] / found["passes"][-1]["cpu_us"]  # of the last round's course
        curves.setdefault(domain, {})[learner] = {
            "cpu_us": whole, "false": found["false"], "below_a_hundredth": found["below_a_hundredth_share"],
            "passes": [{**{key: one[key] for key in ("vertices", "own", "g", "converged", "refused")},
                        "cpu_us": one["cpu_us"] * scale, **one["error"]} for one in found["passes"]]}
    return {"settings": {"rows": rows, "rounds": rounds, "epsilon": 0.01, "domains": DOMAINS,
                         "error": "relative squared L2 of every row's fit against its own g, converged or not; without a fit 1",
                         "paper_rows": "Marschner's TRT on the paper's grid, unblurred, error of its section 7.1 (mean over 2 pi)"},
            "curves": curves, "paper": paper_rows(run)}


def paper_rows(run):
    def rows_of(without, *flags):
        target = run.path("rows.json")
        run.bench("pekelis_rows", "--lobe", "TRT", "--json", target, *flags)
        with open(target) as file:
            found = json.load(file)[0]
        found["histogram"] = " ".join(map(str, found.pop("histogram_from_1e-7_ten_a_decade")))
        found["components"] = " ".join(map(str, found["components"]))
        return {key: value for key, value in found.items() if key not in without}

    curves, both = ("curves",), ("curves", "maps")
    found = {"all": {"sketch": rows_of(curves, "--grid", "all", "--stride", 6 if run.quick else 1)}, "fixed": {}, "hardest": {}}
    for learner in LEARNERS:
        if learner != "sketch":
            found["fixed"][learner] = rows_of(both, "--rows", 120 if run.quick else 1000, "--learner", learner)
        if learner in MAPPED:
            stride = 4 if run.quick else 1 if learner == "sketch" else 2
            found["hardest"][learner] = rows_of((), "--grid", "hardest", "--stride", stride, "--learner", learner)
    return found


def draw(data, path):
    draw_curves(data, path)
    draw_histogram(data["paper"], path + "_figure7")
    draw_hardest(data["paper"]["hardest"], path + "_figure9")
    draw_maps(data["paper"]["all"]["sketch"]["maps"], path + "_figure10")


def draw_curves(data, path):
    settings = data["settings"]
    chart = charts.Chart(f"Learning of {settings['rows']} random rows of TT, TRT and TRRT, epsilon {settings['epsilon']}: median "
                         "error of all rows' fits (thin: 99 %), and rows that are answered by their fit", columns=4, rows=2,
                         width=4.1, height=3.9)
    for row, (domain, title) in enumerate(settings["domains"].items()):
        for column, (quantity, label) in enumerate((("g", "samples: evaluations of g a row, of all kinds"),
                                                    ("vertices", "vertices a row, until it converges"),
                                                    ("cpu_us", "learning, us of CPU a row"))):
            axis = chart.axes[4 * row + column]
            for learner in LEARNERS:
                passes = data["curves"][domain][learner]["passes"]
                x = [one[quantity] for one in passes]
                look = charts.style(learner)
                axis.plot(x, [one["p50"] for one in passes], markersize=3, linewidth=1, label=learner, **look)
                if len(passes) > 1:
                    axis.plot(x, [one["p99"] for one in passes], linewidth=0.5, alpha=0.6, color=look["color"])
                else:
                    axis.vlines(x, passes[0]["p50"], passes[0]["p99"], linewidth=0.5, color=look["color"])
            axis.set(xscale="log", yscale="log", ylim=(1e-5, 3), xlabel=label, ylabel="relative squared L2 error")
            axis.set_title(title, fontsize=9)
            axis.axhline(settings["epsilon"], color="#999999", linestyle=":", linewidth=1)
            axis.grid(True, linewidth=0.3)
        axis = chart.axes[4 * row + 3]
        for learner in LEARNERS:
            passes = data["curves"][domain][learner]["passes"]
            axis.plot([one["vertices"] for one in passes], [one["converged"] for one in passes], markersize=3, linewidth=1,
                      label=learner, **charts.style(learner))
        axis.set(xscale="log", ylim=(-0.02, 1.05), xlabel="vertices a row, until it converges", ylabel="share of rows converged")
        axis.set_title(title, fontsize=9)
        axis.grid(True, linewidth=0.3)
    chart.axes[0].text(12, 0.0107, "epsilon", fontsize=7, color="#666666")
    chart.axes[3].legend(fontsize=7, loc="upper left", bbox_to_anchor=(1.02, 1.0), borderaxespad=0)
    chart.save(path)


def draw_histogram(paper, path):
    ours = paper["all"]["sketch"]
    chart = charts.Chart("The paper's figure 7: errors of fits to Marschner's TRT on its grid, D = 5 components (table: knots)",
                         columns=2, width=6.4, height=4.2)
    shown = {"sketch": ours, **paper["fixed"]}
    for learner in (*LEARNERS[:-1], "sketch"):
        found = shown[learner]
        counts = numpy.array(found["histogram"].split(), float)
        color = charts.style(learner)["color"]
        label = f"{learner}, {found['rows'] + found['without_light']:.0f} rows: {100 * found['below_a_tenth_share']:.1f} % below .1"
        chart.axes[0].stairs(100 * counts / counts.sum(), BINS, color=color, linewidth=1.2)
        chart.axes[1].plot(BINS[1:], 100 * numpy.cumsum(counts) / counts.sum(), color=color, linewidth=1.2, label=label)
    for axis in chart.axes:
        axis.axvline(PAPER[0], color="black", linestyle=":", linewidth=1)
        axis.set(xscale="log", xlim=(1e-5, 10), xlabel="relative error of section 7.1, squared L2")
        axis.grid(True, linewidth=0.3)
    chart.axes[0].set(ylabel="% of rows, a tenth of a decade")
    chart.axes[1].plot([PAPER[0]], [100 * PAPER[1]], "k*", markersize=11, label="the paper: 82 % below .1")
    chart.axes[1].set(ylabel="% of rows below the error")
    chart.axes[1].legend(fontsize=7, loc="upper left", bbox_to_anchor=(1.02, 1.0), borderaxespad=0)
    chart.save(path)


def grid_of(found):
    """A page's errors, [phi_r][theta_d]; nan where there is no light."""
    lines = [[float("nan") if word == "-" else 10 ** (int(word) / 100) for word in line.split()]
             for line in found["log10_error_x100"]]
    return numpy.array(lines)


def heat(axis, found):
    errors = grid_of(found)
    return axis.imshow(errors, origin="lower", aspect="auto", cmap="turbo", norm=LogNorm(1e-4, 1), extent=(0, 90, 0, 90),
                       interpolation="nearest")


def draw_hardest(hardest, path):
    learners = [learner for learner in MAPPED if learner in hardest]
    chart = charts.Chart("The paper's figure 9: TRT, e .85, sigma 10 degrees, the hardest page. Errors over the table, and fits "
                         "(colored) of its best row, quartiles and worst row against the target (black)",
                         columns=len(learners), rows=3, width=4.2, height=3.0)
    for column, learner in enumerate(learners):
        found = hardest[learner]
        axis = chart.axes[column]
        image = heat(axis, found["maps"][0])
        axis.set(xlabel="theta_d, degrees", ylabel="phi_r, degrees")
        axis.set_title(f"{learner}: median {found['error']['p50']:.2g}, worst {found['error']['max']:.2g}", fontsize=9)
        chart.figure.colorbar(image, ax=axis, label="relative squared L2")
    for row, learner in enumerate(("sketch", "ais")):
        for column, (name, one) in enumerate(zip(("best", "25 %", "75 %", "worst"), hardest[learner]["curves"])):
            axis = chart.axes[(row + 1) * len(learners) + column]
            truth, fit = (numpy.array(one[key].split(), float) for key in ("truth", "fit"))
            phi = numpy.linspace(-180, 180, len(truth))
            axis.plot(phi, truth, color="black", linewidth=1.4, label="target")
            axis.plot(phi, fit, color=charts.style(learner)["color"], linewidth=1, label=f"{learner}, {one['components']} components")
            axis.set(xlabel="phi_i - phi_r, degrees", ylabel="N, 1/rad", xticks=range(-180, 181, 90))
            axis.set_title(f"{learner}, {name}: {one['error']:.2g} at phi_r {one['phi_r_deg']}, theta_d {one['theta_d_deg']}", fontsize=9)
            axis.legend(fontsize=7)
            axis.grid(True, linewidth=0.3)
    chart.save(path)


def draw_maps(maps, path):
    chart = charts.Chart("The paper's figure 10: relative squared L2 errors of sketch over all of its rows of TRT (degrees; a "
                         "circle has one phi_r)", columns=4, rows=4, width=3.0, height=2.4)
    for axis, found in zip(chart.axes, maps):
        image = heat(axis, found)
        errors = grid_of(found)
        axis.set_title(f"e {found['e']:g}, sigma {found['sigma_deg']:g}: median {numpy.nanmedian(errors):.2g}, "
                       f"worst {numpy.nanmax(errors):.2g}", fontsize=7)
        axis.set_xlabel("theta_d", fontsize=7)
        axis.set_ylabel("phi_r", fontsize=7)
        axis.tick_params(labelsize=6)
        chart.figure.colorbar(image, ax=axis).ax.tick_params(labelsize=6)
    chart.save(path)
