"""The same grooms here and in Blender's Cycles: CPU time a sample, and noise against CPU time.

../shared/tools/cycles_peer/render.py renders in Cycles; the scene written here has its camera, size, light, radius and
absorption. What differs: the fiber model (Cycles: Chiang et al. 2016, near field, round; ours: the default, `rough`, and for
comparison `elliptical`, both of e .85, and our chiang2016, round), the ribbons (Cycles: Catmull-Rom through the points; ours:
B-splines controlled by them), the widths of lobes (roughness .25 and .3 there, Beckmann .17 here: R as wide), the filter
(Blackman-Harris of 1.5 pixels; tent of 1) and roulette. `cycles` is without bias as ours is; `cycles, defaults` clamps
indirect light at 10, blurs glossy bounces and leaves weak lights out, and is less noisy for it. `tress, adaptive` shares the
same number of samples out by noise, as its `--noise` does; the adaptive sampling of Cycles is off. Noise is that of one
picture: the root mean square of the difference of two seeds' over sqrt 2, over the mean where there is hair. CPU time is of
the whole process, start-up, building and learning included; the cost of a sample is the slope between two numbers of samples.
"""
import math
import os
import shutil
import struct

import charts
import figures
import numpy

TITLE = "Peer: Blender's Cycles"
FOV_DEG, LONGEST_CM, REDNESS = 30.0, 30.0, 0.3
NOISES = (0.01, 0.02, 0.05)

# groom: file, environment, options of cycles_peer/render.py (its README)
GROOMS = {
    "straight": ("grooms/straight.hair", "hdri/city.exr", {"melanin": 0.6}),
    "bear": ("grooms/bear.hair", "hdri/studio.exr", {"up": "y", "melanin": 0.5, "turn": 30}),
    "ponytail": ("grooms/ponytail.hair", "hdri/courtyard.exr", {"up": "y", "melanin": 0.4, "turn": 60}),
}
FULL = {"resolution": 256, "samples": (8, 64), "rounds": 3, "threads": 2, "max_depth": 32}
QUICK = {**FULL, "resolution": 80, "samples": (4, 16), "rounds": 1}
SHORT = {**FULL, "resolution": 96, "samples": (8, 128), "rounds": 3}  # so many that a slope is seconds, not tenths
RIVALS = {
    "tress": [],
    "tress, adaptive": ["--adaptive", "on"],
    "tress, elliptical": ["--model", "elliptical"],
    "tress, chiang2016": ["--model", "chiang2016"],
    "cycles": {"CYCLES_UNBIASED": "1"},
    "cycles, defaults": {"CYCLES_UNBIASED": "0"},
}


def bounds_of(file, y_up):
    """Least and greatest corner as read, z up, and the header's thickness; all in units of the file."""
    with open(file, "rb") as opened:
        data = opened.read()
    strands, points, bits = struct.unpack("<III", data[4:16])
    thickness, = struct.unpack("<f", data[20:24])
    position = numpy.frombuffer(data, "<f4", 3 * points, 128 + (2 * strands if bits & 1 else 0)).reshape(-1, 3).astype(float)
    if y_up:
        position = numpy.stack([position[:, 0], -position[:, 2], position[:, 1]], 1)
    return position.min(0), position.max(0), thickness


def sigma_a(melanin):
    """Cycles' absorption by its melanin and redness (Blender's svm_closure, principled hair), per radius."""
    quantity = -math.log(max(1 - melanin, 1e-4))
    eumelanin, pheomelanin = quantity * (1 - REDNESS), quantity * REDNESS
    return [eumelanin * a + pheomelanin * b for a, b in zip((0.506, 0.841, 1.653), (0.343, 0.733, 1.924))]


