"""Fireflies and places where pictures break: suns 2 degrees wide, light hair with 64 hits, fibers seen end-on and from
within, hair thinner than a pixel, lights among hair, two grooms in one place, extremes of scale and lens. bench_atlas_images
(images.cpp) sees every sample of every picture; the scenes are made here, in the run's folder.

A case holds where
  finite    every sample of every estimator and model is a finite number
  positive  none of fitted or exact is negative (of corrected 1 in 16 corrections may be)
  mean      fitted and corrected have the mean of `exact` (the difference of pictures of one seed by its own error over the
            pixels, which are independent): |z| < Z in each of three channels, and of every block of 8 x 8 pixels of its
            luminance; fitted after its own allowed bias, epsilon of the mean
  layers    they sum to the beauty, to rounding; 0 <= A <= 1
  energy    of a furnace (clear hair in light 1): with 4,000 hits |mean - 1| < Z errors; with 64 it lacks what later hits
            bring, and no more
  twin      the same hair at another scale, offset or distance: |z| < Z
"""
import base64
import concurrent.futures
import io
import json
import math
import os
import struct
import threading

import charts
import figures
import numpy
import PIL.Image

TITLE = "Where pictures break: fireflies, end-on, thin, inside, coincident, extreme"
ESTIMATORS = ("exact", "fitted", "corrected")
SHOWN = ("sun_white", "panel_inside")  # drawn pixel by pixel, by every model
MODELS = ("rough", "marschner2003", "deon2011", "chiang2016", "ou2012", "pekelis2015", "fiber3d")
Z = 5.5  # two-sided: 3.8e-8 a test; some 5,000 tests a full run: one false alarm in 5,000 runs
SIDE = 8

BLOND = {"melanin": {"eumelanin": 0.1, "pheomelanin": 0.15}}
CLEAR = {"sigma_a": [0, 0, 0]}
SUN = {"distant": {"azimuth_deg": 150, "elevation_deg": 35, "angle_deg": 2, "irradiance": [3, 3, 3]}}
DIM = {"constant": [0.05, 0.05, 0.05]}
ONE = {"constant": [1, 1, 1]}
CAMERA = {"eye": [0, -15, 0], "look_at": [0, 0, 0], "vertical_fov_deg": 28}


# ---- scenes ---------------------------------------------------------------------------------------------------------

def lock(strands=900, length=6.0, spread=1.0, points=10, seed=3):
    """[points x 3] of every strand: a wavy lock along -z about the origin, thinning out towards the tips."""
    random = numpy.random.default_rng(seed)
    t = numpy.linspace(0, 1, points)
    found = []
    for _ in range(strands):
        root = random.normal(size=2) * 0.4 * spread
        own = random.normal(size=4) * [0.12, 0.12, 0.5, 0.08]
        phase = 2 * math.pi * t * 2.2 + own[2]
        wave = 0.28 * t ** 0.5
        x = root[0] * (1 - 0.35 * t) + wave * numpy.cos(phase) + own[0] * t
        y = root[1] * (1 - 0.35 * t) + wave * numpy.sin(phase) + own[1] * t
        found.append(numpy.stack([x, y, length * (0.5 - t * (1 - abs(own[3])))], axis=1))
    return found


def bundle(strands=400, length=3.0, seed=5):
    """Straight strands along y, side by side: the camera looks along them."""
    random = numpy.random.default_rng(seed)
    places = random.uniform(-0.5, 0.5, size=(strands, 2))
    t = numpy.linspace(0, length, 4)
    return [numpy.stack([0 * t + x, t, 0 * t + z], axis=1) for x, z in places]


