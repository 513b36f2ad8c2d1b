"""The lock of tests/references/straight_lock.py by Cycles: blender -b --factory-startup -P straight_lock_cycles.py -- FOLDER [ROUGHNESS]"""

import math
import os
import pathlib
import sys

here = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(here), str(here.parents[1] / "scenes" / "blender" / "tress_render")]

import bpy  # noqa: E402
import numpy as np  # noqa: E402

import files  # noqa: E402
import grooms  # noqa: E402

FOLDER, *ROUGHNESS = sys.argv[sys.argv.index("--") + 1:]
STRANDS, HALF_LENGTH = 150, 4.0
random = np.random.default_rng(7)  # the strands of straight_lock.py
angle, away = random.uniform(0, 2 * math.pi, STRANDS), np.sqrt(random.uniform(0, 1, STRANDS))
points = np.zeros((STRANDS, 4, 3), np.float32)
points[:, :, 0], points[:, :, 1] = (away * np.cos(angle))[:, None], (away * np.sin(angle))[:, None]
points[:, :, 2] = np.linspace(HALF_LENGTH, -HALF_LENGTH, 4)

scene = grooms.empty_scene(64, 64)
scene.render.engine, scene.cycles_curves.shape = "CYCLES", "RIBBONS"
cycles = scene.cycles
cycles.samples, cycles.use_denoising, cycles.use_adaptive_sampling = 128, False, False
cycles.sample_clamp_indirect = cycles.blur_glossy = 0
scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
scene.render.filepath = os.path.join(FOLDER, "straight_lock.exr")
scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0, 0, 0, 1)
camera = grooms.add_camera(scene, eye=(0, -40, 0)).data
camera.sensor_fit, camera.angle = "VERTICAL", math.radians(2)
grooms.add_light(scene, "SUN", (0, -1, 0.65), 2.0, angle=0.1)
white = grooms.hair_material(Melanin=0.0, Roughness=float((ROUGHNESS or [0.3])[0]), Radial_Roughness=0.3, Offset=0.0)
grooms.add_hair_curves(scene, points, white, 0.05, 1.0)
for bounces in (0, 1, 2, 64):
    for kind in ("max", "transmission", "glossy", "diffuse"):
        setattr(cycles, kind + "_bounces", bounces)
    bpy.ops.render.render(write_still=True)
    print("hits", bounces + (bounces < 64), "mean", files.read_exr(scene.render.filepath).channels["R"].mean(), flush=True)
