"""What Cycles makes of Principled Hair: blender -b --factory-startup -P cycles.py -- /bin/true FOLDER [GROOM.LOOK...]

For each groom and look of tests/blender/beside_cycles.py, on a transparent film: FOLDER/GROOM.LOOK/scene.json, which the add-on wrote, and
cycles.npz beside it: `seeds`, (SEEDS, 3), the mean of each channel by seed, and `picture`, (height, width, 4), the mean of their pictures. The program
`/bin/true` stands for tress, so that nothing else is rendered; mapping.py renders the scenes. What is there already stays.
SAMPLES (48), SEEDS (4) and SIZE (64, pixels) are read from the environment. Names may have a FINER groom and a look of HELD_OUT.
"""

import os
import pathlib
import sys

here = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(here), str(here.parents[1] / "tests" / "blender")]
os.environ.setdefault("SAMPLES", "48")
os.environ["TRANSPARENT"] = "1"

import bpy  # noqa: E402
import numpy as np  # noqa: E402

import beside_cycles as beside  # noqa: E402
from looks import HELD_OUT  # noqa: E402

SEEDS = int(os.environ.get("SEEDS", "4"))
LOOKS = {**beside.COLORS, **HELD_OUT}


def cycles_of(name):
    folder = os.path.join(beside.FOLDER, name.replace("/", "_"))
    os.makedirs(folder, exist_ok=True)
    if os.path.exists(os.path.join(folder, "cycles.npz")):
        print(f"cycles {name:14s} is there", flush=True)
        return
    groom, look = name.split(".")
    scene = beside.hair_scene(groom, LOOKS[look])
    scene.tress.keep_folder = folder
    scene.render.engine = "TRESS"
    scene.render.filepath = os.path.join(folder, "nothing.exr")
    bpy.ops.render.render(write_still=True)
    os.remove(scene.render.filepath)
    from tress_render import files
    scene.render.engine = "CYCLES"
    scene.render.filepath = os.path.join(folder, "cycles.exr")
    scene.render.image_settings.color_mode = "RGBA"
    pictures = []
    for seed in range(SEEDS):
        scene.cycles.seed = seed
        bpy.ops.render.render(write_still=True)
        channels = files.read_exr(scene.render.filepath).channels
        pictures.append(np.stack([channels[c] for c in "RGBA"], 2))
    os.remove(scene.render.filepath)
    seeds = np.array([picture[:, :, :3].mean((0, 1)) for picture in pictures])
    np.savez(os.path.join(folder, "cycles.npz"), seeds=seeds, picture=np.mean(pictures, 0))
    error = seeds.mean(1).std(ddof=1) / np.sqrt(SEEDS) / seeds.mean() if SEEDS > 1 else np.nan
    print(f"cycles {name:14s} {np.array2string(seeds.mean(0), precision=5)} error of the mean {error:.4f}", flush=True)


for wanted in beside.ONLY or [f"{groom}.{look}" for groom in ("lock", "thin", "fur") for look in LOOKS]:
    cycles_of(wanted)
