"""How a render's cost grows: with threads, strands, resolution, distinct materials and bounces.

Costs are CPU seconds between start-up and saving (telemetry's passes) a sample of a pixel, the least of the rounds, in which
the sizes take turns; start-up (loading, building, saving) is measured apart. Growth is a power law fitted to the upper half of the
sizes, with its standard error. Threads: wall time of the passes, best of the rounds, and the CPU time of N threads over that
of one, which a machine's load does not touch: cores of one's own would be N / inflation times as fast, at best.
"""
import os

import charts

TITLE = "Scaling"
AIM_TWO_THREADS = 1.9


def passes(rendered):
    """What a render took: CPU seconds a path between start-up and saving, the wall time of that, and the rest."""
    paths = rendered.passes[-1]["samples"]
    return {"ns_a_path": 1e9 * rendered.pass_cpu / paths,
            "pass_wall": sum(event["seconds"] for event in rendered.passes),
            "pass_cpu": rendered.pass_cpu,
            "learning_cpu": sum(event["learning_cpu_seconds"] for event in rendered.passes),
            "start_cpu": rendered.cpu - rendered.pass_cpu, "peak_bytes": rendered.peak_bytes,
            "table_bytes": rendered.passes[-1]["bytes"], "load": os.getloadavg()[0]}


def series(run, xs, rounds, render):
    """render(x) of all xs in turns: [{"x", quantity: interval}]."""
    rivals = {x: (lambda turn, x=x: passes(render(x))) for x in xs}
    found = charts.interleaved(rivals, rounds, run.seed)
    return [{"x": x, **found[x]} for x in xs]


def least(points, quantity):
    return [point[quantity]["low"] for point in points]