def broken(seed=7):
    """A lock among which: repeated points, points a rounding apart, hairpins, strands of two points, tiny ones."""
    random = numpy.random.default_rng(seed)
    found = lock(300, seed=seed)
    for i, strand in enumerate(found):
        kind = i % 6
        middle = strand[4]
        if kind == 0:
            strand[5] = middle
        elif kind == 1:
            strand[5] = numpy.float32(middle) * numpy.float32(1 + 1.2e-7)
        elif kind == 2:
            strand[6], strand[5] = middle, middle + [0.4, 0, 0.01]
        elif kind == 3:
            found[i] = strand[[0, -1]]
        elif kind == 4:
            found[i] = middle + random.normal(size=(5, 3)) * 1e-5
        else:
            strand[5:] = strand[5:] * 0 + middle + [1e-7, 0, 0]
    return found


def write_hair(path, strands, scale=1.0, offset=(0.0, 0.0, 0.0)):
    """A .hair file: z up, single precision, as every such file is."""
    points = numpy.concatenate(strands) * scale + numpy.asarray(offset)
    part = f"{path}.{threading.get_ident()}"
    with open(part, "wb") as file:
        file.write(struct.pack("<4sIIIIfffff88s", b"HAIR", len(strands), len(points), 3, 0, 1, 0, 1, 1, 1, b"atlas"))
        file.write(numpy.array([len(strand) - 1 for strand in strands], "<u2").tobytes())
        file.write(points.astype("<f4").tobytes())
    os.replace(part, path)  # cases share files
    return path


def write_hot(path, width=512, height=256):
    """A flat RGBE environment, black but for .02 and one pixel of 1e6, behind and above."""
    def rgbe(value):
        mantissa, exponent = math.frexp(value)
        return bytes([int(mantissa * 256)] * 3 + [exponent + 128])

    dim, hot = rgbe(0.02), rgbe(1e6)
    with open(path, "wb") as file:
        file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (height, width))
        for y in range(height):
            file.write(b"".join(hot if (x, y) == (300, 70) else dim for x in range(width)))
    return path


class Case:
    """A scene and what is asked of it. make(run): its JSON. furnace: the answer is 1. models: the others render it too.
    share: of the samples of a full run. twin: an earlier case of the same mean. slow: not of a quick run."""

    def __init__(self, name, title, make, size=(40, 56), furnace=False, models=False, share=1.0, twin=None, slow=False):
        self.name, self.title, self.make, self.size = name, title, make, size
        self.furnace, self.models, self.share, self.twin, self.slow = furnace, models, share, twin, slow


def hair(run, name, strands, **placement):
    return write_hair(run.path(name + ".hair"), strands, **placement)


def scene(grooms, material=BLOND, environment=DIM, lights=(SUN,), camera=CAMERA, **more):
    """grooms: paths, or whole entries."""
    entries = [one if isinstance(one, dict) else {"file": one, "cm_per_unit": 1, "radius_cm": 0.012} for one in grooms]
    return {"camera": camera, "environment": environment, "environment_visible": more.pop("visible", False),
            "lights": list(lights), "materials": [{"name": "hair", **material}], "grooms": entries, **more}


def furnace(grooms, camera=CAMERA, **material):
    return scene(grooms, {**CLEAR, **material}, ONE, (), camera, visible=True)


def at(eye, look_at, fov=40):
    return {"eye": list(eye), "look_at": list(look_at), "vertical_fov_deg": fov}


INSIDE = at((0, 0.05, 0.4), (0.3, 1, 0), 80)


def rays_of(run):
    return hair(run, "bundle", bundle())


def on_axis(run):
    """A strand that points exactly at the camera of END_ON, alone."""
    t = numpy.linspace(0, 3, 4)
    return hair(run, "on_axis", [numpy.stack([0 * t, t, 0 * t], axis=1)])


END_ON = at((0, -4, 0), (0, 0, 0), 14)


def thick(run):
    """One strand of radius 1 cm about the camera, and a lock."""
    t = numpy.linspace(-3, 3, 6)
    return [{"file": hair(run, "thick", [numpy.stack([0 * t, 0 * t, t], axis=1)]), "cm_per_unit": 1, "radius_cm": 1},
            hair(run, "lock", lock())]


def entry(path, radius):
    return {"file": path, "cm_per_unit": 1, "radius_cm": radius}


