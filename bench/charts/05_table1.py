"""The paper's table 1: what a render of R, of TT and of TRT with its GLINT takes with ours and with d'Eon's model.

Whole renders of one lobe alone: the gains of all other lobes are 0. *Paths*: one light and one BCSDF sample a vertex and all
bounces, as `tress render` does. *First hit*: the paper's 64 light and 256 BCSDF samples at the first hit and no bounce, so
that a camera ray asks the model 576 times. Noise is the spread of pictures of different seeds about their own mean, each model
against itself; equal noise is CPU times variance. *Vertex*: begin, sample and one light of bench_model_vertices, all lobes.
"""
import numpy

import charts
import figures
import pictures

TITLE = "The paper's table 1: CPU time of a lobe's picture, ours = 1"

PAPER_MINUTES = {"R": (13.13, 13.42, 13.42), "TT": (13.49, 14.42, 14.42), "TRT + GLINT": (16.07, 31.22, 163.13)}
LOBES = {"R": "R", "TT": "TT", "TRT + GLINT": "TRT", "all lobes": None}
MODELS = ("prebaked", "deon2011 10", "deon2011 100")
ALL = ("R", "TT", "TRT", "TRRT", "residual")
FIRST_HIT = ("--light-samples", 64, "--bcsdf-samples", 256, "--max-depth", 1)


def sizes(run):
    if run.quick:
        return {"grooms": [("curly lock", "light")], "rounds": run.rounds or 2, "paths": 12, "first hit": 1}
    return {"grooms": [("curly lock", "light")], "rounds": run.rounds or 5, "paths": 32, "first hit": 2}


def spread(done):
    """Mean variance of a pixel over the squared mean, where there is hair, of pictures of different seeds."""
    pixels = numpy.array([figures.read(picture) for picture in done])
    hair = figures.coverage(done[0]) > 0.5
    return float(pixels.var(axis=0, ddof=1)[hair].mean() / pixels.mean(axis=0)[hair].mean() ** 2)


def measure(run):
    settings = sizes(run)
    result = {"settings": {**settings, "first_hit_flags": list(map(str, FIRST_HIT)), "seed": run.seed},
              "paper_minutes": PAPER_MINUTES, "scenes": {}}
    for groom, color in settings["grooms"]:
        size = pictures.size_of(groom, run.quick)
        scene_result = result["scenes"].setdefault(f"{groom}, {color}", {})
        for lobe, name in LOBES.items():
            material = {"gain": {other: float(other == name) for other in ALL}} if name else {}
            label = f"{groom}_{color}_{name}".replace(" ", "_")
            scene = pictures.scene(run, groom, color, label, **material)
            run.say(label)
            made, _ = pictures.tables(run, scene, label, size, 1, [pictures.RIVALS["prebaked"]])
            for way, more in (("paths", ()), ("first hit", FIRST_HIT)):
                pictures_of = {model: [] for model in MODELS}

                def one(model):
                    def ask(turn):
                        where = f"{label}_{model}_{way}_{turn}".replace(" ", "_")
                        done = pictures.render(run, scene, where, pictures.RIVALS[model], size, settings[way], run.seed + turn,
                                               made, *more)
                        pictures_of[model].append(done.picture)
                        return {"passes": done.pass_cpu, "startup": done.cpu - done.pass_cpu}
                    return ask

                found = charts.interleaved({model: one(model) for model in MODELS}, settings["rounds"], run.seed)
                for model in MODELS:
                    found[model]["variance"] = spread(pictures_of[model])
                    found[model]["equal_samples"] = pictures.ratios(found, model, "passes", "prebaked")
                    share = found[model]["variance"] / found["prebaked"]["variance"]
                    found[model]["equal_noise"] = charts.interval([ratio * share for ratio in found[model]["equal_samples"]["values"]])
                scene_result.setdefault(lobe, {})[way] = found
    vertices = {}
    for _ in range(2 if run.quick else settings["rounds"]):
        for one in run.google_benchmark("model_vertices", "vertex/(elliptical/learned|deon2011)", 0.02 if run.quick else 0.1):
            vertices.setdefault(one["name"].split("vertex/")[1], []).append(one["cpu_time"])
    result["vertex_ns"] = {name: charts.interval(values) for name, values in vertices.items()}
    result["vertex_over_ours"] = {
        name: charts.interval([a / b for a, b in zip(values, vertices["elliptical/learned"])]) for name, values in vertices.items()}
    return result


