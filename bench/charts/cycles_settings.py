"""For Blender, before ../shared/tools/cycles_peer/render.py: the seed, and estimates without bias, from the environment.

CYCLES_SEED: the seed. CYCLES_UNBIASED=1: no clamping, no blurred glossy bounces, no light left out for being weak, as in ours;
else Blender's defaults."""
import os

import bpy


@bpy.app.handlers.persistent
def set_up(scene, *_):
    scene.cycles.seed = int(os.environ.get("CYCLES_SEED", "0"))
    if os.environ.get("CYCLES_UNBIASED") == "1":
        scene.cycles.sample_clamp_direct = scene.cycles.sample_clamp_indirect = 0
        scene.cycles.blur_glossy = 0
        scene.cycles.light_sampling_threshold = 0


bpy.app.handlers.render_init.append(set_up)
