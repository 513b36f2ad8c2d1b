"""The picture: noise, model error and CPU time of every model, estimator and learner, scene by scene.

Two errors, never mixed. *Noise* is against what the same model converges to: root mean square difference of pixels where there
is hair, over the mean there. *Model error* is that converged picture against `fiber3d`'s: root mean square difference of means of
blocks of pixels (sizes()), over the truth's mean, the noise of both taken out by squares; the truth is `rough` with near=everywhere, whose hits
are traced as `fiber3d`'s are and see lights. Times are CPU of the passes that a picture of 5 %
noise takes (pictures.py), over ours in the same round; `startup` stands beside them.
"""
import charts
import figures
import pictures

TITLE = "Pictures: CPU time to 5 % noise against model error"

MAIN = ("curly lock", "light")  # the scene with several budgets, and every rival
SCENES = [MAIN, ("straight groom", "brown"), ("straight.hair", "light"), ("bear.hair", "dark"), ("varied", None)]
QUICK_SCENES = [MAIN, ("straight groom", "brown")]
MAIN_ONLY = (*pictures.LEARNERS, "warm", "deon2011 35")
LEARNING = (*pictures.LEARNERS, "rough", "rough touching")  # their first passes may cost more than the last


def sizes(run):
    """samples: of ours, cold; rivals take their part of them. budgets: on MAIN, of every rival's."""
    if run.quick:
        return {"samples": 8, "budgets": [1], "rounds": run.rounds or 1, "reference": 32, "truth": 64, "blocks": 8}
    return {"samples": 32, "budgets": [0.25, 0.5, 1], "rounds": run.rounds or 3, "reference": 64, "truth": 512, "blocks": 4}


def name_of(groom, color):
    return f"{groom}, {color}" if color else groom


def rivals_of(run, is_main):
    left_out = () if is_main and not run.quick else MAIN_ONLY
    return [rival for name, rival in pictures.RIVALS.items() if name not in left_out]


def converged(run, scene, rival, size, settings):
    samples = settings["truth" if rival.name == "fiber3d" else "reference"]
    return run.reference(scene, *rival.converged, "--resolution", size, samples=samples)


def references(run):
    settings = sizes(run)
    for groom, color in QUICK_SCENES if run.quick else SCENES:
        scene = pictures.scene(run, groom, color)
        for rival in rivals_of(run, (groom, color) == MAIN) if scene else []:
            converged(run, scene, rival, pictures.size_of(groom, run.quick), settings)


def measured(run, scene, name, size, samples, settings, rivals, known):
    """{rival: {quantity: interval}}; the rivals take turns. samples: of ours. And what the tables took."""
    made, cost_of_tables = pictures.tables(run, scene, name, size, samples, rivals)

    def one(rival):
        spp = max(4, int(samples * rival.part))

        def ask(turn):
            done = pictures.render(run, scene, f"{name}_{rival.name.replace(' ', '_')}_{turn}", rival, size, spp, run.seed + turn,
                                   made)
            cost = pictures.costs(done, spp)
            noise = known[rival.name].noise_of(done.picture)
            time = pictures.time_to(pictures.TARGET, cost, spp, noise, rival.name in LEARNING)
            return {**cost, "samples": spp, "noise": noise, "bias": known[rival.name].bias_of(done.picture), "time": time,
                    "time_with_startup": time + cost["startup"]}
        return ask

    found = charts.interleaved({rival.name: one(rival) for rival in rivals}, settings["rounds"], run.seed)
    found["cold"]["time"] = pictures.cold_times(found)
    found["cold"]["time_with_startup"] = charts.interval(
        [a + b for a, b in zip(found["cold"]["time"]["values"], found["cold"]["startup"]["values"])])
    # The same seed and table: what is left is what the fit and the grid do.
    pairs = [[figures.read(run.path(f"{name}_{one}_{turn}.exr")) for one in ("prebaked", "corrected")]
             for turn in range(settings["rounds"])]
    hair = known["cold"].hair
    found["prebaked"]["bias_against_corrected"] = charts.interval(
        [float((a - b)[hair].mean() / b[hair].mean()) for a, b in pairs])
    for rival in rivals:
        for quantity in ("time", "time_with_startup", "sample"):
            found[rival.name][quantity + "_over_ours"] = pictures.ratios(found, rival.name, quantity)
    return found, cost_of_tables


