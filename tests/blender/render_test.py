"""The add-on within Blender: blender -b --factory-startup -P render_test.py -- TRESS FOLDER

The picture of F12 is that of `tress render` of the exported scene, bit for bit. Any failure ends with status 1.
"""

import os
import pathlib
import subprocess
import sys
import traceback

here = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(here), str(here.parents[1] / "scenes" / "blender")]

import addon_utils  # noqa: E402
import bpy  # noqa: E402
import numpy as np  # noqa: E402

import grooms  # noqa: E402

TRESS, FOLDER = sys.argv[sys.argv.index("--") + 1:]


def expect(condition, what):
    if not condition:
        raise AssertionError(what)


def start(width=48, height=64, samples=4):
    scene = grooms.empty_scene(width, height)
    addon_utils.enable("tress_render", default_set=True)
    bpy.context.preferences.addons["tress_render"].preferences.program = TRESS
    scene.render.engine = "TRESS"
    scene.tress.samples = samples
    scene.tress.keep_folder = os.path.join(FOLDER, "kept")
    return scene


def rendered(scene, name):
    """The picture of F12, as a multi-layer EXR of floats."""
    from tress_render import files
    settings = scene.render.image_settings
    settings.file_format, settings.color_depth = "OPEN_EXR_MULTILAYER", "32"
    scene.render.filepath = os.path.join(FOLDER, name + ".exr")
    bpy.ops.render.render(write_still=True)
    return files.read_exr(scene.render.filepath)


def by_hand(*options):
    """What the program makes of the scene that was exported."""
    from tress_render import files
    kept = os.path.join(FOLDER, "kept")
    output = os.path.join(FOLDER, "by_hand.exr")
    subprocess.run([TRESS, "render", os.path.join(kept, "scene.json"), "-o", output, "--precision", "float", "--quiet",
                    "--seed", "1", *options], check=True)
    return files.read_exr(output)


def same(picture, channels, name, of):
    for mine, its in zip(channels, of):
        a, b = picture.channels[f"ViewLayer.{name}.{mine}"], its
        expect(a.shape == b.shape and (a == b).all(), f"{name}.{mine}: pixels differ, by {np.abs(a - b).max():g} at most")


def lock(scene):
    grooms.add_camera(scene, lens=90)
    grooms.add_light(scene, "AREA", (0.5, -0.8, 0.6), 20.0, size=0.3)
    grooms.add_light(scene, "SUN", (-1, 0.5, 1), 1.0)
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.3, 0.3, 0.35, 1)
    grooms.add_hair_curves(scene, grooms.strands(), grooms.hair_material(Melanin=0.5, Melanin_Redness=0.4))


def test_the_picture_and_its_passes_are_those_of_the_program():
    scene = start()
    lock(scene)
    scene.view_layers[0].use_pass_normal = True
    scene.tress.pass_lobes = scene.tress.pass_albedo = True
    picture, program = rendered(scene, "lock"), by_hand()
    same(picture, "RGBA", "Combined", [program.channels[c] for c in "RGBA"])
    same(picture, "XYZ", "Normal", [program.channels[f"N.{c}"] for c in "XYZ"])
    for name in ("R", "TT", "TRT", "Albedo", "Background"):
        lower = name if name.isupper() else name.lower()
        same(picture, "RGB", name, [program.channels[f"{lower}.{c}"] for c in "RGB"])
    expect(program.channels["coverage"].max() == 1, "there is no hair in the picture")


def test_a_filtered_picture_has_the_noisy_one_beside_it():
    scene = start(samples=8)
    lock(scene)
    scene.tress.denoise = True
    picture, program = rendered(scene, "filtered"), by_hand("--denoise")
    same(picture, "RGBA", "Combined", [program.channels[c] for c in ("denoised.R", "denoised.G", "denoised.B", "A")])
    same(picture, "RGBA", "Noisy Image", [program.channels[c] for c in "RGBA"])
    expect((program.channels["denoised.G"] != program.channels["G"]).any(), "nothing was filtered")


def test_a_border_renders_its_part():
    scene = start()
    lock(scene)
    whole = rendered(scene, "whole")
    render = scene.render
    render.use_border = render.use_crop_to_border = True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.75, 0.5, 1
    part = rendered(scene, "part")
    for c in "RGB":
        name = f"ViewLayer.Combined.{c}"
        expect((part.channels[name] == whole.channels[name][:32, 12:36]).all(), "the border shows another part")


def test_particle_hair_and_its_emitter_are_handed_over():
    import json
    scene = start()
    grooms.add_camera(scene, eye=(0, -0.4, 0.1), lens=90)
    grooms.add_light(scene, "POINT", (0.3, -0.4, 0.4), 5.0, shadow_soft_size=0.05)
    skin = bpy.data.materials.new("skin")
    skin.use_nodes = True
    grooms.add_particle_hair(scene, grooms.hair_material(Melanin=0.3), skin)
    picture, program = rendered(scene, "fur"), by_hand()
    same(picture, "RGBA", "Combined", [program.channels[c] for c in "RGBA"])
    keys = json.loads(pathlib.Path(FOLDER, "kept", "scene.json").read_text())
    expect(len(keys["grooms"]) == 1 and len(keys["meshes"]) == 1, "one groom and one mesh are expected")
    printed = subprocess.run([TRESS, "info", os.path.join(FOLDER, "kept", keys["grooms"][0]["file"])], check=True,
                          capture_output=True, text=True).stdout
    expect("strands   1000" in printed, "1000 strands are expected: " + printed)