def scene_like_cycles(groom, environment, options):
    """Our scene with the camera, size, light and absorption of cycles_peer/render.py. Its maps' centre looks along +x, ours
    along -y."""
    low, high, thickness = bounds_of(groom, options.get("up") == "y")
    scale = LONGEST_CM / (high - low).max()
    middle, diagonal = (low + high) / 2 * scale, float(numpy.linalg.norm(high - low)) * scale
    turn = math.radians(options.get("turn", 0))
    distance = 0.95 * diagonal / 2 / math.sin(math.radians(FOV_DEG / 2))
    eye = middle + distance * numpy.array([math.sin(turn), -math.cos(turn), 0.12])
    return {
        "camera": {"eye": eye.tolist(), "look_at": middle.tolist(), "vertical_fov_deg": FOV_DEG},
        "environment": {"file": environment, "rotate_deg": 90},
        "environment_visible": False,
        "materials": [{"name": "hair", "eccentricity": options.get("eccentricity", 0.85), "roughness": 0.17, "tilt_deg": 2,
                       "sigma_a": sigma_a(options["melanin"])}],
        "grooms": [{"file": groom, "up": options.get("up", "z"), "cm_per_unit": scale, "radius_cm": thickness * scale / 2,
                    "taper": {"root": 1, "tip": 1}, "material": "hair"}],
    }


def noise_of(one, other):
    """Of one of two pictures of different seeds, relative; the mean of both; the share of pixels that are hair."""
    a, b = (figures.read(path).astype(numpy.float64) for path in (one, other))
    hair = (figures.coverage(one) > 0.5) & (figures.coverage(other) > 0.5)
    mean = (0.5 * (a + b))[hair].mean()
    return float((0.5 * (a - b)[hair] ** 2).mean() ** 0.5 / mean), float(mean), float(hair.mean())


def measure(run):
    blender, script = shutil.which("blender"), os.path.join(charts.SHARED, "tools", "cycles_peer", "render.py")
    if blender is None or not os.path.exists(script):
        run.say("blender or ../shared/tools/cycles_peer is absent: left out")
        return {"left_out": "blender (Debian) or ../shared/tools/cycles_peer is absent", "grooms": {}}
    settings = QUICK if run.quick else SHORT if run.short else FULL
    resolution, samples, threads = (settings[name] for name in ("resolution", "samples", "threads"))
    few = ("tress", "tress, adaptive", "cycles", "cycles, defaults")
    rivals = ("tress", "cycles") if run.quick else few if run.short else tuple(RIVALS)

    def picture(rival, groom, environment, options, scenes, spp, seed):
        """(path, CPU seconds of the process)"""
        out = run.path(f"{rival}_{spp}_{seed}.exr".replace(", ", "_"))
        if rival.startswith("tress"):
            done = run.render(scenes[rival], os.path.basename(out)[:-4], *RIVALS[rival], "--spp", spp, "--resolution",
                              f"{resolution}x{resolution}", "--max-depth", settings["max_depth"], seed=seed, threads=threads)
            return out, done.cpu
        words = [word for key, value in options.items() for word in (f"--{key}", str(value))]
        done = charts.Done([blender, "-b", "--factory-startup", "-P",
                            os.path.join(os.path.dirname(os.path.abspath(__file__)), "cycles_settings.py"), "-P", script, "--",
                            groom, environment, out, "--spp", str(spp), "--resolution", str(resolution), "--max-bounces",
                            str(settings["max_depth"]), "--threads", str(threads), *words], {**RIVALS[rival], "CYCLES_SEED": str(seed)})
        if "cycles:" not in done.stdout:
            raise RuntimeError(f"blender rendered nothing\n{done.stdout[-2000:]}")
        return out, done.cpu

    found = {}
    for name, (file, light, options) in GROOMS.items():
        if run.quick and name != "straight":
            continue
        groom, environment = run.scene(file), run.scene(light)
        if groom is None or environment is None:
            continue
        run.say(name)
        scenes = {}
        for rival in (rival for rival in RIVALS if rival.startswith("tress")):
            eccentricity = 1.0 if rival == "tress, chiang2016" else 0.85
            scenes[rival] = run.path(f"{name}_{rival}.json".replace(", ", "_"))
            charts.save(scenes[rival], scene_like_cycles(groom, environment, {**options, "eccentricity": eccentricity}))

        def one(rival, turn):
            values = {}
            for spp in samples:
                (a, cpu_a), (b, cpu_b) = (picture(rival, groom, environment, options, scenes, spp, 2 * turn + i + 1)
                                          for i in range(2))
                noise, mean, covered = noise_of(a, b)
                values.update({f"noise_{spp}": noise, f"cpu_{spp}": 0.5 * (cpu_a + cpu_b), f"mean_{spp}": mean, "covered": covered})
            return values

        found[name] = charts.interleaved({rival: (lambda turn, rival=rival: one(rival, turn)) for rival in rivals},
                                         run.rounds or settings["rounds"], run.seed)
        for rival, values in found[name].items():
            numbers = [f"{key} {values[key]['median']:.4g}" for s in samples for key in (f"cpu_{s}", f"noise_{s}")]
            run.say(f"{name}, {rival}: {', '.join(numbers)}")
    few, many = samples
    for rivals_found in found.values():
        for values in rivals_found.values():
            slope = (values[f"cpu_{many}"]["low"] - values[f"cpu_{few}"]["low"]) / (many - few)
            values["ns_a_sample"] = 1e9 * slope / resolution ** 2
            values["start_cpu"] = max(0.0, values[f"cpu_{few}"]["low"] - slope * few)
            at_noise = slope * many * values[f"noise_{many}"]["median"] ** 2  # CPU seconds times squared noise
            values["cpu_to_noise"] = {str(noise): values["start_cpu"] + at_noise / noise ** 2 for noise in NOISES}
            values["cpu_times_noise_squared"] = at_noise
    return {"settings": {**settings,
                         "blender": charts.Done([blender, "--version"]).stdout.splitlines()[0]},
            "noises": NOISES, "grooms": found}


