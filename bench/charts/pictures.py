"""What the charts of whole pictures (4, 5 and 6) share: grooms and hair colors, rivals, tables, CPU time to a noise.

Noise falls with the root of the samples, so a picture of N samples with noise n shows what one of noise t takes:

    T(t) = once + sample * N * (n / t)^2

where *sample* is the CPU of one late pass (one sample of every pixel; the mean of the last quarter of the passes) and *once*
is what the passes took beyond N of those: learning, and vertices traced because their rows were not there yet. Of our cold
table *sample* is that of the prebaked one in the same round, which it comes to; what it learns after N samples is not in
*once*. *startup* is all that was not in passes: making or reading the groom, Embree's tree, energies, tables read or written, saving the picture.
"""
import os

import charts
import figures

TARGET = 0.05  # the noise that times are stated for

COLORS = {"light": {"eumelanin": 0.25, "pheomelanin": 0.35}, "brown": {"eumelanin": 1.3}, "dark": {"eumelanin": 8.0}}
GROOMS = {"curly lock": ("scenes/curly_lock.json", None), "straight groom": ("scenes/straight_groom.json", None),
          "straight.hair": ("grooms/straight.hair", "z"), "bear.hair": ("grooms/bear.hair", "y"),
          "varied": ("scenes/varied.json", None)}


def scene(run, groom, color=None, name=None, **material):
    """The scene of a groom in black surroundings, with this color and these keys of its materials; None where it is absent."""
    source, up = GROOMS[groom]
    found = run.scene(source)
    if not found:
        return None

    def change(content):
        content["environment_visible"] = False
        if run.quick and not up:  # most of such a short render would be spent on making the groom
            content["grooms"][0].update(strands=1500, radius_cm=0.008)
        if up:
            content["grooms"] = [{"file": found, "up": up, "material": "brown"}]
        for one in content["materials"]:
            if color:
                one["melanin"] = COLORS[color]
            one.update(material)

    base = "scenes/straight_groom.json" if up else source
    return run.variant(base, (name or f"{groom}_{color or 'own'}").replace(" ", "_").replace(".", "_"), change)


class Rival:
    """flags: of its renders; converged: of the renders that show what they converge to; table: the one made beforehand that
    it reads; part: of the samples that ours takes, 1/4 where a sample is dear or shows enough."""

    def __init__(self, name, label, *flags, converged=None, table=None, part=0.5):
        self.name, self.label, self.flags, self.table, self.part = name, label, list(flags), table, part
        self.converged = list(flags) if converged is None else list(converged)


ROUGH = ("--model", "rough")
ELLIPTICAL = ("--model", "elliptical")
OURS = ("--model", "elliptical", "--estimator", "corrected")  # unbiased, as exact is, for a fifth of the time
FROZEN = ("--cache-mode", "frozen")
PAPER = ("--model", "pekelis2015")
RIVALS = {rival.name: rival for rival in [
    Rival("rough", "rough: rows of samples, cold", *ROUGH, part=1),
    Rival("rough warm", "rough, warm", *ROUGH, *FROZEN, converged=ROUGH, table="rough", part=1),
    Rival("rough touching", "rough, hits of touching fibers traced", *ROUGH, "--set", "integrator/near=touching"),
    Rival("cold", "elliptical: fitted, cold", *ELLIPTICAL, converged=OURS, part=1),
    Rival("warm", "elliptical, warm", *ELLIPTICAL, *FROZEN, converged=OURS, table="taught"),
    Rival("prebaked", "elliptical, prebaked", *ELLIPTICAL, *FROZEN, converged=OURS, table="baked"),
    Rival("corrected", "corrected, prebaked", *OURS, *FROZEN, converged=OURS, table="baked"),
    Rival("exact", "exact", *ELLIPTICAL, "--estimator", "exact", converged=OURS, part=0.25),
    *(Rival(name, f"learner {name}, cold", *ELLIPTICAL, "--learner", name, converged=OURS, part=1)
      for name in ("eager", "em", "appendix", "appendix-literal", "ais")),
    *(Rival(f"deon2011 {points}", f"d'Eon 2011, {points} points", "--model", "deon2011", "--quadrature-points", points)
      for points in (10, 35, 100)),
    Rival("pekelis2015", "pekelis2015, prebaked", *PAPER, *FROZEN, converged=(*PAPER, "--estimator", "exact"), table="pekelis2015"),
    *(Rival(name, name, "--model", name) for name in ("marschner2003", "ou2012", "chiang2016")),
    # The same paths, which see lights too: fiber3d itself would leave 0.2 of noise in the truth.
    Rival("fiber3d", "fiber3d, the truth", "--model", "fiber3d", converged=(*ROUGH, "--set", "integrator/near=everywhere")),
]}
LEARNERS = ("eager", "em", "appendix", "appendix-literal", "ais")