def coverage_by(scene, engine, seed):
    from tress_render import files
    scene.render.engine = engine
    scene.cycles.seed = scene.tress.seed = seed
    scene.render.filepath = os.path.join(FOLDER, f"shape_{engine}_{seed}.exr")
    bpy.ops.render.render(write_still=True)
    channels = files.read_exr(scene.render.filepath).channels
    return next(pixels for name, pixels in channels.items() if name.split(".")[-1] == "A")


def overlap(a, b):
    return float(np.minimum(a, b).sum() / max(a.sum(), b.sum()))


def test_sparse_strands_have_the_shape_that_cycles_draws():
    """Arcs, curls and short strands of few points, by coverage: as near to Cycles as another seed of Cycles is, less
    0.03 for Cycles' straight pieces."""
    t = np.linspace(0, 1, 5)
    curl = np.stack([0.06 * np.cos(4 * np.pi * t), 0 * t, 0.2 * t - 0.1], 1)
    arcs = {n: 0.1 * np.stack([np.cos(np.linspace(0, np.pi, n)), np.zeros(n), np.sin(np.linspace(0, np.pi, n)) - 0.5], 1)
            for n in (3, 4, 6)}
    shapes = {"arc of 3": [arcs[3]], "arc of 4": [arcs[4]], "arc of 6": [arcs[6]], "curl": [curl],
              "short": [0.3 * arcs[3] + (0.03 * k - 0.08, 0, 0) for k in range(6)]}
    for name, strands in shapes.items():
        scene = start(96, 96, samples=64)
        camera = grooms.add_camera(scene, eye=(0, -1, 0))
        camera.data.type, camera.data.ortho_scale = "ORTHO", 0.26
        grooms.add_hair_curves(scene, np.array(strands, np.float32), grooms.hair_material(Melanin=0.5), radius=0.001,
                               tip=1.0)
        scene.render.film_transparent = True
        settings = scene.render.image_settings
        settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGBA", "32"
        scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.device = 64, False, "CPU"
        scene.cycles_curves.subdivisions = 4
        cycles = coverage_by(scene, "CYCLES", 1)
        same_shape, found = overlap(cycles, coverage_by(scene, "CYCLES", 2)), overlap(cycles, coverage_by(scene, "TRESS", 1))
        print(f"{name}: overlap with Cycles {found:.3f}, of two seeds of it {same_shape:.3f}")
        expect(found > same_shape - 0.03, f"{name}: the overlap with Cycles is {found:.3f}, of two seeds {same_shape:.3f}")


def test_huangs_model_hands_over_its_aspect_ratio_and_gains_where_blender_has_it():
    import json
    scene = start(samples=1)
    lock(scene)
    node = scene.objects["lock"].material_slots[0].material.node_tree.nodes["Principled Hair BSDF"]
    has_huang = hasattr(node, "model")  # from 4.0 on
    if has_huang:
        node.model = "HUANG"
        node.inputs["Aspect Ratio"].default_value, node.inputs["Transmission"].default_value = 0.6, 0.5
    picture, program = rendered(scene, "huang"), by_hand()
    same(picture, "RGBA", "Combined", [program.channels[c] for c in "RGBA"])
    material = json.loads(pathlib.Path(FOLDER, "kept", "scene.json").read_text())["materials"][0]
    expect(("radial_roughness" in material["principled"]) != has_huang, f"keys of another model: {material}")
    if has_huang:
        expect(abs(material["principled"]["aspect_ratio"] - 0.6) < 1e-6, f"another aspect ratio: {material}")
        expect(material["gain"] == {"R": 1.0, "TT": 0.5, "TRT": 1.0}, f"other gains: {material}")


def test_a_light_is_linked_to_what_blender_links_it_to_where_it_does():
    import json
    scene = start(64, 32, samples=16)
    grooms.add_camera(scene, lens=60)
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0, 0, 0, 1)
    for side in (-1, 1):
        grooms.add_hair_curves(scene, grooms.strands() + np.float32([0.1 * side, 0, 0]), grooms.hair_material(), name=f"lock {side}")
    lamp = grooms.add_light(scene, "SUN", (0.5, -1, 1), 3.0)
    has_links = hasattr(lamp, "light_linking")  # from 4.0 on
    if has_links:
        lamp.light_linking.receiver_collection = linked = bpy.data.collections.new("linked")
        linked.objects.link(scene.objects["lock 1"])
    picture = rendered(scene, "linked")
    light = json.loads(pathlib.Path(FOLDER, "kept", "scene.json").read_text())["lights"][0]
    expect(light.get("light_link") == ({"include": ["lock 1"]} if has_links else None), f"other links: {light}")
    left, right = (picture.channels["ViewLayer.Combined.G"][:, half].sum() for half in (slice(0, 32), slice(32, 64)))
    expect(right > 0 and (left < 0.2 * right if has_links else left > 0.2 * right), f"the light is {left} left, {right} right")