STYLES = {"tress": ("#d62728", "o"), "tress, adaptive": ("#ff9896", "o"), "tress, elliptical": ("#ff7f0e", "s"),
          "tress, chiang2016": ("#2ca02c", "^"), "cycles": ("#393b79", "h"),
          "cycles, defaults": ("#9c9ede", "h")}


def draw(data, path):
    if not data["grooms"]:
        chart = charts.Chart(TITLE)
        chart.axes[0].text(0.5, 0.5, data.get("left_out", "no groom"), ha="center", wrap=True)
        chart.axes[0].set_axis_off()
        chart.save(path)
        return
    few, many = data["settings"]["samples"]
    chart = charts.Chart(f"{TITLE} ({data['settings']['blender']}; equal camera, light and absorption; models differ)",
                         columns=len(data["grooms"]), width=5.6 if len(data["grooms"]) > 1 else 9, height=4.6)
    for axis, (name, rivals) in zip(chart.axes, data["grooms"].items()):
        for rival, values in rivals.items():
            color, mark = STYLES[rival]
            cpu = [values[f"cpu_{spp}"]["median"] for spp in (few, many)]
            noise = [100 * values[f"noise_{spp}"]["median"] for spp in (few, many)]
            label = (f"{rival}: {values['ns_a_sample'] / 1000:.2f} us a sample, start {values['start_cpu']:.1f} s")
            axis.plot(cpu, noise, linestyle="none", marker=mark, color=color, label=label)
            for low, high, x, y in [(values[f"noise_{spp}"]["low"], values[f"noise_{spp}"]["high"], at, level)
                                    for spp, at, level in zip((few, many), cpu, noise)]:
                axis.plot([x, x], [100 * low, 100 * high], color=color, linewidth=1)
            noises = numpy.geomspace(min(NOISES), max(noise) / 100, 60)
            axis.plot(values["start_cpu"] + values["cpu_times_noise_squared"] / noises ** 2, 100 * noises, color=color,
                      linewidth=0.8, linestyle="--")
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.set_xlabel("CPU seconds of the process (dashed: start-up + slope)")
        axis.set_ylabel("noise, per cent")
        axis.grid(alpha=0.3, which="both")
        ours, theirs = rivals.get("tress"), rivals.get("cycles")
        if ours and theirs:
            ratio = theirs["cpu_times_noise_squared"] / ours["cpu_times_noise_squared"]
            whole = theirs["cpu_to_noise"]["0.02"] / ours["cpu_to_noise"]["0.02"]
            axis.set_title(f"{name}: tress is {ratio:.2f} times as fast to equal noise\n({whole:.2f} to 2 %, start-up included)",
                           fontsize=9)
        axis.legend(fontsize=7)
    chart.save(path)
