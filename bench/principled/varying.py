"""Colors that vary, by Cycles and by tress: blender -b --factory-startup -P varying.py -- TRESS FOLDER [SCENE...]

Scenes: `gradient`, a lock with a Color Ramp over Hair Info's Intercept; `apart`, the same on seven thick strands;
`scalp`, fur on a ball with a picture of stripes over its uv; `random`, those strands by Hair Info's Random. By region
the mean of each channel over what hair covers, and tress less Cycles, with the largest standard error of that by seeds;
FOLDER/SCENE.png has both, Cycles left. CONSTANT=1 adds each region's color as that of all hair. Ends with status 1 where
a difference is above 0.03. SAMPLES (64), SEEDS (4) and SIZE (96) are read from the environment.
"""

import os
import pathlib
import sys

here = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(here.parents[1] / "tests" / "blender")]
for name, usual in (("SAMPLES", "64"), ("SIZE", "96"), ("MODEL", "default")):
    os.environ.setdefault(name, usual)

import bpy  # noqa: E402
import numpy as np  # noqa: E402

import beside_cycles as beside  # noqa: E402
import grooms  # noqa: E402

AIM = 0.03
SEEDS = int(os.environ.get("SEEDS", "4"))
ALONG = [(0.0, (0.05, 0.02, 0.01)), (0.5, (0.4, 0.08, 0.03)), (1.0, (0.75, 0.55, 0.3))]
STRIPES = {"red": (0.6, 0.08, 0.05), "blond": (0.7, 0.5, 0.25), "green": (0.1, 0.35, 0.15), "brown": (0.12, 0.06, 0.03)}


def linked(tree, node, output, node_input):
    made = tree.nodes.new("ShaderNode" + node)
    tree.links.new(made.outputs[output], node_input)
    return made


def with_ramp(tree, color, over):
    ramp = linked(tree, "ValToRGB", "Color", color)
    linked(tree, "HairInfo", over, ramp.inputs["Fac"])
    ramp.color_ramp.elements.new(0.5)
    for stop, (place, value) in zip(ramp.color_ramp.elements, ALONG):
        stop.position, stop.color = place, (*value, 1)


def with_stripes(tree, color):
    picture = linked(tree, "TexImage", "Color", color)
    picture.image, picture.interpolation = bpy.data.images.new("stripes", 8, 1, float_buffer=True), "Closest"
    picture.image.pixels.foreach_set(np.float32(2 * [(*rgb, 1) for rgb in STRIPES.values()]).reshape(-1))


def lock(scene, hair):
    grooms.add_camera(scene, lens=110)
    grooms.add_hair_curves(scene, grooms.strands(count=6000, points=13), hair, 0.00015, 0.8)


def ball(scene, hair):
    grooms.add_camera(scene, eye=(0, -0.8, 0), lens=190)
    settings = grooms.add_particle_hair(scene, hair, bpy.data.materials.new("skin"), 8000, 0.012).particle_systems[0].settings
    settings.child_type, settings.radius_scale, settings.brownian_factor = "NONE", 0.0006, 0.005


def fence(scene, hair):
    grooms.add_camera(scene, lens=110)
    post = np.stack([np.zeros(9), np.zeros(9), np.linspace(0.15, -0.15, 9)], 1)
    grooms.add_hair_curves(scene, np.float32([post + (0.04 * (i - 3), 0, 0) for i in range(7)]), hair, 0.01, 1.0)


def grid(size):
    """x and y of the middles of pixels, from -1 to 1, y up."""
    middles = 2 * (np.arange(size) + 0.5) / size - 1
    return middles[None, :], -middles[:, None]


def thirds(size):
    """Of the lock, its uppermost first."""
    x, y = grid(size)
    return {name: (np.abs(y - at) < 0.2) & (x < 2) for name, at in zip(("root", "middle", "tip"), (0.6, 0, -0.6))}


def stripes(size):
    """Of the ball: the middles of the four that are seen, away from where one fur hangs over another."""
    x, y = grid(size)
    radius = 0.05 / (0.8 * 18 / 190)
    places = [(-0.9, 0.1), (-0.38, 0.2), (0.38, 0.2), (0.9, 0.1)]
    return {name: (np.abs(x / radius - at) < half) & (np.abs(y) < 0.7 * radius)
            for name, (at, half) in zip(STRIPES, places)}


def posts(size):
    x, y = grid(size)
    return {f"{i + 1}": (np.abs(x * 18 / 110 - 0.04 * (i - 3)) < 0.02) & (y < 2) for i in range(7)}


# Groom, what its color varies with, its regions, and the color of each.
INTERCEPT = lambda tree, color: with_ramp(tree, color, "Intercept")
ENDS = dict(zip(("root", "middle", "tip"), (rgb for _, rgb in ALONG)))
SCENES = {
    "gradient": (lock, INTERCEPT, thirds, ENDS),
    "apart": (fence, INTERCEPT, thirds, ENDS),
    "scalp": (ball, with_stripes, stripes, STRIPES),
    "random": (fence, lambda tree, color: with_ramp(tree, color, "Random"), posts, {}),
}


def pictures_of(name, constant=None):
    """(seeds, height, width, 4) of Cycles, and of tress."""
    groom, vary, _, _ = SCENES[name]
    scene = beside.lit_scene()
    hair = grooms.hair_material(parametrization="COLOR", Color=constant or (0, 1, 0))
    groom(scene, hair)
    scene.render.film_transparent, scene.render.image_settings.color_mode = True, "RGBA"
    if constant is None:
        vary(hair.node_tree, hair.node_tree.nodes["Principled Hair BSDF"].inputs["Color"])
    from tress_render import files
    both = []
    for engine in ("CYCLES", "TRESS"):
        scene.render.engine, found = engine, []
        for seed in range(SEEDS):
            scene.cycles.seed = scene.tress.seed = seed
            scene.render.filepath = os.path.join(beside.FOLDER, engine + ".exr")
            bpy.ops.render.render(write_still=True)
            channels = files.read_exr(scene.render.filepath).channels
            found.append(np.stack([channels[c] for c in "RGBA"], 2))
        both.append(np.array(found))
    return both


def compared(label, theirs, ours, mask):
    """Prints a row; whether the aim is met."""
    means = [pictures[:, mask, :3].sum(1) / pictures[:, mask, 3:].sum(1) for pictures in (theirs, ours)]
    (a, b), errors = (m.mean(0) for m in means), [m.std(0, ddof=1) / np.sqrt(SEEDS) for m in means]
    error = np.hypot(*errors)
    text = lambda x: " ".join(f"{v:7.4f}" for v in x)
    print(f"{label:24s} Cycles {text(a)}  tress {text(b)}  difference {text(b - a)}  +- {error.max():.4f}", flush=True)
    return bool((np.abs(b - a) <= AIM).all())


def main():
    os.makedirs(beside.FOLDER, exist_ok=True)
    met = True
    for name in beside.ONLY or SCENES:
        theirs, ours = pictures_of(name)
        _, _, regions, colors = SCENES[name]
        for region, mask in regions(beside.SIZE).items():
            met &= compared(f"{name} {region}", theirs, ours, mask)
            if region in colors and "CONSTANT" in os.environ:
                compared(f"  {region} everywhere", *pictures_of(name, colors[region]), mask)
        beside.save_png(np.concatenate([theirs.mean(0), ours.mean(0)], 1)[:, :, :3], name + ".png")
    print("the aim is met" if met else f"MISSED: a difference above {AIM}")
    sys.stdout.flush()
    os._exit(not met)


main()