def measure(run):
    settings = sizes(run)
    result = {"settings": {**settings, "target_noise": pictures.TARGET, "environment": "studio, black behind", "seed": run.seed},
              "labels": {rival.name: rival.label for rival in pictures.RIVALS.values()}, "absent": [], "scenes": {}}
    for groom, color in QUICK_SCENES if run.quick else SCENES:
        label, size = name_of(groom, color), pictures.size_of(groom, run.quick)
        scene = pictures.scene(run, groom, color)
        if not scene:
            result["absent"].append(label)
            continue
        run.say(label)
        is_main = (groom, color) == MAIN
        rivals = rivals_of(run, is_main)
        known = {rival.name: converged(run, scene, rival, size, settings) for rival in rivals}
        truth, side = known["fiber3d"], settings["blocks"]
        hair = figures.blocks(truth.hair.astype(float)[..., None], side)[..., 0] > 0.5
        models = {}
        for rival in rivals:
            mine = known[rival.name]
            models[rival.name] = {"error": 0.0 if rival.name == "fiber3d" else mine.model_error(truth, side),
                                  "brightness": mine.mean() / truth.mean(), "samples": mine.samples}
        name = label.replace(", ", "_").replace(" ", "_").replace(".", "_")
        budgets = {}
        for part in settings["budgets"] if is_main else [1]:
            samples = int(settings["samples"] * part)
            asked = rivals if part == 1 else [rival for rival in rivals if rival.name not in pictures.LEARNERS]
            found, cost_of_tables = measured(run, scene, f"{name}_{samples}", size, samples, settings, asked, known)
            budgets[str(samples)] = {"rivals": found, "tables": cost_of_tables}
        noise = (figures.blocks(truth.variance, side)[hair].mean() / side ** 2) ** 0.5 / truth.mean()
        result["scenes"][label] = {"size": size, "models": models, "budgets": budgets, "hair_blocks": int(hair.sum()),
                                   "truth_block_noise": float(noise)}
    main = result["scenes"][name_of(*MAIN)]["budgets"]
    if len(main) > 2:  # does noise fall with the root of the samples?
        result["law"] = {}
        for rival in rivals_of(run, True):
            if rival.name in pictures.LEARNERS:
                continue
            points = [main[count]["rivals"][rival.name] for count in sorted(main, key=int)]
            result["law"][rival.name] = charts.fit_growth([p["samples"]["median"] for p in points],
                                                          [p["noise"]["median"] for p in points])
    return result


# ---- drawing --------------------------------------------------------------------------------------------------------

SHORT = {"rough": "rough (cold)", "rough warm": "rough (warm)", "rough touching": "rough, near=touching",
         "cold": "elliptical (cold)", "warm": "elliptical (warm)",
         "prebaked": "elliptical (prebaked)", "corrected": "corrected (prebaked)",
         "deon2011 10": "d'Eon, 10 points", "deon2011 35": "d'Eon, 35", "deon2011 100": "d'Eon, 100", "fiber3d": "fiber3d, the truth",
         "pekelis2015": "pekelis2015 (prebaked)", **{name: "learner " + name for name in pictures.LEARNERS}}


def last(scene):
    """The largest budget's rivals."""
    return scene["budgets"][max(scene["budgets"], key=int)]["rivals"]


def medians(data, of):
    """{rival: [values over the scenes that have it]}."""
    out = {}
    for scene in data["scenes"].values():
        for rival in scene["models"]:
            out.setdefault(rival, []).append(of(scene, rival))
    return out


def middle(values):
    values = sorted(values)
    half = len(values) // 2
    return values[half] if len(values) % 2 else 0.5 * (values[half - 1] + values[half])


def draw_main(axis, data):
    times = medians(data, lambda scene, rival: last(scene)[rival]["time_over_ours"]["median"])
    errors = medians(data, lambda scene, rival: scene["models"][rival]["error"])
    rivals = [rival for rival in times if rival not in pictures.LEARNERS]
    for rival in rivals:
        axis.scatter(times[rival], errors[rival], s=14, alpha=0.5, linewidths=0, **charts.style(rival))
        axis.scatter([middle(times[rival])], [middle(errors[rival])], s=110 if rival == "cold" else 70, edgecolors="black",
                     linewidths=0.8, zorder=3, label=SHORT.get(rival, rival), **charts.style(rival))
        if rival.startswith("deon2011"):
            axis.annotate(rival.split()[1], (middle(times[rival]), middle(errors[rival])), fontsize=7, ha="center",
                          va="bottom", xytext=(0, 6), textcoords="offset points")
    axis.axvline(1, color="#bbbbbb", linewidth=0.8, zorder=0)
    axis.set_xscale("log")
    axis.set_ylim(bottom=-0.02)
    plain_log(axis.xaxis)
    axis.set_xlabel(f"CPU time to {100 * data['settings']['target_noise']:g} % noise, elliptical = 1   (left is faster)")
    axis.set_ylabel("model error against fiber3d   (down is better)")
    axis.set_title("large: median over scenes; small: each scene", fontsize=9)
    axis.legend(fontsize=6.5, loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)


