"""No more than a scene needs: the bias of the picture against what was learned for it, epsilon beside the light-driven rule.

Every table is learned by one render; bench_picture_bias then takes the picture by its fits and that by g at the nodes,
along the same paths, so that the bias of the fits is seen and neither noise nor the grid. The saving is stated at the bias that
a uniform epsilon has, by interpolation between the settings of the other rule in logarithms.
"""
import json
import math

import charts
import pictures

TITLE = "no more than a scene needs: bias of the picture against rows, components, bytes and g"

COSTS = {"rows": "rows fitted", "components": "components", "bytes": "bytes of the table", "g": "g evaluations",
         "learning_cpu": "learning, CPU s"}
UNIFORM, LIGHT = ("--epsilon", (0.1, 0.03, 0.01, 0.003, 0.001)), ("--picture-error", (1, 0.3, 0.1, 0.03, 0.01))


def scenes(run):
    wanted = {"curly lock, light": ("curly lock", "light", "96x128"), "curly lock, brown": ("curly lock", "brown", "96x128"),
              "straight.hair, brown": ("straight.hair", "brown", "64x64")}
    found = {}
    for name, (groom, color, size) in list(wanted.items())[:1 if run.quick else None]:
        scene = pictures.scene(run, groom, color)
        if scene:
            found[name] = (scene, size)
    return found


def one(run, scene, size, flag, value, name):
    table = run.path(name + ".cache")
    learned = run.render(scene, name, "--resolution", size, "--spp", 32 if run.quick else 64, "--warm-cache", table,
                         "--cache-mode", "scratch", "--model", "elliptical", flag, value)
    last = learned.passes[-1]
    components = last["components"]
    out = {"rule": flag[2:], "value": value, "rows": sum(components[1:]), "unfitted": components[0],
           "open": last["rows"]["open"], "components": sum(d * n for d, n in enumerate(components)),
           "bytes": last["bytes"], "g": sum(p["g_evaluations"] for p in learned.passes),
           "learning_cpu": sum(p["learning_cpu_seconds"] for p in learned.passes), "bound": last["bias_bound"]}
    done = run.bench("picture_bias", scene, table, "--size", size, "--spp", 8 if run.quick else 16, "--seeds",
                     4 if run.quick else 8)
    bias = json.loads(done.stdout)
    out.update({key: bias[key] for key in ("bias", "bias_error", "block_rms")})
    run.say(f"{name}: {json.dumps(out)}")
    return out


def savings(points):
    """{cost: share saved} at each uniform epsilon, where settings of the other rule lie on both sides of its bias."""
    def error(point):
        return max(abs(point["bias"]), point["bias_error"])

    light = sorted((p for p in points if p["rule"] == "picture-error"), key=error)
    savings = {}
    for uniform in (p for p in points if p["rule"] == "epsilon"):
        if abs(uniform["bias"]) < 3 * uniform["bias_error"]:
            continue  # its bias was not seen
        for low, high in zip(light, light[1:]):
            if error(low) <= error(uniform) <= error(high) and error(low) < error(high):
                at = math.log(error(uniform) / error(low)) / math.log(error(high) / error(low))
                savings[str(uniform["value"])] = {
                    cost: 1 - math.exp((1 - at) * math.log(low[cost]) + at * math.log(high[cost])) / uniform[cost]
                    for cost in COSTS}
    return savings


def measure(run):
    data = {}
    for name, (scene, size) in scenes(run).items():
        rules = (("--epsilon", (0.1, 0.01)), ("--picture-error", (0.3, 0.1))) if run.quick else (UNIFORM, LIGHT)
        points = [one(run, scene, size, flag, value, f"{name.replace(' ', '_').replace(',', '')}_{flag[2:]}_{value}")
                  for flag, values in rules for value in values]
        data[name] = {"size": size, "points": points, "savings": savings(points)}
    return data


def draw(data, path):
    chart = charts.Chart(TITLE, columns=len(COSTS), rows=len(data), width=3.6, height=3.2)
    axes = iter(chart.axes)
    for name, content in data.items():
        for cost, label in COSTS.items():
            axis = next(axes)
            for rule, color, mark in (("epsilon", "#1f77b4", "o"), ("picture-error", "#d62728", "s")):
                points = [p for p in content["points"] if p["rule"] == rule]
                axis.errorbar([p[cost] for p in points], [100 * max(abs(p["bias"]), p["bias_error"]) for p in points],
                              yerr=[100 * p["bias_error"] for p in points], color=color, marker=mark, ms=4, lw=1,
                              label="uniform epsilon" if rule == "epsilon" else "by light (--picture-error)")
                axis.plot([p[cost] for p in points], [100 * p["bound"] for p in points], color=color, lw=0.6, ls=":",
                          label="its bound")
                for p in points:
                    axis.annotate(f"{p['value']:g}", (p[cost], 100 * max(abs(p["bias"]), p["bias_error"])), fontsize=6,
                                  xytext=(3, 3), textcoords="offset points")
            axis.set_xscale("log")
            axis.set_yscale("log")
            axis.set_xlabel(label, fontsize=8)
            axis.set_ylabel(f"{name}: bias, % of the mean", fontsize=7)
            axis.tick_params(labelsize=7, which="both")
            axis.grid(True, alpha=0.3)
    chart.axes[0].legend(fontsize=6)
    chart.save(path)
