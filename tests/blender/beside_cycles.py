"""Cycles and tress on the same scenes, side by side: blender -b --factory-startup -P beside_cycles.py -- TRESS FOLDER [NAME...]

Prints the mean of each channel over the pixels that hair covers wholly, tress over Cycles, for every groom and color;
with FOLDER/beside_cycles.png. TRANSPARENT=1: over all pixels of a transparent film, free of what our own samples found covered. Lights and the environment are compared on a plain ball first.
"""

import os
import pathlib
import sys

here = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(here), str(here.parents[1] / "scenes" / "blender")]

import addon_utils  # noqa: E402
import bpy  # noqa: E402
import numpy as np  # noqa: E402

import grooms  # noqa: E402

TRESS, FOLDER, *ONLY = sys.argv[sys.argv.index("--") + 1:]  # where bench/principled/cycles.py includes this, its own
SAMPLES = int(os.environ.get("SAMPLES", "128"))
SIZE = int(os.environ.get("SIZE", "64"))
MODEL = os.environ.get("MODEL", "elliptical")
TRANSPARENT = "TRANSPARENT" in os.environ
USED = os.environ.get("LIGHTS", "ASW")


def start():
    scene = grooms.empty_scene(SIZE, SIZE)
    addon_utils.enable("tress_render", default_set=True)
    bpy.context.preferences.addons["tress_render"].preferences.program = TRESS
    scene.tress.keep_folder = os.path.join(FOLDER, "kept")
    scene.tress.samples, scene.tress.model = SAMPLES, MODEL
    cycles = scene.cycles
    cycles.samples, cycles.use_denoising, cycles.use_adaptive_sampling = SAMPLES, False, False
    for bounces in ("max", "transmission", "glossy", "diffuse"):
        setattr(cycles, bounces + "_bounces", 64)
    cycles.sample_clamp_indirect = cycles.blur_glossy = 0
    scene.cycles_curves.shape = "RIBBONS"
    settings = scene.render.image_settings
    settings.file_format, settings.color_depth = "OPEN_EXR", "32"
    return scene


def both(scene):
    """Pixels of Cycles and of tress, (height, width, 3), and the coverage."""
    from tress_render import files
    pictures = []
    for engine in ("CYCLES", "TRESS"):
        scene.render.engine = engine
        scene.render.filepath = os.path.join(FOLDER, engine + ".exr")
        bpy.ops.render.render(write_still=True)
        channels = files.read_exr(scene.render.filepath).channels
        pictures.append(np.stack([channels[c] for c in "RGB"], 2))
    return (*pictures, files.read_exr(os.path.join(FOLDER, "kept", "picture.exr")).channels["coverage"])


def ball(scene):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=0.15)
    bpy.ops.object.shade_smooth()
    skin = bpy.data.materials.new("skin")
    skin.use_nodes = True
    tree = skin.node_tree
    diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (0.6, 0.6, 0.6, 1)
    tree.links.new(diffuse.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    bpy.context.object.data.materials.append(skin)
    # tress wants hair: one strand behind the camera.
    points = grooms.strands(2) + np.float32([0, -3, 0])
    grooms.add_hair_curves(scene, points, grooms.hair_material(Melanin=0.5))


def sky_picture():
    """A picture with a color of its own in each direction."""
    height, width = 32, 64
    image = bpy.data.images.new("sky", width, height, float_buffer=True)
    y, x = np.mgrid[0:height, 0:width]
    pixels = np.ones((height, width, 4), np.float32)
    pixels[:, :, 0] = 0.1 + 3 * ((x > 4) & (x < 12) & (y > 16))
    pixels[:, :, 1] = 0.1 + 2 * ((x > 20) & (x < 28) & (y > 10))
    pixels[:, :, 2] = 0.1 + 2 * ((x > 40) & (x < 60) & (y < 14))
    image.pixels.foreach_set(pixels.reshape(-1))
    return image


def add_sky(scene, turn=0.7, strength=1.0, image=None):
    tree = scene.world.node_tree
    texture, mapping, place = (tree.nodes.new("ShaderNode" + name) for name in ("TexEnvironment", "Mapping", "TexCoord"))
    texture.image = image or sky_picture()
    mapping.inputs["Rotation"].default_value[2] = turn
    tree.links.new(place.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs[0], texture.inputs["Vector"])
    tree.links.new(texture.outputs[0], tree.nodes["Background"].inputs["Color"])
    tree.nodes["Background"].inputs["Strength"].default_value = strength


LIGHTS = {
    "sun": lambda scene: grooms.add_light(scene, "SUN", (1, -1, 1), 2.0),
    "point": lambda scene: grooms.add_light(scene, "POINT", (0.4, -0.6, 0.3), 10.0, shadow_soft_size=0.05),
    "spot": lambda scene: grooms.add_light(scene, "SPOT", (0.4, -0.6, 0.3), 10.0, shadow_soft_size=0.02,
                                           spot_size=0.35, spot_blend=0.5),
    "area": lambda scene: grooms.add_light(scene, "AREA", (0.4, -0.6, 0.3), 10.0, size=0.4, size_y=0.2, shape="RECTANGLE"),
    "disk": lambda scene: grooms.add_light(scene, "AREA", (0.4, -0.6, 0.3), 10.0, size=0.3, shape="DISK"),
    "sky": add_sky,
}


def check_lights():
    for name, add in LIGHTS.items():
        if ONLY and name not in ONLY:
            continue
        scene = start()
        camera = grooms.add_camera(scene, eye=(0.2, -1, 0.2), lens=60)
        camera.data.shift_x = 0.1
        if name != "sky":
            scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0, 0, 0, 1)
        ball(scene)
        add(scene)
        theirs, ours, coverage = both(scene)
        here = coverage > 0.5
        difference = np.abs(theirs - ours)[here].mean() / theirs[here].mean()
        print(f"light {name:6s} ours/theirs {ours[here].mean() / theirs[here].mean():.4f}, pixels differ by "
              f"{difference:.3f}, backgrounds by {np.abs(theirs - ours)[~here].mean():.4f}")