def test_an_animation_carries_what_it_learns():
    import json
    scene = start()
    lock(scene)
    scene.tress.model = "elliptical"
    scene.frame_start, scene.frame_end = 1, 2
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = os.path.join(FOLDER, "frame")
    bpy.ops.render.render(animation=True)
    lines = pathlib.Path(FOLDER, "kept", "telemetry.jsonl").read_text().splitlines()
    known = json.loads(lines[-1])["warm_cache"]["rows_known"]
    expect(known > 0, f"the second frame began with {known} rows")
    expect(os.path.exists(os.path.join(FOLDER, "frame0002.exr")), "there is no second frame")


def test_random_roughness_is_of_every_strand_whatever_it_is():
    import json
    scene = start(samples=1)
    lock(scene)
    node = scene.objects["lock"].material_slots[0].material.node_tree.nodes["Principled Hair BSDF"]
    node.inputs["Radial Roughness"].default_value = node.inputs["Random Roughness"].default_value = 0.875
    picture, program = rendered(scene, "random"), by_hand()
    same(picture, "RGBA", "Combined", [program.channels[c] for c in "RGBA"])
    material = json.loads(pathlib.Path(FOLDER, "kept", "scene.json").read_text())["materials"][0]
    expect(material["principled"]["random_roughness"] == 0.875, f"another random roughness: {material}")


def test_computed_melanin_is_baked_and_as_bright_as_the_value():
    """Melanin behind nodes that give the socket's own value at every point: the picture of the value, but for
    random numbers, within 3 % of its mean where hair covers pixels: 16 samples in some 300 pixels or more, of noise 0.5,
    have an error of 0.7 %, so that a false alarm is beyond 3 of the difference's."""
    import json
    scene = start(samples=16)
    lock(scene)
    rendered(scene, "plain")
    hair_only = by_hand().channels["coverage"] > 0.9
    expect(hair_only.sum() > 300, f"hair covers {hair_only.sum()} pixels")
    brightness = lambda name: rendered(scene, name).channels["ViewLayer.Combined.G"][hair_only].mean()
    plain = brightness("plain")
    tree = scene.objects["lock"].material_slots[0].material.node_tree
    hair = tree.nodes["Principled Hair BSDF"]
    info, mapped = tree.nodes.new("ShaderNodeHairInfo"), tree.nodes.new("ShaderNodeMapRange")
    for name, value in (("To Min", 0.5), ("To Max", 0.5)):
        mapped.inputs[name].default_value = value
    tree.links.new(info.outputs["Intercept"], mapped.inputs["Value"])
    tree.links.new(mapped.outputs[0], hair.inputs["Melanin"])
    baked = brightness("baked")
    material = json.loads(pathlib.Path(FOLDER, "kept", "scene.json").read_text())["materials"][0]
    expect(material["principled"]["color"] == "file" and "melanin" not in material["principled"], f"not baked: {material}")
    expect(abs(baked / plain - 1) < 0.03, f"baked {baked}, plain {plain}")
    mapped.inputs["To Min"].default_value = 1.0
    darker = brightness("darker")
    expect(darker < 0.9 * plain, f"darker roots {darker}, plain {plain}")


def test_principled_hair_is_rendered_by_its_own_lobes_whatever_is_asked_of_rows():
    scene = start(samples=1)
    lock(scene)
    picture = rendered(scene, "own")
    same(picture, "RGBA", "Combined", [by_hand("--model", "chiang2016").channels[c] for c in "RGBA"])
    scene.tress.warm_cache = os.path.join(FOLDER, "asked.cache")
    picture = rendered(scene, "rows")
    same(picture, "RGBA", "Combined", [by_hand("--model", "chiang2016").channels[c] for c in "RGBA"])
    expect(not os.path.exists(scene.tress.warm_cache), "a model without rows has written a cache")


def test_a_scene_without_hair_is_an_error_with_a_reason():
    scene = start()
    grooms.add_camera(scene)
    try:
        bpy.ops.render.render()
    except RuntimeError as error:
        expect("no hair" in str(error), f"another reason is given: {error}")
    else:
        raise AssertionError("a scene without hair was rendered")


def main():
    os.makedirs(FOLDER, exist_ok=True)
    failed = 0
    for name, test in sorted(globals().items()):
        if not name.startswith("test_"):
            continue
        try:
            test()
            print("passed", name)
        except Exception:  # noqa: BLE001: whatever it is, the others are tried too
            failed += 1
            print("FAILED", name)
            traceback.print_exc()
    sys.stdout.flush()
    os._exit(1 if failed else 0)


main()
