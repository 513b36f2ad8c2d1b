"""Blender's Cryptomatte node finds single strands by their names, as they are in the picture: difference 0.
blender -b --factory-startup -P strand_mattes_test.py -- TRESS FOLDER

Renders a lock with CryptoStrand, and compares the node's mattes of the strands that are seen most, and of one that is not
there, with the sum of the coverages that the picture has under the hash of the name.
"""

import json
import os
import pathlib
import subprocess
import sys

here = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(here.parents[1] / "scenes" / "blender")]

import bpy  # noqa: E402
import numpy as np  # noqa: E402

from tress_render import files  # noqa: E402

TRESS, FOLDER = sys.argv[sys.argv.index("--") + 1:]
SIDE, STRANDS, COMPARED = 32, 60, 12


def matte_id(name):
    """The float of a name by the Cryptomatte specification 1.2: MurmurHash3, 32 bits, seed 0, exponents 0 and 255 changed."""
    def turned(x, bits):
        return (x << bits | x >> 32 - bits) & 0xffffffff

    data, state = name.encode(), 0
    padded = data + bytes(-len(data) % 4)
    for at in range(0, len(padded), 4):
        block = turned(int.from_bytes(padded[at:at + 4], "little") * 0xcc9e2d51 & 0xffffffff, 15) * 0x1b873593 & 0xffffffff
        state ^= block
        if at + 4 <= len(data):
            state = (turned(state, 13) * 5 + 0xe6546b64) & 0xffffffff
    state ^= len(data)
    for shift, factor in ((16, 0x85ebca6b), (13, 0xc2b2ae35), (16, 1)):
        state = (state ^ state >> shift) * factor & 0xffffffff
    if state >> 23 & 255 in (0, 255):
        state ^= 1 << 23
    return np.array(state, np.uint32).view(np.float32)


def by_node(picture, names):
    """The mattes of the names, by one Cryptomatte node each."""
    scene = bpy.context.scene
    scene.use_nodes = True
    scene.render.resolution_x = scene.render.resolution_y = SIDE
    scene.render.resolution_percentage = 100
    tree = scene.node_tree
    tree.nodes.clear()
    image = bpy.data.images.load(picture)
    out = tree.nodes.new("CompositorNodeOutputFile")
    out.base_path = os.path.join(FOLDER, "mattes_")
    out.format.file_format, out.format.color_depth = "OPEN_EXR_MULTILAYER", "32"
    out.file_slots.clear()
    for number, name in enumerate(names):
        node = tree.nodes.new("CompositorNodeCryptomatteV2")
        node.source = "IMAGE"
        node.image = image
        node.layer_name = "CryptoStrand"
        node.matte_id = name
        out.file_slots.new(f"matte{number}")
        tree.links.new(node.outputs["Matte"], out.inputs[f"matte{number}"])
    bpy.ops.render.render()
    channels = files.read_exr(os.path.join(FOLDER, "mattes_0001.exr")).channels
    return [channels[f"matte{number}.V"] for number in range(len(names))]


def main():
    os.makedirs(FOLDER, exist_ok=True)
    scene = os.path.join(FOLDER, "lock.json")
    pathlib.Path(scene).write_text(json.dumps({
        "materials": [{"name": "brown", "hair": "brown"}],
        "grooms": [{"name": "lock", "generate": "curtain", "strands": STRANDS, "radius_cm": 0.05, "width_cm": 6, "length_cm": 12,
                    "material": "brown"}]}))
    picture = os.path.join(FOLDER, "picture.exr")
    subprocess.run([TRESS, "render", scene, "-o", picture, "--resolution", f"{SIDE}x{SIDE}", "--spp", "8",
                    "--layers", "all,CryptoStrand", "--quiet"], check=True)
    given = files.read_exr(picture).channels
    ranks = [(given[f"CryptoStrand{layer:02}.{a}"], given[f"CryptoStrand{layer:02}.{b}"])
             for layer in range(6) for a, b in ("RG", "BA") if f"CryptoStrand{layer:02}.{a}" in given]
    names = [f"lock/{strand}" for strand in range(STRANDS)]
    expected = [sum(np.where(ids == matte_id(name), share, 0) for ids, share in ranks) for name in names]
    order = np.argsort([-matte.sum() for matte in expected])[:COMPARED]
    names, expected = [names[i] for i in order] + ["lock/99999"], [expected[i] for i in order] + [np.zeros((SIDE, SIDE))]
    seen = min(matte.sum() for matte in expected[:-1])
    off = max(np.abs(found - matte).max() for found, matte in zip(by_node(picture, names), expected))
    print(f"{len(names)} strands, each over {seen:.1f} pixels or more; largest difference {off}")
    sys.stdout.flush()
    os._exit(0 if off == 0 and seen > 1 else 1)


try:
    main()
except Exception:  # noqa: BLE001: Blender ends with 0 after an error
    import traceback
    traceback.print_exc()
    os._exit(1)