def usual(run, count=900):
    return hair(run, f"lock{count}", lock(count))


def moved(run, offset):
    return hair(run, f"moved{offset:g}", lock(), offset=(offset, 0, 0)), at((offset, -15, 0), (offset, 0, 0), 28)


CASES = [
    Case("sun", "sun 2 degrees wide, blond", lambda run: scene([usual(run)]), models=True),
    Case("sun_white", "the same, white hair, 64 hits", lambda run: scene([usual(run)], CLEAR), models=True),
    Case("sun_white_dense", "white, four times as dense", lambda run: scene([usual(run, 3600)], CLEAR), share=0.5, slow=True),
    Case("sun_small", "sun of .01 degree", lambda run: scene([usual(run)], lights=[
        {"distant": {**SUN["distant"], "angle_deg": 0.01}}]), models=True, slow=True),
    Case("sun_only", "sun 2 degrees, else black", lambda run: scene([usual(run)], environment={"constant": [0, 0, 0]}), slow=True),
    Case("narrow", "alpha .05 under the sun", lambda run: scene([usual(run)], {**BLOND, "roughness": 0.05}), models=True),
    Case("narrowest", "alpha .01 under the sun", lambda run: scene([usual(run)], {**BLOND, "roughness": 0.01}),
         share=0.25, slow=True),
    Case("blue", "absorbs all but blue", lambda run: scene([usual(run)], {"sigma_a": [3, 3, 0.02]}), models=True),
    Case("flat", "e .5, a turn in .08 cm, tilt 10", lambda run: scene([usual(run)], {
        **BLOND, "eccentricity": 0.5, "curl_diameter_cm": 0.05, "tilt_deg": 10}), models=True),
    Case("hot_pixel", "one pixel of 1e6 in the sky", lambda run: scene([usual(run)], lights=(), environment={
        "file": write_hot(run.path("hot.hdr"))}), models=True, slow=True),
    Case("black", "no light at all", lambda run: scene([usual(run)], lights=(), environment={"constant": [0, 0, 0]}),
         share=0.1),
    Case("end_on", "along the tangents of a bundle", lambda run: scene([rays_of(run)], camera=END_ON), size=(48, 48),
         models=True),
    Case("at_camera", "a strand that points at the camera", lambda run: scene([entry(on_axis(run), 0.1)], camera=END_ON),
         size=(48, 48)),
    Case("thin", "radius a hundredth of a pixel", lambda run: scene([entry(usual(run), 0.0013)], CLEAR), models=True),
    Case("inside", "camera in the groom", lambda run: scene([usual(run)], camera=INSIDE), size=(48, 48), models=True),
    Case("inside_strand", "camera in a strand", lambda run: scene(thick(run), camera=INSIDE), size=(48, 48), slow=True),
    Case("panel_inside", "rectangle light across strands", lambda run: scene([usual(run)], environment={
        "constant": [0, 0, 0]}, lights=[{"rectangle": {"center": [0, 0, 0.5], "look_at": [0.2, -1, -0.5], "width_cm": 1,
                                                       "height_cm": 1, "radiance": [10, 10, 10]}}]), models=True),
    Case("bulb_inside", "bulb of .02 cm about an axis", lambda run: scene([usual(run)], environment={"constant": [0, 0, 0]},
                                                                         lights=[{"sphere": {"center": [
        float(x) for x in lock()[17][4]], "radius_cm": 0.02, "radiance": [1e4, 1e4, 1e4]}}])),
    Case("apart", "the same groom twice, 10 um apart", lambda run: scene([usual(run), hair(
        run, "apart", lock(), offset=(0.0006, 0.0007, 0.0004))]), slow=True),
    Case("twice", "the same groom twice", lambda run: scene([usual(run), usual(run)]), models=True, twin="apart", slow=True),
    Case("broken", "zero, tiny, folded segments", lambda run: scene([hair(run, "broken", broken())])),
    Case("offset_1e4", "1e4 cm from the origin", lambda run: (lambda m: scene([m[0]], camera=m[1]))(moved(run, 1e4)),
         twin="sun", slow=True),
    Case("offset_1e6", "1e6 cm from the origin", lambda run: (lambda m: scene([m[0]], camera=m[1]))(moved(run, 9.9e5))),
    Case("tiny", "a lock of .05 cm", lambda run: scene([entry(hair(run, "tiny", lock(), scale=1 / 120), 1e-4)], camera=at(
        (0, -0.125, 0), (0, 0, 0), 28)), twin="sun"),
    Case("nearer", "from 357 cm, 1.2 degrees", lambda run: scene([usual(run)], camera=at((0, -357.1, 0), (0, 0, 0), 1.2))),
    Case("afar", "from 3,500 cm, .12 degrees", lambda run: scene([usual(run)], camera=at((0, -3571, 0), (0, 0, 0), 0.12)),
         twin="nearer"),
    Case("wide", "150 degrees", lambda run: scene([usual(run)], camera=at((0, -1.6, 0), (0, 0, 0), 150)), slow=True),
    Case("pixel", "a picture of one pixel", lambda run: scene([usual(run)]), size=(1, 1), share=500),
    Case("furnace", "furnace: lock", lambda run: furnace([usual(run)]), furnace=True),
    Case("furnace_inside", "furnace: camera in the groom", lambda run: furnace([usual(run)], INSIDE), size=(48, 48),
         furnace=True, share=0.25),
    Case("furnace_strand", "furnace: camera in a strand", lambda run: furnace(thick(run), INSIDE), size=(48, 48),
         furnace=True, share=0.25, slow=True),
    Case("furnace_end_on", "furnace: along the tangents", lambda run: furnace([rays_of(run)], END_ON), size=(48, 48),
         furnace=True),
    Case("furnace_twice", "furnace: the same groom twice", lambda run: furnace([usual(run), usual(run)]), furnace=True),
    Case("furnace_flat", "furnace: e .5, alpha .05, tilt 10", lambda run: furnace(
        [usual(run)], eccentricity=0.5, curl_diameter_cm=0.05, tilt_deg=10, roughness=0.05), furnace=True,
         slow=True),
    Case("furnace_offset", "furnace: 1e6 cm off", lambda run: (lambda m: furnace([m[0]], m[1]))(moved(run, 9.9e5)),
         furnace=True),
    Case("furnace_broken", "furnace: broken strands", lambda run: furnace([hair(run, "broken", broken())]), furnace=True),
]