def plain_log(axis):
    import matplotlib.ticker as ticker
    axis.set_major_locator(ticker.LogLocator(subs=(1, 2, 5), numticks=12))
    axis.set_major_formatter(ticker.FormatStrFormatter("%g"))
    axis.set_minor_formatter(ticker.NullFormatter())


def scene_marks(data):
    return dict(zip(data["scenes"], "osD^v<>PX*hpd"))


def draw_times(axis, data):
    times = medians(data, lambda scene, rival: last(scene)[rival]["time_over_ours"]["median"])
    order = sorted(times, key=lambda rival: middle(times[rival]))
    marks = scene_marks(data)
    for row, rival in enumerate(order):
        for label, scene in data["scenes"].items():
            if rival in last(scene):
                axis.scatter([last(scene)[rival]["time_over_ours"]["median"]], [row], s=22, marker=marks[label], alpha=0.8,
                             color=charts.style(rival)["color"], linewidths=0)
        axis.text(0.99, row, f"{middle(times[rival]):.2f}", transform=axis.get_yaxis_transform(), ha="right", va="center", fontsize=7)
    axis.set_yticks(range(len(order)), [SHORT.get(rival, rival) for rival in order], fontsize=7)
    axis.axvline(1, color="#bbbbbb", linewidth=0.8, zorder=0)
    axis.set_xscale("log")
    low, high = axis.get_xlim()
    axis.set_xlim(low, high * 2.2)
    plain_log(axis.xaxis)
    axis.invert_yaxis()
    axis.set_xlabel("CPU time to that noise, elliptical = 1 (right: medians)")
    axis.set_title("Equal noise, by scene (marks as below right)", fontsize=9)


def draw_budgets(axis, data):
    label = next(iter(data["scenes"]))
    scene = data["scenes"][label]
    counts = sorted(scene["budgets"], key=int)
    for rival in scene["models"]:
        if rival in pictures.LEARNERS:
            continue
        points = [scene["budgets"][count]["rivals"][rival] for count in counts]
        axis.plot([p["passes"]["median"] for p in points], [100 * p["noise"]["median"] for p in points], linewidth=1,
                  markersize=4, label=SHORT.get(rival, rival), alpha=0.85, **charts.style(rival))
    axis.set_xscale("log")
    axis.set_yscale("log")
    plain_log(axis.xaxis)
    plain_log(axis.yaxis)
    axis.set_xlabel("CPU seconds of the passes")
    axis.set_ylabel("noise, %")
    axis.set_title(f"{label}: {', '.join(counts)} samples a pixel", fontsize=9)
    axis.legend(fontsize=6, loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)


def draw_brightness(axis, data):
    chosen = ["rough", "cold", "deon2011 10", "deon2011 100", "pekelis2015", "marschner2003", "ou2012", "chiang2016"]
    marks = scene_marks(data)
    for row, rival in enumerate(chosen):
        for label, scene in data["scenes"].items():
            axis.scatter([scene["models"][rival]["brightness"]], [row], s=26, marker=marks[label], alpha=0.85,
                         color=charts.style(rival)["color"], linewidths=0)
    for label, mark in marks.items():
        axis.scatter([], [], s=26, marker=mark, color="#555555", label=label)
    axis.axvline(1, color="#bbbbbb", linewidth=0.8, zorder=0)
    axis.set_yticks(range(len(chosen)), [SHORT.get(r, r).replace(" (cold)", "") for r in chosen], fontsize=7)
    axis.invert_yaxis()
    axis.set_xlabel("mean radiance of the hair over fiber3d's")
    axis.set_title("Brightness of the converged pictures", fontsize=9)
    axis.legend(fontsize=6.5, loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)


FAIRNESS = """Not equal company: ours has a rough fiber's energies, from the tracer that is also the judge; the others have a smooth fiber's,
and their published widths. What they reach with the same energies and tuned widths: bench_far_field --fair (bench/README.md)."""


def draw(data, path):
    chart = charts.Chart(TITLE, columns=2, rows=2, width=6.0, height=4.2)
    draw_main(chart.axes[0], data)
    draw_times(chart.axes[1], data)
    draw_budgets(chart.axes[2], data)
    draw_brightness(chart.axes[3], data)
    chart.figure.text(0.5, -0.005, FAIRNESS, ha="center", va="top", fontsize=7.5)
    chart.save(path)
