"""What denoisers need goes through Blender's compositor: blender -b --factory-startup -P denoiser_layers_test.py -- TRESS FOLDER

Renders the demo with half pictures, reads them with an Image node, feeds Denoise and writes what came through.
Where Blender is built without OpenImageDenoise, as Debian's is, Denoise hands its picture on as it is; that is reported.
"""

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
SIDE = 32


def composite(picture, folder):
    """Runs the node tree on a picture of tress; what it writes as one EXR."""
    scene = bpy.context.scene
    scene.use_nodes = True
    scene.render.resolution_x = scene.render.resolution_y = SIDE
    scene.render.resolution_percentage = 100
    tree = scene.node_tree
    tree.nodes.clear()
    image = tree.nodes.new("CompositorNodeImage")
    image.image = bpy.data.images.load(picture)
    half = tree.nodes.new("CompositorNodeMixRGB")  # (a + b) / 2
    half.inputs["Fac"].default_value = 0.5
    tree.links.new(image.outputs["half_a"], half.inputs[1])
    tree.links.new(image.outputs["half_b"], half.inputs[2])
    denoise = tree.nodes.new("CompositorNodeDenoise")
    for layer, socket in (("Combined", "Image"), ("N", "Normal"), ("albedo", "Albedo")):
        tree.links.new(image.outputs[layer], denoise.inputs[socket])
    out = tree.nodes.new("CompositorNodeOutputFile")
    out.base_path = os.path.join(folder, "through_")
    out.format.file_format, out.format.color_depth = "OPEN_EXR_MULTILAYER", "32"
    written = {"halves": half.outputs[0], "denoised": denoise.outputs[0]}
    for layer in ("Combined", "albedo", "N", "half_a_variance", "half_b_variance"):
        written[layer] = image.outputs[layer]
    out.file_slots.clear()
    for name, socket in written.items():
        out.file_slots.new(name)
        tree.links.new(socket, out.inputs[name])
    bpy.ops.render.render()
    return files.read_exr(os.path.join(folder, "through_0001.exr")).channels


def main():
    os.makedirs(FOLDER, exist_ok=True)
    picture = os.path.join(FOLDER, "picture.exr")
    subprocess.run([TRESS, "render", str(here.parents[1] / "scenes" / "demo.json"), "-o", picture, "--resolution",
                    f"{SIDE}x{SIDE}", "--spp", "8", "--layers", "albedo,N,half", "--quiet"], check=True)
    given, through = files.read_exr(picture).channels, composite(picture, FOLDER)

    def off(layer, suffixes, source, own):
        return max(np.abs(through[f"{layer}.{a}"] - given[f"{source}{b}"]).max() for a, b in zip(suffixes, own))

    found = {layer: off(layer, "RGB", source, own) for layer, source, own in (
        ("Combined", "", "RGB"), ("albedo", "albedo.", "RGB"), ("N", "N.", "XYZ"),
        ("half_a_variance", "half_a_variance.", "RGB"), ("half_b_variance", "half_b_variance.", "RGB"))}
    print("largest difference of what Blender read:", found)
    apart = off("halves", "RGB", "", "RGB")
    print("mean of the halves against beauty:", apart, "of", given["R"].max())
    denoised = np.stack([through["denoised." + c] for c in "RGB"])
    changed = np.abs(denoised - np.stack([through["Combined." + c] for c in "RGB"])).max() > 0
    print("Denoise:", "has denoised" if changed else "hands on its picture, built without OpenImageDenoise")
    good = max(found.values()) == 0 and 0 < apart < 2e-3 * given["R"].max() and np.isfinite(denoised).all()
    sys.stdout.flush()
    os._exit(0 if good else 1)


try:
    main()
except Exception:  # noqa: BLE001: Blender ends with 0 after an error
    import traceback
    traceback.print_exc()
    os._exit(1)
