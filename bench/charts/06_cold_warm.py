"""Cold against warm against prebaked: time to a noise, and what a table holds against what the scene asks for.

All three read the same model, so that their noise falls alike; cold pays for learning and for tracing vertices whose rows are not
there yet, warm for reading a cache (left by a render of another seed), prebaked for the whole table first. T(noise) = startup
+ once + passes, as pictures.py says; the passes of a converged table are those of the prebaked render in the same round, and
what a cold render takes beyond them in its N samples is its `once`.
"""
import json
import os

import charts
import pictures

TITLE = "Cold, warm and prebaked tables"

PAPER_BYTES = 20.8e6  # the paper's tables of TRT and GLINT on disk
SCENES = [("curly lock", "light"), ("straight groom", "brown"), ("varied", None)]
WAYS = ("cold", "warm", "prebaked")


def sizes(run):
    return {"samples": 16, "rounds": run.rounds or 1} if run.quick else {"samples": 64, "rounds": run.rounds or 5}


def cache_info(run, path):
    info = json.loads(charts.Done([run.tress, "cache", "info", path, "--json"]).stdout)
    return {"nodes": sum(page["nodes"] for page in info["pages"]), "pages": len(info["pages"]), "rows": info["rows"],
            "bytes": info["bytes"]}


def table_of(done):
    last = done.passes[-1]
    return {"rows": last["rows"], "bytes": last["bytes"], "components": last["components"],
            "g_evaluations": sum(event["g_evaluations"] for event in done.passes),
            "converged_query_share": [event["converged_query_share"] for event in done.passes]}


def measure(run):
    settings = sizes(run)
    result = {"settings": {**settings, "target_noise": pictures.TARGET, "seed": run.seed}, "paper_bytes": PAPER_BYTES, "absent": [],
              "scenes": {}}
    for groom, color in SCENES[::2] if run.quick else SCENES:
        label, size, samples = f"{groom}, {color}" if color else groom, pictures.size_of(groom, run.quick), settings["samples"]
        scene = pictures.scene(run, groom, color)
        if not scene:
            result["absent"].append(label)
            continue
        run.say(label)
        name = os.path.splitext(os.path.basename(scene))[0]
        rivals = [pictures.RIVALS[way] for way in WAYS]
        made, seconds = pictures.tables(run, scene, name, size, samples, rivals)
        known = run.reference(scene, *pictures.OURS, "--resolution", size, samples=32 if run.quick else 64)
        tables, cold_cache = {}, run.path(name + "_cold.cache")

        def one(rival):
            def ask(turn):
                more = ["--warm-cache", cold_cache, "--cache-mode", "scratch"] if rival.name == "cold" else []
                done = pictures.render(run, scene, f"{name}_{rival.name}", rival, size, samples, run.seed + turn, made, *more)
                tables[rival.name] = table_of(done)
                return {**pictures.costs(done, samples), "noise": known.noise_of(done.picture),
                        "learning": sum(event["learning_cpu_seconds"] for event in done.passes)}
            return ask

        found = charts.interleaved({rival.name: one(rival) for rival in rivals}, settings["rounds"], run.seed)
        base = found["prebaked"]["passes"]["values"]
        for way in WAYS:
            mine = found[way]
            mine["extra"] = charts.interval([a - b for a, b in zip(mine["passes"]["values"], base)])
        times = {}
        noise = sum(found[way]["noise"]["median"] for way in WAYS) / len(WAYS)
        for target in (0.3, 0.2, 0.1, 0.05, 0.02, 0.01):
            steady = [a * (noise / target) ** 2 for a in base]
            times[str(target)] = {"steady": charts.interval(steady), **{
                way: charts.interval([max(0.0, extra) / s + 1 for extra, s in zip(found[way]["extra"]["values"], steady)])
                for way in WAYS}, "prebaked and its bake": charts.interval([1 + seconds["baked"] / s for s in steady])}
        result["scenes"][label] = {
            "size": size, "ways": found, "tables": tables, "noise": noise, "over_converged": times, "seconds": seconds,
            "files": {"cold": cache_info(run, cold_cache), "prebaked": cache_info(run, made["baked"])}}
    return result


# ---- drawing --------------------------------------------------------------------------------------------------------

COLORS = ("#d62728", "#1f77b4", "#2ca02c", "#9467bd")