def growth(points, quantity):
    """Of the upper half of the sizes, three at least."""
    upper = points[-max(3, (len(points) + 1) // 2):]
    return charts.fit_growth([point["x"] for point in upper], least(upper, quantity))


def many_materials(content, count, strands, distinct_shapes):
    """`count` materials of different color, and of different eccentricity and roughness too, each with its share of the
    strands."""
    content["materials"], content["grooms"] = [], []
    for i in range(count):
        at = (i + 0.5) / count
        material = {"name": f"m{i}", "eccentricity": 0.85, "roughness": 0.2, "melanin": {"eumelanin": 0.1 + 1.2 * at}}
        if distinct_shapes:
            material["eccentricity"], material["roughness"] = 0.7 + 0.3 * at, 0.15 + 0.15 * ((7 * i) % count) / count
        content["materials"].append(material)
        content["grooms"].append({"generate": "straight", "strands": max(1, strands // count), "seed": i,
                                  "radius_cm": 0.02, "material": f"m{i}"})


def measure(run):
    rounds = 1 if run.quick else 3
    size, samples = ("48x64", 4) if run.quick else ("120x160", 32)
    lock, ball = run.scene("scenes/curly_lock.json"), run.scene("scenes/fur_ball.json")
    straight = run.scene("scenes/straight_groom.json")
    if run.quick:  # start-up would be most of it
        lock, straight = (run.variant(scene, f"small_{i}", lambda content: content["grooms"][0].update(
            strands=1000, radius_cm=0.012)) for i, scene in enumerate((lock, straight)))
    found = {}

    run.say("threads")
    counts = [1, 2, 4, 8]
    found["threads"] = series(run, counts, 1 if run.quick else 9, lambda n: run.render(
        lock, "threads", "--resolution", "60x80" if run.quick else "180x240", "--spp", 8 if run.quick else 32, threads=n))

    run.say("strands")
    strands = [1000, 5000, 25000] if run.quick else [1000, 3000, 10000, 30000, 100000, 300000, 1000000]
    scenes = {n: run.variant(ball, f"ball_{n}", lambda content, n=n: content["grooms"][0].update(
        strands=n, radius_cm=0.006 * (40000 / n) ** 0.5)) for n in strands}
    found["strands"] = series(run, strands, rounds, lambda n: run.render(
        scenes[n], "strands", "--resolution", "48x48" if run.quick else "128x128", "--spp", samples, threads=1))

    run.say("resolution")
    widths = [24, 48, 96] if run.quick else [45, 90, 180, 360, 720]
    found["resolution"] = series(run, [w * (w * 4 // 3) for w in widths], rounds, lambda pixels: run.render(
        lock, "resolution", "--resolution", next(f"{w}x{w * 4 // 3}" for w in widths if w * (w * 4 // 3) == pixels), "--spp",
        2 if run.quick else 8, threads=1))

    for kind, shapes in (("colors", False), ("materials", True)):
        run.say(kind)
        numbers = [1, 5, 20] if run.quick else [1, 3, 10, 30, 100, 300, 1000]
        scenes = {n: run.variant(straight, f"{kind}_{n}", lambda content, n=n: many_materials(
            content, n, 3000, shapes)) for n in numbers}
        found[kind] = series(run, numbers, rounds, lambda n: run.render(
            scenes[n], kind, "--resolution", size, "--spp", samples, threads=1))

    run.say("bounces")
    depths = [1, 4, 16] if run.quick else [1, 2, 4, 8, 16, 32, 64]
    blond = run.variant(straight, "blond", lambda content: content["materials"][0].update(melanin={"eumelanin": 0.1}))
    found["bounces"] = series(run, depths, rounds, lambda depth: run.render(
        blond, "bounces", "--resolution", size, "--spp", samples, "--max-depth", depth, threads=1))

    one = found["threads"][0]
    for point in found["threads"]:
        best = {quantity: point[quantity]["low"] for quantity in ("pass_wall", "pass_cpu")}
        pairs = zip(point["pass_cpu"]["values"], one["pass_cpu"]["values"])
        point["speed_up"] = one["pass_wall"]["low"] / best["pass_wall"]
        point["cpu_inflation"] = charts.interval([a / b for a, b in pairs])
    fits = {"strands": ["ns_a_path", "start_cpu", "peak_bytes"], "resolution": ["pass_cpu"],
            "colors": ["ns_a_path", "learning_cpu", "start_cpu"], "materials": ["ns_a_path", "learning_cpu", "start_cpu"],
            "bounces": ["ns_a_path"]}
    return {"settings": {"rounds": rounds, "size": size, "samples": samples}, "aim_two_threads": AIM_TWO_THREADS,
            "series": found,
            "growth": {name: {quantity: growth(found[name], quantity) for quantity in quantities}
                       for name, quantities in fits.items()}}


# quantity: what it is called, its unit, its factor, color and mark
QUANTITIES = {
    "ns_a_path": ("a path", "us", 1e-3, "#d62728", "o"), "pass_cpu": ("all passes", "s", 1, "#d62728", "o"),
    "start_cpu": ("start-up", "s", 1, "#1f77b4", "s"), "learning_cpu": ("learning between passes", "s", 1, "#ff9896", "^"),
    "peak_bytes": ("peak memory", "MB", 1e-6, "#7f7f7f", "D"),
}


def draw(data, path):
    chart = charts.Chart(TITLE + " (CPU time, least of the rounds; exponents: power law of the upper half, ± standard error)",
                         columns=3, rows=2)
    threads, *rest = chart.axes
    points = data["series"]["threads"]
    xs = [point["x"] for point in points]
    threads.plot(xs, [point["speed_up"] for point in points], "o-", color="#d62728", label="speed-up, wall, best of rounds")
    inflation = [point["cpu_inflation"] for point in points]
    threads.errorbar(xs, [one["median"] for one in inflation],
                     yerr=[[one["median"] - one["low"] for one in inflation], [one["high"] - one["median"] for one in inflation]],
                     marker="s", color="#1f77b4", capsize=3, label="CPU time over that of 1 thread, median")
    threads.plot([2], [data["aim_two_threads"]], "k*", markersize=10, label=f"aim: {data['aim_two_threads']} with two")
    threads.set_xscale("log", base=2)
    threads.set_xticks(xs, [str(x) for x in xs])
    threads.set_xlabel("threads")
    threads.set_ylabel("times")
    threads.set_ylim(0, 2.6)
    loads = [value for point in points for value in point["load"]["values"]]
    threads.set_title(f"threads (load of the machine {min(loads):.0f} to {max(loads):.0f})", fontsize=9)
    threads.legend(fontsize=7, loc="upper left")

    titles = {"strands": "strands (fur ball, equal coverage)", "resolution": "pixels (curly lock)",
              "colors": "distinct colors of one shape (3,000 strands)",
              "materials": "distinct materials: color, eccentricity, roughness", "bounces": "hits of a path (blond, --max-depth)"}
    for axis, (name, title) in zip(rest, titles.items()):
        points = data["series"][name]
        xs = [point["x"] for point in points]
        for quantity, fit in data["growth"][name].items():
            word, unit, factor, color, mark = QUANTITIES[quantity]
            values = least(points, quantity)
            axis.plot(xs, [value / values[0] for value in values], marker=mark, color=color,
                      label=f"{word}, {factor * values[0]:.3g} {unit} to {factor * values[-1]:.3g} {unit}: "
                            f"x^({fit['exponent']:.2f} ± {fit['error']:.2f})")
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.set_title(title, fontsize=9)
        axis.set_xlabel({"strands": "strands", "resolution": "pixels", "colors": "fibers", "materials": "materials",
                         "bounces": "hits of a path at most"}[name])
        axis.set_ylabel("times the first")
        axis.grid(alpha=0.3)
        low, high = axis.get_ylim()
        axis.set_ylim(low, high * (high / low) ** 0.4)
        axis.legend(fontsize=7, loc="upper left")
    chart.save(path)
