"""The pure part of the add-on for Blender, without Blender: files and keys from plain arrays.

files_test.py TRESS, the program that reads what was written. Fails where anything would have to be skipped.
"""

import json
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest
from types import SimpleNamespace

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scenes" / "blender"))
from tress_render import bake, files, job, nodes, scene_keys  # noqa: E402

TRESS = sys.argv.pop(1)
LOOKS_DOWN = np.eye(4)  # a lamp or camera without a turn looks along -z


def strands():
    t = np.linspace(0, 1, 5)
    one = np.stack([0 * t, 0 * t, -10 * t], 1)
    return np.array([5, 5]), np.concatenate([one, one + [1, 0, 0]]), np.linspace(0.01, 0.005, 10)


class Folder(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = self.temporary.name
        self.addCleanup(self.temporary.cleanup)

    def path(self, name):
        return os.path.join(self.folder, name)


class Socket:
    """An input of a node, linked to an output of another or to none."""

    def __init__(self, name, value, behind=None, output=""):
        self.name, self.default_value = name, value
        self.is_linked = behind is not None
        self.links = [SimpleNamespace(from_node=behind, from_socket=SimpleNamespace(name=output))] if behind else []


def ramp_node(output, interpolation, stops):
    info = SimpleNamespace(bl_idname="ShaderNodeHairInfo", bl_label="Hair Info", inputs={})
    elements = [SimpleNamespace(position=place, color=(*color, 1.0)) for place, color in stops]
    return SimpleNamespace(bl_idname="ShaderNodeValToRGB", bl_label="Color Ramp",
                           inputs={"Fac": Socket("Fac", 0.5, info, output)},
                           color_ramp=SimpleNamespace(interpolation=interpolation, elements=elements))


class HairNodes(Folder):
    """By stand-ins that have what nodes.py asks of Blender's nodes."""

    def principled(self, way, **behind):
        keys, varied, said = self.read(way, **behind)
        self.assertIsNone(varied)
        return keys, said

    def read(self, way, **behind):
        inputs = {name: Socket(name, value, behind.get(name)) for name, value in
                  (("Color", [0.1, 0.1, 0.1, 1]), ("Melanin", 0.8), ("Random Color", 0.2), ("Roughness", 0.3))}
        node = SimpleNamespace(bl_idname="ShaderNodeBsdfHairPrincipled", parametrization=way, inputs=inputs)
        output = SimpleNamespace(inputs={"Surface": Socket("Surface", None, node)})
        tree = SimpleNamespace(get_output_node=lambda target: output)
        said = scene_keys.Warnings()
        keys, varied = nodes.hair_material(SimpleNamespace(name="m", use_nodes=True, node_tree=tree), "m", said)
        return keys, varied, said.said

    def drawn(self, keys):
        """Draws it: the program takes the keys."""
        lengths, points, widths = strands()
        files.write_hair(self.path("a.hair"), lengths, points, widths)
        scene = {"image": {"width": 8, "height": 8, "samples": 1}, "materials": [keys],
                 "grooms": [{"file": "a.hair", "cm_per_unit": 1, "up": "z", "radius_cm": 0.5}]}
        pathlib.Path(self.path("s.json")).write_text(json.dumps(scene))
        subprocess.run([TRESS, "render", self.path("s.json"), "-o", self.path("a.exr"), "--quiet"], check=True)

    def test_a_ramp_over_the_intercept_is_a_ramp_along_the_strand(self):
        stops = [(0.25, (0.1, 0.2, 0.3)), (1.0, (0.9, 0.8, 2.0))]
        keys, said = self.principled("COLOR", Color=ramp_node("Intercept", "EASE", stops))
        self.assertEqual(keys["principled"]["color"], {
            "ramp": [[0.25, [0.1, 0.2, 0.3]], [1.0, [0.9, 0.8, 1.0]]], "along": "share", "interpolation": "smooth"})
        self.assertEqual(said, [])
        self.drawn(keys)
        steps, _ = self.principled("COLOR", Color=ramp_node("Intercept", "CONSTANT", [(0, (0,) * 3), (0.5, (1,) * 3)]))
        self.assertEqual(steps["principled"]["color"]["ramp"], [[0.0, [0.0] * 3], [0.4999, [0.0] * 3], [0.5, [1.0] * 3]])
        self.drawn(steps)

    def test_values_have_the_luminance_of_a_ramp(self):
        keys, _ = self.principled("MELANIN", Melanin=ramp_node("Intercept", "LINEAR", [(0, (0.9,) * 3), (1, (0.2,) * 3)]))
        ramp = keys["principled"]["melanin"]["ramp"]
        self.assertAlmostEqual(ramp[0][1], 0.9)
        self.assertAlmostEqual(ramp[1][1], 0.2)
        self.drawn(keys)

    def test_a_ramp_over_something_else_is_random_or_baked(self):
        random, said = self.principled("COLOR", Color=ramp_node("Random", "LINEAR", [(0, (0,) * 3), (1, (1,) * 3)]))
        self.assertEqual(random["principled"]["color"], {"random": [[0.0] * 3, [1.0] * 3]})
        self.assertEqual(said, [])
        self.drawn(random)
        keys, varied, said = self.read("COLOR", Color=ramp_node("Length", "LINEAR", [(0, (0,) * 3), (1, (1,) * 3)]))
        self.assertEqual((keys["principled"]["color"], varied.parametrization, said), ([0.1, 0.1, 0.1], "COLOR", []))

    def test_melanin_and_its_random_color_are_baked_where_they_are_computed(self):
        ramp = ramp_node("Length", "LINEAR", [(0, (0,) * 3), (1, (1,) * 3)])
        for name in ("Melanin", "Random Color"):
            keys, varied, said = self.read("MELANIN", **{name: ramp})
            self.assertEqual((varied is not None, said), (True, []), name)
            self.assertEqual(keys["principled"]["melanin"], 0.8)
            self.assertEqual(keys["principled"]["random_color"], 0.2)
        _, varied, said = self.read("MELANIN", Roughness=ramp)
        self.assertIsNone(varied)
        self.assertIn("Roughness is linked to Color Ramp, which is not handed over", said[0])


class Baked(unittest.TestCase):
    """Colors at the points of two strands of 10 units, the second of two pieces of which the first is the longer."""

    def strands(self, uv=None, attribute=None):
        points = np.array([[0, 0, 0], [0, 0, -10], [1, 0, 0], [1, 0, -7.5], [1, 0, -10]], float)
        return bake.Strands(np.array([2, 3]), points, lambda name: uv, lambda name: attribute)

    def info(self, output):
        return SimpleNamespace(bl_idname="ShaderNodeHairInfo", bl_label="Hair Info", inputs={}), output

    def hair(self, way="MELANIN", unknown=None, **inputs):
        usual = {"Color": [0.1, 0.1, 0.1, 1], "Absorption Coefficient": [0.2, 0.5, 1.4], "Melanin": 0.6,
                 "Melanin Redness": 0.3, "Tint": [1, 1, 1, 1], "Random Color": 0.0}
        sockets = {name: Socket(name, value, *inputs.get(name, ())) for name, value in usual.items()}
        node = SimpleNamespace(parametrization=way, inputs=sockets)
        return bake.hair_colors(node, self.strands(attribute=np.array([[0.5] * 3] * 4 + [[0.9] * 3])), 0.3, unknown)

    def paint(self):
        return SimpleNamespace(bl_idname="ShaderNodeVertexColor", bl_label="Color Attribute", layer_name="x"), "Color"

    def sigma_a(self, colors):
        slope = 5.969 - 0.215 * 0.3 + 2.532 * 0.3**2 - 10.73 * 0.3**3 + 5.574 * 0.3**4 + 0.245 * 0.3**5
        return (np.log(colors) / slope) ** 2

    def test_melanin_is_baked_as_the_color_of_its_absorption(self):
        melanin = np.array([0.5, 0.5, 0.5, 0.5, 0.9])
        pigment = 0.7 * np.array([0.506, 0.841, 1.653]) + 0.3 * np.array([0.343, 0.733, 1.924])
        expected = -np.log(1 - melanin)[:, None] * pigment
        np.testing.assert_allclose(self.sigma_a(self.hair(**{"Melanin": self.paint()})), expected, rtol=1e-5)
        # A tint of 0.5 adds its own; melanin is that of the socket.
        dyed = self.sigma_a(self.hair(**{"Tint": self.paint()}))
        tint = self.sigma_a(np.array([0.5, 0.5, 0.5, 0.5, 0.9]))[:, None]
        np.testing.assert_allclose(dyed, -np.log(0.4) * pigment + tint, rtol=1e-5)
        red = self.sigma_a(self.hair(**{"Melanin Redness": self.paint()}))[4]
        np.testing.assert_allclose(red, -np.log(0.4) * (0.1 * bake.EUMELANIN + 0.9 * bake.PHEOMELANIN), rtol=1e-5)

    def test_random_color_is_by_cycles_random_number(self):
        u = np.array([3695015161] * 2 + [1267069554] * 3) / 0xffffffff
        share = np.array([0.5, 0.5, 0.5, 0.5, 0.9])
        pigment = 0.7 * bake.EUMELANIN + 0.3 * bake.PHEOMELANIN
        expected = -np.log(1 - 0.6 * (1 + 2 * (u - 0.5) * share))[:, None] * pigment
        np.testing.assert_allclose(self.sigma_a(self.hair(**{"Random Color": self.paint()})), expected, rtol=1e-5)

    def test_absorptions_are_baked_and_inputs_without_counterpart_named(self):
        found = self.sigma_a(self.hair("ABSORPTION", **{"Absorption Coefficient": self.paint()}))
        np.testing.assert_allclose(found[:, 1], [0.5] * 4 + [0.9], rtol=1e-5)
        noise = SimpleNamespace(bl_idname="ShaderNodeTexNoise", bl_label="Noise Texture"), "Fac"
        said = []
        both = self.hair(unknown=lambda *what: said.append(tuple(map(str, what))), **{"Melanin": self.paint(), "Tint": noise})
        self.assertEqual(said, [("Tint", "Noise Texture")])
        np.testing.assert_array_equal(both, self.hair(**{"Melanin": self.paint()}))
        self.assertIsNone(self.hair(unknown=lambda *what: None, **{"Melanin": noise}))

    def colors(self, node, output="Color", **of):
        return bake.colors(Socket("Color", [0, 0, 0, 1], node, output), self.strands(**of))

    def test_hair_info_is_by_length_and_by_cycles_own_random_number(self):
        node, _ = self.info("")
        np.testing.assert_allclose(self.colors(node, "Intercept")[:, 0], [0, 1, 0, 0.75, 1])
        np.testing.assert_allclose(self.colors(node, "Length"), 1)  # 10 is clamped
        hashes = np.array([3695015161, 1267069554]) / 0xffffffff  # hash_uint2(0, 0) and (1, 0), by lookup3's own code
        np.testing.assert_allclose(self.colors(node, "Random")[:, 2], hashes[[0, 0, 1, 1, 1]], rtol=1e-6)
        with self.assertRaisesRegex(bake.Unknown, "Thickness of Hair Info"):
            self.colors(node, "Thickness")

    def test_ranges_ramps_and_mixes_are_those_of_cycles(self):
        socket = lambda x, node=None, output="": Socket("", x, node, output)
        half = SimpleNamespace(bl_idname="ShaderNodeMapRange", bl_label="Map Range", data_type="FLOAT", clamp=True,
                               interpolation_type="LINEAR", inputs={
                                   "Value": socket(0.5, *self.info("Intercept")), "From Min": socket(0.5),
                                   "From Max": socket(1.0), "To Min": socket(1.0), "To Max": socket(0.0)})
        np.testing.assert_allclose(self.colors(half)[:, 1], [1, 0, 1, 0.5, 0])
        ramp = SimpleNamespace(bl_idname="ShaderNodeValToRGB", bl_label="Color Ramp", inputs={"Fac": socket(0.5, half)},
                               color_ramp=SimpleNamespace(interpolation="LINEAR", evaluate=lambda x: (x, x * x, 1 - x, 0.5)))
        np.testing.assert_allclose(self.colors(ramp)[3], [0.5, 0.25, 0.5], atol=2e-5)  # 1 / 255^2: the table's own error
        np.testing.assert_allclose(self.colors(ramp, "Alpha"), 0.5)
        mix = SimpleNamespace(bl_idname="ShaderNodeMixRGB", bl_label="Mix", blend_type="MULTIPLY", use_clamp=False,
                              inputs=[socket(0.5), socket([0.8, 0.4, 0.2, 1]), socket(0.0, ramp, "Color")])
        np.testing.assert_allclose(self.colors(mix)[3], [0.6, 0.25, 0.15], atol=2e-5)
        mix.blend_type = "HUE"
        with self.assertRaisesRegex(bake.Unknown, "hue"):
            self.colors(mix)

    def test_a_picture_is_seen_at_the_roots_with_v_up(self):
        pixels = np.array([[[0, 0, 0], [1, 0, 0]], [[0, 1, 0], [1, 1, 0]]], float)  # top row first
        at = lambda u, v, *of: bake.looked_up(pixels, np.array([[u, v]]), *of)[0].tolist()
        self.assertEqual(at(0.25, 0.75), [0, 0, 0])
        self.assertEqual(at(0.75, 0.25), [1, 1, 0])
        self.assertEqual(at(0.5, 0.75), [0.5, 0, 0])
        self.assertEqual(at(1.25, 0.75), [0, 0, 0])
        self.assertEqual(at(1.25, 0.75, "EXTEND"), [1, 0, 0])
        self.assertEqual(at(1.25, 0.25, "CLIP"), [0, 0, 0])
        self.assertEqual(at(0.6, 0.4, "REPEAT", True), [1, 1, 0])

    def test_what_strands_do_not_have_is_named(self):
        paint = SimpleNamespace(bl_idname="ShaderNodeVertexColor", bl_label="Color Attribute", layer_name="dye")
        np.testing.assert_allclose(self.colors(paint, attribute=np.full((5, 3), 0.25)), 0.25)
        with self.assertRaisesRegex(bake.Missing, "dye"):
            self.colors(paint)
        with self.assertRaisesRegex(bake.Unknown, "Noise"):
            self.colors(SimpleNamespace(bl_idname="ShaderNodeTexNoise", bl_label="Noise Texture"))


class Files(Folder):
    def test_a_groom_is_what_tress_reads(self):
        lengths, points, widths = strands()
        files.write_hair(self.path("a.hair"), lengths, points, widths, np.full((10, 3), 0.25))
        printed = subprocess.run([TRESS, "info", self.path("a.hair")], capture_output=True, text=True, check=True).stdout
        lines = [line.split(None, 1) for line in printed.splitlines()]
        said = {line[0]: line[1] for line in lines if len(line) == 2}
        self.assertEqual((said["strands"], said["points"]), ("2", "10, 5 a strand"), printed)
        self.assertTrue(said["colors"].startswith("per point "), printed)
        self.assertIn("0.005 to 0.01", said["widths"])

    def test_arrays_that_do_not_fit_are_refused(self):
        lengths, points, widths = strands()
        for wrong in ((lengths, points[:-1], widths), (np.array([1, 9]), points, widths), (lengths, points, widths[:3])):
            with self.assertRaises(ValueError):
                files.write_hair(self.path("a.hair"), *wrong)

    def test_a_picture_that_was_written_is_read_again(self):
        pixels = np.random.default_rng(3).uniform(0, 5, (7, 5, 3)).astype(np.float32)
        files.write_exr(self.path("a.exr"), pixels)
        read = files.read_exr(self.path("a.exr"))
        self.assertEqual((read.width, read.height, read.left, read.top), (5, 7, 0, 0))
        for c, name in enumerate("RGB"):
            np.testing.assert_array_equal(read.channels[name], pixels[:, :, c])

    def test_what_is_no_picture_is_refused(self):
        pathlib.Path(self.path("a.exr")).write_bytes(b"no picture at all")
        with self.assertRaises(ValueError):
            files.read_exr(self.path("a.exr"))


class Keys(unittest.TestCase):
    def test_a_border_is_a_crop_with_y_down(self):
        self.assertEqual(scene_keys.crop((0.25, 0.5, 0.75, 1.0), 40, 20), (10, 0, 30, 10))
        self.assertEqual(scene_keys.crop((0.5, 0.5, 0.5, 0.5), 4, 4), (2, 1, 3, 2))

    def test_a_sensor_fits_the_longer_side_by_default(self):
        fit = lambda width, height, how: scene_keys.camera(LOOKS_DOWN, 100, width, height, sensor_fit=how)
        self.assertEqual(fit(200, 100, "AUTO")["sensor_fit"], "width")
        self.assertEqual(fit(100, 200, "AUTO")["sensor_fit"], "height")
        self.assertEqual((fit(100, 200, "HORIZONTAL")["sensor_fit"], fit(100, 200, "HORIZONTAL")["sensor_mm"]), ("width", 36))
        self.assertEqual((fit(200, 100, "VERTICAL")["sensor_fit"], fit(200, 100, "VERTICAL")["sensor_mm"]), ("height", 24))

    def test_shifts_are_counted_in_the_picture(self):
        keys = scene_keys.camera(LOOKS_DOWN, 100, 200, 100, shift_x=0.1, shift_y=0.1)
        self.assertAlmostEqual(keys["shift_x"], 0.1)
        self.assertAlmostEqual(keys["shift_y"], 0.2)

    def test_a_lamp_keeps_its_watts(self):
        """Flux of a Lambertian surface: pi times area times radiance."""
        ball = scene_keys.point(LOOKS_DOWN, 100, [1, 1, 1], 40.0, 0.1)["sphere"]
        self.assertAlmostEqual(math.pi * 4 * math.pi * 0.1 ** 2 * ball["radiance"][0], 40.0, places=9)
        card = scene_keys.area(LOOKS_DOWN, 100, [1, 1, 1], 40.0, "RECTANGLE", 2.0, 0.5)["rectangle"]
        self.assertAlmostEqual(4 * 1.0 * card["radiance"][0], 40.0, places=9)  # Blender's watts of a card
        flux = scene_keys.area(LOOKS_DOWN, 100, [1, 1, 1], 40.0, "RECTANGLE", 2.0, 0.5, are_true_watts=True)["rectangle"]
        self.assertAlmostEqual(math.pi * 1.0 * flux["radiance"][0], 40.0, places=9)
        self.assertEqual((card["width_cm"], card["height_cm"]), (200, 50))

    def test_a_link_is_of_the_members_of_a_collection_by_their_states(self):
        def collection(objects=(), children=()):
            states = lambda pairs: [SimpleNamespace(light_linking=SimpleNamespace(link_state=state)) for _, state in pairs]
            return SimpleNamespace(objects=[ob for ob, _ in objects], collection_objects=states(objects),
                                   children=[child for child, _ in children], collection_children=states(children))
        names = {"ball": ["ball", "ball.fur"], "head": ["head"], "lock": ["lock"]}
        of = lambda *them: scene_keys.link(collection(*them), lambda ob: names.get(ob, []))
        self.assertEqual(of([("ball", "INCLUDE"), ("lock", "INCLUDE")]), {"include": ["ball", "ball.fur", "lock"]})
        self.assertEqual(of([("ball", "EXCLUDE")]), {"exclude": ["ball", "ball.fur"]})
        self.assertEqual(of([("head", "EXCLUDE"), ("lock", "INCLUDE")]), {"include": ["lock"]})
        inner = collection([("head", "INCLUDE"), ("lock", "INCLUDE")])
        self.assertEqual(of([("lock", "INCLUDE")], [(inner, "EXCLUDE")]), {"include": []})
        self.assertEqual(of([("camera", "INCLUDE")]), {"include": []})
        self.assertIsNone(of([]))

    def test_what_has_no_counterpart_is_said_once(self):
        warnings = scene_keys.Warnings()
        for _ in range(2):
            scene_keys.area(LOOKS_DOWN, 100, [1, 1, 1], 1.0, "DISK", 1.0, 1.0, warnings=warnings)
        self.assertEqual(len(warnings.said), 1)


class Render(Folder):
    def scene(self):
        lengths, points, widths = strands()
        files.write_hair(self.path("a.hair"), lengths, points, widths)
        keys = {"image": {"width": 8, "height": 8, "samples": 2}, "environment": {"constant": [1, 1, 1]},
                "materials": [{"name": "hair", "principled": {"melanin": 0.5}}],
                "grooms": [{"file": "a.hair", "up": "z", "cm_per_unit": 1}]}
        pathlib.Path(self.path("scene.json")).write_text(json.dumps(keys))

    def test_a_job_ends_with_a_picture_and_reports_it(self):
        self.scene()
        child = job.Job(TRESS, self.folder, ["--spp", "2"], 64, samples=2)
        self.assertEqual(child.close(), 0, child.error())
        self.assertTrue(child.new_picture())
        self.assertFalse(child.new_picture())
        status = child.status()
        self.assertEqual(status.share, 1)
        self.assertIn("2 samples a pixel", status.text)
        self.assertIsNone(child.status())
        self.assertEqual(files.read_exr(child.picture).channels["A"].shape, (8, 8))

    def test_a_job_that_fails_says_why(self):
        self.scene()
        pathlib.Path(self.path("a.hair")).write_bytes(b"HAIR")
        child = job.Job(TRESS, self.folder, [], 64)
        self.assertEqual(child.close(), 1)
        self.assertIn("a.hair", child.error())

    def test_what_an_earlier_render_left_is_no_news(self):
        pathlib.Path(self.path("picture.exr")).write_bytes(b"of another size")
        pathlib.Path(self.path("telemetry.jsonl")).write_text('{"type": "pass", "pass": 7, "samples": 64}\n')
        child = job.Job(shutil.which("true"), self.folder, [], 64, samples=2)
        self.assertFalse(child.new_picture())
        self.assertIsNone(child.status())
        self.assertEqual(child.close(), 0)

    def test_a_job_can_be_ended(self):
        self.scene()
        child = job.Job(TRESS, self.folder, ["--spp", "1000000"], 64, samples=1000000)
        child.end()
        self.assertFalse(child.running())

    def test_a_program_that_is_not_there_is_named(self):
        with self.assertRaisesRegex(FileNotFoundError, "nowhere"):
            job.find_program("/nowhere/tress")


if __name__ == "__main__":
    unittest.main()