def draw_times(axis, data):
    for color, (label, scene) in zip(COLORS, data["scenes"].items()):
        points = sorted(scene["over_converged"].items(), key=lambda item: -float(item[0]))
        xs = [times["steady"]["median"] for _, times in points]
        for way, line in (("cold", "-"), ("prebaked and its bake", ":")):
            axis.plot(xs, [max(1e-5, times[way]["median"] - 1) for _, times in points], line, color=color, marker="o", markersize=3,
                      linewidth=1.2, label=label if way == "cold" else None)
    axis.plot([], [], "-", color="#555555", label="cold")
    axis.plot([], [], ":", color="#555555", label="prebaked, its bake included")
    axis.axhline(0.02, color="#888888", linewidth=0.8)
    axis.annotate("aim: 1.02", (axis.get_xlim()[1], 0.02), fontsize=7, ha="right", va="bottom", xytext=(0, 2), textcoords="offset points")
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.set_xlabel("CPU seconds of the passes with a converged table\n(points: noise of 30, 20, 10, 5, 2 and 1 %)")
    axis.set_ylabel("extra CPU over it, as a share")
    axis.set_title("Equal noise: what an empty table costs", fontsize=9)
    axis.legend(fontsize=7, loc="lower left", frameon=False)


def bars(axis, data, quantities, unit, title, line=None):
    """quantities: {label: (color, function(scene) -> value)}; side by side, scene by scene, on a log axis."""
    labels, width = list(data["scenes"]), 0.8 / len(quantities)
    top = 0
    for index, (name, (color, value)) in enumerate(quantities.items()):
        values = [value(data["scenes"][label]) for label in labels]
        xs = [x - 0.4 + width * (index + 0.5) for x in range(len(labels))]
        axis.bar(xs, values, width, color=color, label=name)
        top = max([top, *values])
        for x, v in zip(xs, values):
            axis.text(x, v, short(v), ha="center", va="bottom", fontsize=6)
    if line:
        axis.axhline(line[0], color="#000000", linewidth=1, linestyle="--", label=line[1])
        top = max(top, line[0])
    axis.set_yscale("log")
    axis.set_ylim(top=top * 12)
    axis.set_xticks(range(len(labels)), [label.replace(", ", ",\n") for label in labels], fontsize=7)
    axis.set_ylabel(unit)
    axis.set_title(title, fontsize=9)
    axis.legend(fontsize=7, loc="upper left", frameon=False, ncol=2)


def short(value):
    for size, suffix in ((1e6, "M"), (1e3, "k")):
        if value >= size:
            return f"{value / size:.3g}{suffix}"
    return f"{value:.3g}"


def draw_components(axis, data):
    for color, (label, scene) in zip(COLORS, data["scenes"].items()):
        for way, line in (("cold", "-"), ("prebaked", ":")):
            counts = scene["tables"][way]["components"]
            total = max(1, sum(counts))
            axis.plot(range(len(counts)), [100 * c / total for c in counts], line, marker="o", markersize=3, color=color, linewidth=1.2,
                      label=label if way == "cold" else None)
    axis.plot([], [], "-", color="#555555", label="rows the scene asked for")
    axis.plot([], [], ":", color="#555555", label="whole table")
    axis.set_xlabel("components of a converged row")
    axis.set_ylabel("rows, %")
    axis.set_title("Components", fontsize=9)
    axis.legend(fontsize=7, frameon=False)


def draw(data, path):
    chart = charts.Chart(TITLE, columns=2, rows=2, width=5.6, height=4.0)
    draw_times(chart.axes[0], data)
    bars(chart.axes[1], data, {
        "whole grid": ("#c6dbef", lambda s: s["files"]["prebaked"]["nodes"]),
        "touched": ("#6baed6", lambda s: s["tables"]["cold"]["rows"]["touched"]),
        "converged": ("#08519c", lambda s: s["tables"]["cold"]["rows"]["converged"])}, "rows", "Rows: what the scene asked for",
        (2 * 25572, "the paper: 2 x 25,572"))
    bars(chart.axes[2], data, {
        "file, cold": ("#fcae91", lambda s: s["files"]["cold"]["bytes"]),
        "file, whole table": ("#fb6a4a", lambda s: s["files"]["prebaked"]["bytes"]),
        "memory, cold": ("#6baed6", lambda s: s["tables"]["cold"]["bytes"]),
        "memory, whole table": ("#3182bd", lambda s: s["tables"]["prebaked"]["bytes"])}, "bytes", "Size of the table", (data["paper_bytes"], "the paper: 20.8 MB"))
    draw_components(chart.axes[3], data)
    chart.save(path)