def tables(run, scene_path, name, size, samples, rivals):
    """{table: cache} for these rivals: "taught" and "rough", left by a render of another seed; "baked", the whole table;
    "pekelis2015", the paper's. And {table: CPU seconds}."""
    files, seconds = {}, {}
    for table in sorted({rival.table for rival in rivals if rival.table}):
        files[table] = run.path(f"{name}_{table}.cache")
        if os.path.exists(files[table]):
            os.remove(files[table])
        if table in ("taught", "rough"):
            model = ROUGH if table == "rough" else ELLIPTICAL
            done = run.render(scene_path, f"{name}_{table}_table", *model, "--spp", samples, "--resolution", size,
                              "--warm-cache", files[table], seed=run.seed + 9000)
        else:
            model = PAPER if table == "pekelis2015" else ELLIPTICAL
            done = charts.Done([run.tress, "cache", "prebake", scene_path, "-o", files[table], "--quiet", *model])
        seconds[table] = done.cpu
    return files, seconds


def render(run, scene_path, name, rival, size, samples, seed, made=None, *more):
    flags = ["--spp", samples, "--resolution", size, *rival.flags, *more]
    if rival.table:
        flags += ["--warm-cache", made[rival.table]]
    return run.render(scene_path, name, *flags, seed=seed)


def costs(done, samples):
    """CPU seconds of a render: {"startup", "once", "sample", "passes"}."""
    whole = max(event["pixels"] for event in done.passes)
    late = [event["cpu_seconds"] for event in done.passes if event["pixels"] == whole]
    late = late[-max(1, len(late) // 4):]
    sample = sum(late) / len(late)
    return {"startup": done.cpu - done.pass_cpu, "sample": sample, "once": done.pass_cpu - sample * samples,
            "passes": done.pass_cpu}


def time_to(target, cost, samples, noise, learns):
    """CPU seconds of the passes of a picture with this noise. learns: whether the first passes may cost more than the last."""
    once = max(0.0, cost["once"]) if learns else 0.0
    sample = cost["sample"] if learns else cost["passes"] / samples
    return once + sample * samples * (noise / target) ** 2


def cold_times(found):
    """Of "cold": interval of the time to TARGET by the samples of "prebaked" in the same round, and what it took beyond them."""
    cold, baked = found["cold"], found["prebaked"]
    times = []
    for turn, passes in enumerate(cold["passes"]["values"]):
        sample = baked["passes"]["values"][turn] / baked["samples"]["values"][turn]
        samples = cold["samples"]["values"][turn]
        cost = {"once": passes - sample * samples, "sample": sample}
        times.append(time_to(TARGET, cost, samples, cold["noise"]["values"][turn], True))
    return charts.interval(times)


def ratios(found, name, quantity, over="cold"):
    """Interval of the ratio to `over`, round by round."""
    return charts.interval([a / b for a, b in zip(found[name][quantity]["values"], found[over][quantity]["values"])])


def size_of(groom, quick):
    """Pixels: the lock is narrow."""
    if GROOMS[groom][0].endswith(("curly_lock.json", "varied.json")):
        return "24x72" if quick else "36x108"
    return "40x50" if quick else "60x75"