# ---- drawing --------------------------------------------------------------------------------------------------------

WAYS = {"paths": ("whole paths", "o"), "first hit": ("64 + 256 samples at the first hit", "s")}


def draw_ratios(axis, data, kind, title):
    lobes = list(LOBES)
    for index, model in enumerate(MODELS[1:]):
        color = ("#6baed6", "#08519c")[index]
        points = model.split()[1]
        for way, (label, mark) in WAYS.items():
            for number, (scene, of_lobe) in enumerate(data["scenes"].items()):
                offset = -0.24 + 0.36 * index + (0.14 if way == "first hit" else 0)
                found = [of_lobe[lobe][way][model][kind] for lobe in lobes]
                middles = [one["median"] for one in found]
                bars = [[m - one["low"] for m, one in zip(middles, found)], [one["high"] - m for m, one in zip(middles, found)]]
                axis.errorbar([x + offset + 0.05 * number for x in range(len(lobes))], middles, yerr=bars, fmt=mark, color=color,
                              markersize=5.5, linewidth=1, markerfacecolor=color if number == 0 else "white",
                              label=f"d'Eon {points}, {label}" if number == 0 else None)
        axis.plot([0.06 + 0.36 * index - 0.05 + x - 0.12 for x in range(3)],
                  [data["paper_minutes"][lobe][index + 1] / data["paper_minutes"][lobe][0] for lobe in lobes[:3]], "_", color="#d62728",
                  markersize=22, markeredgewidth=1.6, label="the paper's minutes (10; 100 points)" if index == 0 else None)
    axis.axhline(1, color="#bbbbbb", linewidth=0.8, zorder=0)
    axis.set_yscale("log")
    import matplotlib.ticker as ticker
    axis.yaxis.set_major_locator(ticker.LogLocator(subs=(1, 2, 5)))
    axis.yaxis.set_major_formatter(ticker.FormatStrFormatter("%g"))
    axis.yaxis.set_minor_formatter(ticker.NullFormatter())
    axis.set_ylim(0.4, 14)
    axis.set_xticks(range(len(lobes)), lobes)
    axis.set_ylabel("d'Eon's CPU time over ours")
    axis.set_title(title, fontsize=9)


def draw(data, path):
    chart = charts.Chart(TITLE, columns=3, width=5.0, height=4.4)
    draw_ratios(chart.axes[0], data, "equal_samples", "Equal samples (above 1: ours is faster)")
    draw_ratios(chart.axes[1], data, "equal_noise", "Equal noise (above 1: ours is faster)")
    scenes = list(data["scenes"])
    chart.axes[0].legend(fontsize=7, loc="upper left", frameon=False)
    if len(scenes) > 1:
        chart.axes[1].text(0.02, 0.98, f"filled: {scenes[0]}\nopen: {scenes[1]}", transform=chart.axes[1].transAxes, va="top", fontsize=7.5)
    axis = chart.axes[2]
    names = ["elliptical/learned", "deon2011/10", "deon2011/35", "deon2011/100"]
    labels = [{"elliptical/learned": "ours, learned"}.get(name, name.replace("deon2011/", "d'Eon, ") + " points") for name in names]
    middles = [data["vertex_ns"][name]["median"] for name in names]
    axis.bar(range(len(names)), middles, color=["#d62728", "#6baed6", "#3182bd", "#08519c"],
             yerr=[[m - data["vertex_ns"][n]["low"] for m, n in zip(middles, names)],
                   [data["vertex_ns"][n]["high"] - m for m, n in zip(middles, names)]])
    for x, name in enumerate(names):
        axis.text(x, data["vertex_ns"][name]["high"], f"x {data['vertex_over_ours'][name]['median']:.2f}", ha="center", va="bottom", fontsize=8)
    axis.set_ylim(0, 1.15 * max(data["vertex_ns"][name]["high"] for name in names))
    axis.set_xticks(range(len(names)), labels, fontsize=8)
    axis.set_ylabel("CPU ns a vertex (sample, pdf and one light)")
    axis.set_title("Scattering alone, all lobes, without a ray", fontsize=9)
    chart.save(path)
