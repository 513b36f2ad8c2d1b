"""Where the time of a render goes: the renderer's own rays, shading events and light draws, replayed part by part.

bench_replay (bench/image/replay.cpp) does it, on one thread. `limit` is everything but scattering: a free BCSDF. Of rays,
Embree's own share (traversal and ribbons) is separated from ours (silhouette filter, frames of hits) by the program counter.
Learning is what a cold render takes beyond the same render with the table that it taught, traces of nodes included.
"""
import json

import charts

TITLE = "Where the time goes"
MINUTE = 60.0
AIMS = {"scattering": 0.15, "learning": 0.01}

# name: scene, flags of bench_replay
CASES = {
    "curly_lock, blond": ("scenes/curly_lock.json", ["--width", 180, "--height", 240]),
    "straight_groom, brown": ("scenes/straight_groom.json", ["--width", 180, "--height", 240]),
    "straight.hair, brown": ("grooms/straight.hair", ["--width", 200, "--height", 200, "--melanin", 1.3]),
    "straight.hair, blond": ("grooms/straight.hair", ["--width", 200, "--height", 200, "--melanin", 0.3]),
    "bear.hair, brown": ("grooms/bear.hair", ["--width", 200, "--height", 200, "--melanin", 1.3, "--up", "y"]),
    "bear.hair, blond": ("grooms/bear.hair", ["--width", 200, "--height", 200, "--melanin", 0.3, "--up", "y"]),
}
QUICK_CASES = ("curly_lock, blond", "straight.hair, blond")
# Samples that teach the table, rounds, and seconds of every look at the program counter; pixels over those of CASES
FULL = {"teach": 32, "repeat": 11, "inside": 2, "scale": 1}
QUICK = {"teach": 4, "repeat": 3, "inside": 0.3, "scale": 0.5}

# Parts of a bar, from the left: label, color
PARTS = {
    "camera rays, Embree": "#1f4e79", "camera rays, ours": "#8db4dd",
    "continuation rays, Embree": "#1b7837", "continuation rays, ours": "#a6dba0",
    "shadow rays, Embree": "#762a83", "shadow rays, ours": "#c2a5cf",
    "scattering": "#d62728", "light sampling": "#ffbf00", "rest": "#bbbbbb",
}


def parts_of(result):
    """{label of PARTS: share of the whole}."""
    share = {name: part["share"] for name, part in result["parts"].items()}
    found = {}
    for kind in ("camera", "continuation", "shadow"):
        whole = share[kind + "_rays"]
        embree = result["inside"].get(kind + "_rays", {}).get("embree_share", 1.0)
        found[kind + " rays, Embree"] = whole * embree
        found[kind + " rays, ours"] = whole * (1 - embree)
    found["scattering"] = share["scattering"]
    found["light sampling"] = share["light_draws"] + share["lights_met"]
    found["rest"] = share["rest"]
    return found


def learning_of(result):
    """Shares of a minute of CPU: all that a cold render takes beyond a warm one, and what publishing is of it."""
    learning = result["learning"]
    return {"all": (learning["cold_cpu_seconds"] - learning["warm_cpu_seconds"]) / MINUTE,
            "publishing": learning["publish_cpu_seconds"] / MINUTE}


def measure(run):
    settings = QUICK if run.quick else FULL
    wanted = QUICK_CASES if run.quick else CASES
    found = {}
    for name, (file, flags) in CASES.items():
        if name not in wanted:
            continue
        scene = run.scene(file)
        if scene is None:
            continue
        run.say(name)
        out = run.path("replay.json")
        flags = [round(word * settings["scale"]) if before in ("--width", "--height") else word
                 for before, word in zip([None, *flags], flags)]
        words = [word for key in ("teach", "repeat", "inside") for word in ("--" + key, settings[key])]
        run.bench("replay", scene, *flags, *words, "--seed", run.seed, "--json", out)
        with open(out) as file:
            result = json.load(file)
        result["scene"] = name
        found[name] = {**result, "shares": parts_of(result), "learning_share_of_a_minute": learning_of(result)}
    return {"settings": settings, "threads": 1, "aims": AIMS, "cases": found}


def draw(data, path):
    cases = data["cases"]
    names = list(cases)
    chart = charts.Chart(TITLE + " (one thread; the renderer's own paths, each part replayed alone)", columns=3,
                         width=6.0, height=2.4 + 0.55 * len(names))
    bars, limits, learning = chart.axes
    rows = range(len(names))

    left = [0.0] * len(names)
    for label, color in PARTS.items():
        sizes = [100 * cases[name]["shares"][label] for name in names]
        drawn = [max(0.0, size) for size in sizes]  # a rest below zero is shown by the gap to 100
        bars.barh(rows, drawn, left=left, color=color, label=label)
        for row, size in enumerate(sizes):
            if size >= 4:
                bars.text(left[row] + size / 2, row, f"{size:.0f}", ha="center", va="center", fontsize=7,
                          color="white" if color in ("#1f4e79", "#1b7837", "#762a83", "#d62728") else "black")
        left = [a + b for a, b in zip(left, drawn)]
    bars.axvline(100, color="black", linewidth=0.8)
    bars.set_xlabel("share of the render, per cent (sum of the parts; 100: the whole)")
    bars.legend(fontsize=6.5, ncol=3, loc="lower center", bbox_to_anchor=(0.5, 1.0))

    for row, name in enumerate(names):
        parts = cases[name]["parts"]
        whole, limit = (parts[part]["ns_a_path"] / 1000 for part in ("whole", "limit"))
        limits.barh(row - 0.2, whole, height=0.38, color="#d62728", label="whole" if row == 0 else None)
        limits.barh(row + 0.2, limit, height=0.38, color="#7f7f7f",
                    label="limit: same rays, free BCSDF" if row == 0 else None)
        scattering = 100 * parts["scattering"]["share"]
        limits.text(whole, row - 0.2, f" scattering {scattering:.1f} %", va="center", fontsize=7)
        limits.text(limit, row + 0.2, f" limit {100 * parts['limit']['share']:.0f} %", va="center", fontsize=7)
    limits.set_xlabel("CPU time a path, microseconds")
    limits.set_xlim(0, 1.35 * max(cases[name]["parts"]["whole"]["ns_a_path"] for name in names) / 1000)
    limits.set_title(f"aim: scattering {100 * data['aims']['scattering']:.0f} % of the render", fontsize=9)
    limits.legend(fontsize=7, loc="lower right")

    learning.barh([row - 0.2 for row in rows], [100 * cases[name]["learning_share_of_a_minute"]["all"] for name in names],
                  height=0.38, color="#d62728", label="cold beyond warm (fits and traces)")
    learning.barh([row + 0.2 for row in rows],
                  [100 * cases[name]["learning_share_of_a_minute"]["publishing"] for name in names], height=0.38,
                  color="#ff9896", label="of it between passes (telemetry)")
    learning.axvline(100 * data["aims"]["learning"], color="black", linestyle="--", linewidth=0.8, label="aim")
    learning.set_xlabel("learning, per cent of a render of one CPU minute")
    learning.legend(fontsize=7, ncol=3, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    for axis in chart.axes:
        axis.set_yticks(list(rows), names if axis is bars else [""] * len(names), fontsize=8)
        axis.set_ylim(len(names) - 0.4, -0.6)
    chart.save(path)