# ---- measuring ------------------------------------------------------------------------------------------------------

def luminance(pixels):
    return pixels @ numpy.array([0.2126, 0.7152, 0.0722])


def channel(exr, name):
    names, pixels = figures.channels_of(exr)
    return pixels[:, :, names.index(name)]


def z_of(values):
    """Of the mean of independent values against 0, and its error."""
    values = numpy.asarray(values, numpy.float64).ravel()
    if len(values) < 2:
        return 0.0, 0.0
    error = values.std(ddof=1) / math.sqrt(len(values))
    return (float(values.mean() / error) if error > 0 else 0.0), float(error)


def block_z(difference, allowed=0.0):
    """The largest |z| of the means of SIDE x SIDE pixels; 0 for pictures of fewer pixels."""
    height, width = (size // SIDE * SIDE for size in difference.shape)
    if not height or not width:
        return 0.0
    parts = difference[:height, :width].reshape(height // SIDE, SIDE, width // SIDE, SIDE).transpose(0, 2, 1, 3)
    parts = parts.reshape(-1, SIDE * SIDE).astype(numpy.float64)
    error = parts.std(axis=1, ddof=1) / SIDE
    off = numpy.maximum(0, abs(parts.mean(axis=1)) - allowed)
    # A block of which less than a third of the pixels differ has no normal mean.
    usable = (abs(parts) > 0).mean(axis=1) > 1 / 3
    return float((off / numpy.maximum(error, 1e-30))[usable].max(initial=0))


def layers_of(exr):
    """Largest difference of the beauty from the sum of its layers, over the largest value; whether A is in [0, 1]."""
    names, pixels = figures.channels_of(exr)
    worst = 0.0
    for color in "RGB":
        parts = [pixels[:, :, i].astype(numpy.float64) for i, name in enumerate(names)
                 if name.endswith("." + color) and name.split(".")[0] not in ("albedo", "variance")]
        beauty = pixels[:, :, names.index(color)]
        size = max(1e-30, float(sum(abs(part) for part in parts).max()))
        worst = max(worst, float(abs(sum(parts) - beauty).max()) / size)
    alpha = pixels[:, :, names.index("A")]
    return worst, bool((alpha >= 0).all() and (alpha <= 1).all() and numpy.isfinite(pixels).all())


def measure_one(run, case, path, rival, samples, *more):
    """One render through bench_atlas_images: what it says, and its picture."""
    out = run.path(f"{case.name}_{rival}.exr")
    flags = ["--estimator", rival] if rival in ESTIMATORS else ["--model", rival]
    done = run.bench("atlas_images", path, "-o", out, "--resolution", "%dx%d" % case.size, "--spp", samples, "--seed",
                     run.seed, *flags, *more)
    printed = json.loads(done.stdout)
    pixels = figures.read(out).astype(numpy.float64)
    of_pixel, largest = luminance(pixels), channel(out, "largest")
    lit = of_pixel > 0.25 * max(1e-30, of_pixel.mean())
    mean = printed["mean"]
    worst, inside = layers_of(out)
    found = {key: printed[key] for key in ("mean", "not_finite", "negative_share", "deviation", "hits_per_path", "most_hits",
                                        "share_of_top_1e-4", "exact_share")}
    found.update({"cpu_seconds": done.cpu, "largest_over_mean": printed["largest"] / mean if mean > 0 else 0.0,
                  "least_over_mean": printed["least"] / mean if mean > 0 else 0.0,
                  "largest_over_pixel": float(numpy.median((largest / numpy.maximum(of_pixel, 1e-30))[lit])) if lit.any() else 0.0,
                  "noise": printed["deviation"] / mean if mean > 0 else 0.0, "layers_off": worst, "a_and_channels": inside})
    return found, pixels


def against(pixels, exact, epsilon):
    """z of the difference per channel and per block; the bias and its error, relative. A bias up to epsilon is allowed."""
    difference, mean = pixels - exact, float(exact.mean())
    found = {"z": [], "z_allowed": []}
    for c in range(3):
        z, error = z_of(difference[:, :, c])
        allowed = epsilon * float(exact[:, :, c].mean())
        found["z"].append(z)
        off = max(0.0, abs(float(difference[:, :, c].mean())) - allowed)
        found["z_allowed"].append(off / error if error > 0 else 0.0)
    _, error = z_of(luminance(difference))
    found["bias"] = float(luminance(difference).mean()) / mean if mean > 0 else 0.0
    found["bias_error"] = error / mean if mean > 0 else 0.0
    found["block_z"] = block_z(luminance(difference), epsilon * float(luminance(exact).mean()))
    return found


def small_png(pixels):
    """A picture as base64 of a PNG of 48 colors, its 99th percentile white: for the sheets of draw()."""
    top = max(1e-9, float(numpy.percentile(pixels, 99)))
    shown = (255 * figures.tone_map(pixels / top)).astype(numpy.uint8)
    out = io.BytesIO()
    PIL.Image.fromarray(shown).quantize(48).save(out, "PNG", optimize=True)
    return base64.b64encode(out.getvalue()).decode()


def nicer(run, case, path):
    """Of more pixels and samples, by `tress render`, for eyes."""
    width, height = case.size if case.size == (1, 1) else (60, 84) if case.size[0] < case.size[1] else (72, 72)
    samples = 2 if case.furnace or case.name.startswith(("inside", "narrow", "flat")) else 8
    return figures.read(run.render(path, case.name + "_sheet", "--spp", samples, "--resolution", f"{width}x{height}",
                                   threads=1).picture).astype(numpy.float64)


def furnace_of(run, case, path, samples, rivals, pixels):
    """What a furnace is held to: with 4,000 hits it is 1; with 64 it lacks what those paths bring later, and no more."""
    more, deep = measure_one(run, case, path, "fitted", samples, "--max-depth", 4000)
    z, error = z_of(luminance(deep) - 1)
    _, lost_error = z_of(luminance(deep) - luminance(pixels["fitted"]))
    lost = more["mean"] - rivals["fitted"]["mean"]
    for rival, one in rivals.items():
        _, own = z_of(luminance(pixels[rival]))
        short = 1 - one["mean"] - max(0.0, lost)
        one["furnace_z"] = max(short, one["mean"] - 1) / math.hypot(own, lost_error)
    return {"deep_mean": more["mean"], "deep_z": z, "deep_error": error, "deep_hits": more["most_hits"], "lost": lost,
            "deep_largest": more["largest_over_mean"]}


def verdict(case, entry):
    """Names of what fails."""
    failed = []
    for rival, one in entry["rivals"].items():
        if one["not_finite"]:
            failed.append(f"{rival}: {one['not_finite']} not finite")
        if rival not in ESTIMATORS:
            continue
        if not one["a_and_channels"] or one["layers_off"] > 1e-5:
            failed.append(f"{rival}: layers")
        if rival != "corrected" and one["least_over_mean"] < 0:
            failed.append(f"{rival}: negative")
        if max(one.get("z_allowed", [0])) > Z or one.get("block_z", 0) > Z:
            failed.append(f"{rival}: mean")
        if case.furnace and one["furnace_z"] > Z:
            failed.append(f"{rival}: furnace")
    if case.furnace and abs(entry["furnace"]["deep_z"]) > Z:
        failed.append("furnace of 4,000 hits")
    if abs(entry.get("twin_z", 0)) > Z:
        failed.append(f"differs from {entry['twin']}")
    return failed


def maps_of(run, case, rivals):
    """Of each rival the picture and, gray, log10 of the largest sample of each pixel over the picture's mean, 0 to 4."""
    found = {}
    for rival in rivals:
        out = run.path(f"{case.name}_{rival}.exr")
        pixels, largest = figures.read(out).astype(numpy.float64), channel(out, "largest")
        scale = numpy.log10(numpy.maximum(largest / max(1e-30, luminance(pixels).mean()), 1)) / 4
        gray = io.BytesIO()
        PIL.Image.fromarray((255 * numpy.clip(scale, 0, 1)).astype(numpy.uint8)).save(gray, "PNG", optimize=True)
        found[rival] = [small_png(pixels), base64.b64encode(gray.getvalue()).decode()]
    return found


def measure_case(run, case, usual_samples, epsilon):
    """Its entry, and its picture by fitted."""
    path = run.path(case.name + ".json")
    with open(path, "w") as file:
        json.dump(case.make(run), file)
    samples = max(1, round(usual_samples * case.share))
    rivals = ESTIMATORS + (MODELS if case.models and not run.quick else ("rough",))
    entry, pixels = {"title": case.title, "samples": samples, "size": case.size, "rivals": {}}, {}
    for rival in rivals:
        one, pixels[rival] = measure_one(run, case, path, rival, max(1, samples // (1 if rival in ESTIMATORS else 2)))
        if rival in ("fitted", "corrected"):
            one.update(against(pixels[rival], pixels["exact"], epsilon if rival == "fitted" else 0.0))
            if case.size == (1, 1):  # by the deviation of the samples
                other = entry["rivals"]["exact"]
                off = (one["mean"] - other["mean"]) / math.hypot(one["deviation"], other["deviation"]) * math.sqrt(samples)
                one["z"] = one["z_allowed"] = [off]
        entry["rivals"][rival] = one
    if case.furnace:
        entry["furnace"] = furnace_of(run, case, path, samples, entry["rivals"], pixels)
    entry["picture"] = small_png(pixels["fitted"] if run.quick else nicer(run, case, path))
    return entry, pixels["fitted"]


def measure(run):
    usual_samples, epsilon = (1, 0.01) if run.quick else (16, 0.01)
    cases = [case for case in CASES if not (run.quick and case.slow)]
    with concurrent.futures.ThreadPoolExecutor(3) as pool:  # CPU time is recorded, nobody is timed against another
        measured = dict(zip([case.name for case in cases],
                            pool.map(lambda case: measure_case(run, case, usual_samples, epsilon), cases)))
    found = {}
    for case in cases:
        entry, pixels = measured[case.name]
        if case.twin in measured:
            # Different scenes: the pixels' own differences are part of the error, so this is on the safe side.
            other = measured[case.twin][1]
            entry["twin"], entry["twin_z"] = case.twin, z_of(luminance(pixels - other))[0]
            entry["twin_ratio"] = float(pixels.mean() / other.mean())
        entry["failed"] = verdict(case, entry)
        found[case.name] = entry
        run.say(f"{case.name}: " + ", ".join(f"{rival} {one['largest_over_mean']:.0f}" for rival, one in entry["rivals"].items())
                + "; " + (", ".join(entry["failed"]) or "holds"))
    maps = {case.name: maps_of(run, case, found[case.name]["rivals"]) for case in cases if case.name in SHOWN}
    return {"settings": {"samples": usual_samples, "epsilon": epsilon, "z": Z, "block": SIDE, "max_depth": 64}, "cases": found,
            "maps": maps}


# ---- drawing --------------------------------------------------------------------------------------------------------

def draw(data, path):
    draw_table(data, path)
    draw_pictures(data, path + "_pictures")
    for name, maps in data["maps"].items():
        draw_maps(data["cases"][name], maps, f"{path}_{name}")


def image_of(text):
    return numpy.asarray(PIL.Image.open(io.BytesIO(base64.b64decode(text))).convert("RGB"))


def draw_maps(entry, maps, path):
    figure, axes = charts.pyplot.subplots(2, len(maps), figsize=(1.35 * len(maps) + 0.6, 4.5), squeeze=False)
    for column, (rival, (picture, largest)) in enumerate(maps.items()):
        one = entry["rivals"][rival]
        axes[0][column].imshow(image_of(picture), interpolation="nearest")
        axes[0][column].set_title(f"{rival}\nnoise {one['noise']:.2g}", fontsize=7)
        shown = axes[1][column].imshow(image_of(largest)[:, :, 0] / 255 * 4, cmap="inferno", vmin=0, vmax=4,
                                       interpolation="nearest")
        axes[1][column].set_title(f"largest {one['largest_over_mean']:,.0f} x mean", fontsize=7)
    for axis in axes.ravel():
        axis.set_axis_off()
    figure.suptitle(f"{entry['title']}: the picture, and the largest sample of each pixel over the picture's mean", fontsize=9)
    figure.tight_layout()
    figure.subplots_adjust(right=0.94)
    bar = figure.colorbar(shown, cax=figure.add_axes((0.95, 0.06, 0.01, 0.38)), ticks=[0, 1, 2, 3, 4])
    bar.ax.set_yticklabels(["1", "10", "100", "1e3", "1e4"], fontsize=7)
    save(figure, path, tight=False)


def draw_table(data, path):
    cases = data["cases"]
    rivals = ESTIMATORS + MODELS
    figure, axis = charts.pyplot.subplots(figsize=(14.5, 0.27 * len(cases) + 1.9))
    colors = charts.matplotlib.colormaps["YlOrRd"]
    columns = [(f"{rival}\n", lambda e, r=rival: e["rivals"].get(r, {}).get("largest_over_mean")) for rival in rivals]
    for row, (name, entry) in enumerate(cases.items()):
        for column, (_, value) in enumerate(columns):
            number = value(entry)
            if number is None:
                continue
            shade = min(1.0, math.log10(max(1.0, number)) / 4.5)
            axis.add_patch(charts.pyplot.Rectangle((column, row), 1, 1, color=colors(0.75 * shade), linewidth=0))
            axis.text(column + 0.5, row + 0.5, f"{number:,.0f}", ha="center", va="center", fontsize=7.5)
        ours = entry["rivals"]
        cells = [f"{ours[one]['noise']:.2g}" for one in ESTIMATORS]
        cells += [f"{ours[one]['negative_share']:.1%}" for one in ("corrected",)]
        cells += [f"{max(ours[one]['z'], key=abs):.1f}" for one in ("fitted", "corrected")]
        cells += [f"{100 * ours['fitted']['bias']:.2f} +- {100 * ours['fitted']['bias_error']:.2f}"]
        furnace = entry.get("furnace")
        cells += [f"{furnace['deep_mean']:.4f} +- {furnace['deep_error']:.4f}" if furnace
                  else f"{entry['twin_ratio']:.3f} x {entry['twin']}" if "twin_ratio" in entry else ""]
        for i, text in enumerate(cells):
            axis.text(len(columns) + WIDTHS[i] + 0.1, row + 0.5, text, va="center", fontsize=7.5)
        failed = entry["failed"]
        axis.text(len(columns) + WIDTHS[-1] + 0.1, row + 0.5, "FAILS: " + ", ".join(failed) if failed else "holds", va="center",
                  fontsize=7.5, color="#b00000" if failed else "#007000", weight="bold" if failed else "normal")
    for column, (label, _) in enumerate(columns):
        axis.text(column + 0.5, -0.25, label, ha="center", va="bottom", fontsize=7)
    for i, label in enumerate(["noise\nexact", "noise\nfitted", "noise\ncorr.", "corr.\n< 0", "z\nfitted", "z\ncorr.",
                               "bias of fitted\n% of the mean", "furnace, 4,000 hits\nor ratio to twin", "verdict"]):
        axis.text(len(columns) + WIDTHS[i] + 0.1, -0.25, label, ha="left", va="bottom", fontsize=7)
    axis.set_yticks([row + 0.5 for row in range(len(cases))], [entry["title"] for entry in cases.values()], fontsize=7.5)
    axis.set_xticks([])
    axis.set(xlim=(0, len(columns) + WIDTHS[-1] + 2.6), ylim=(len(cases), 0))
    axis.tick_params(length=0)
    for side in axis.spines.values():
        side.set_visible(False)
    figure.suptitle(f"{TITLE}\nleft: largest sample of a path over the mean of the picture; noise: standard deviation of a sample over "
                    f"the mean; {data['settings']['samples']} samples a pixel, 64 hits", fontsize=9.5)
    save(figure, path)


WIDTHS = (0, 0.6, 1.2, 1.8, 2.4, 2.9, 3.4, 4.7, 6.4)  # where the columns of text begin


def save(figure, path, tight=True):
    if tight:
        figure.tight_layout()
    figure.savefig(path + ".svg", metadata={"Date": None})
    pixels = io.BytesIO()
    figure.savefig(pixels, format="png", dpi=110)
    charts.pyplot.close(figure)
    PIL.Image.open(pixels).convert("RGB").quantize(256, dither=PIL.Image.Dither.NONE).save(path + ".png", optimize=True)


def draw_pictures(data, path):
    cases = data["cases"]
    across = 9
    down = -(-len(cases) // across)
    figure, axes = charts.pyplot.subplots(down, across, figsize=(1.62 * across, 2.35 * down), squeeze=False)
    for axis in axes.ravel():
        axis.set_axis_off()
    for axis, (name, entry) in zip(axes.ravel(), cases.items()):
        axis.imshow(image_of(entry["picture"]), interpolation="nearest")
        axis.set_title(entry["title"], fontsize=6.5, color="#b00000" if entry["failed"] else "black")
    figure.suptitle("The pictures of study 5 (fitted; each exposed for its own 99th percentile)", fontsize=10)
    save(figure, path)