# Strands and their radii in m at the root; /4: as much hair, in four times as many strands of a quarter of the width.
GROOMS = {
    "lock": (6000, 0.00015),
    "thin": (300, 0.0005),
    "fur": (1500, 0.001),
    "few": (5, 0.004),
}
FINER = {"lock/4": (24000, 0.00015 / 4), "thin/4": (1200, 0.0005 / 4), "thin/16": (4800, 0.0005 / 16), "fur/4": (6000, 0.001 / 4)}
COLORS = {
    "black": dict(Melanin=0.95, Melanin_Redness=0.1),
    "brown": dict(Melanin=0.6, Melanin_Redness=0.3),
    "blond": dict(Melanin=0.2, Melanin_Redness=0.3),
    "red": dict(parametrization="COLOR", Color=(0.6, 0.15, 0.05)),
    "glossy": dict(Melanin=0.4, Melanin_Redness=0.5, Roughness=0.15, Radial_Roughness=0.4, Coat=0.5),
    "rough": dict(Melanin=0.4, Melanin_Redness=0.5, Roughness=0.5, Radial_Roughness=0.5),
}


def lit_scene():
    scene = start()
    scene.render.film_transparent = TRANSPARENT
    if "A" in USED: grooms.add_light(scene, "AREA", (0.5, -0.8, 0.6), 15.0, size=0.4)
    if "S" in USED: grooms.add_light(scene, "SUN", (-1, 1.5, 1), 1.5)
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.35 * ("W" in USED),) * 3 + (1,)
    return scene


def hair_scene(groom, color):
    """groom: of GROOMS or FINER; color: of COLORS, or inputs of Principled Hair."""
    scene = lit_scene()
    material = grooms.hair_material(**(COLORS[color] if isinstance(color, str) else color))
    count, radius = {**GROOMS, **FINER}[groom]
    if groom.startswith("fur"):
        grooms.add_camera(scene, eye=(0, -0.4, 0.1), lens=95)
        ball = grooms.add_particle_hair(scene, material, bpy.data.materials.new("skin"), count=count)
        ball.particle_systems[0].settings.radius_scale = radius
    else:
        grooms.add_camera(scene, lens=95)
        grooms.add_hair_curves(scene, grooms.strands(count=count, points=13), material, radius, 0.8)
    return scene


def check_hair():
    rows = []
    for groom in GROOMS:
        row = []
        for color in COLORS:
            if ONLY and groom not in ONLY and color not in ONLY and f"{groom}.{color}" not in ONLY:
                continue
            theirs, ours, coverage = both(hair_scene(groom, color))
            here = coverage > (-1 if TRANSPARENT else 0.99)
            a, b = theirs[here].mean(0), ours[here].mean(0)
            print(f"hair {groom:5s} {color:7s} ours/theirs {np.array2string(b / a, precision=3)} mean "
                  f"{b.mean() / a.mean():.3f}, theirs {np.array2string(a, precision=4)}", flush=True)
            row.append(np.concatenate([theirs, ours], 1))
        if row:
            rows.append(np.concatenate(row, 0))
    if rows and len({row.shape for row in rows}) == 1:
        save_png(np.concatenate(rows, 1))


def save_png(pixels, name="beside_cycles.png"):
    image = bpy.data.images.new("beside", pixels.shape[1], pixels.shape[0])
    coded = np.where(pixels <= 0.0031308, 12.92 * pixels, 1.055 * np.maximum(pixels, 1e-9) ** (1 / 2.4) - 0.055)
    rgba = np.ones((*pixels.shape[:2], 4), np.float32)
    rgba[:, :, :3] = np.clip(coded, 0, 1)
    image.pixels.foreach_set(rgba[::-1].reshape(-1))
    image.filepath_raw, image.file_format = os.path.join(FOLDER, name), "PNG"
    image.save()


if __name__ == "__main__":
    os.makedirs(FOLDER, exist_ok=True)
    check_lights()
    check_hair()
