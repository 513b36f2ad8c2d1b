"""Plain objects are the keys of the scene file; arrays are checked; nothing is copied that need not be."""

import dataclasses
import json
import pathlib
import unittest

import numpy as np
import tress
from support import SOURCE, two_strands

SCHEMA = json.loads((SOURCE / "scenes/schema.json").read_text())["properties"]
OBJECTS = {
    "camera": (tress.Camera, set()),
    "image": (tress.Image, set()),
    "environment": (tress.Environment, {"pixels"}),
    "lights": (tress.Light, set()),
    "meshes": (tress.Mesh, {"triangles"}),
    "materials": (tress.Material, set()),
    "grooms": (tress.Groom, set()),
}


def refusal(test, call, *arguments, **keywords):
    with test.assertRaises(tress.Error) as caught:
        call(*arguments, **keywords)
    return caught.exception


class Objects(unittest.TestCase):
    def test_have_the_keys_of_the_schema_and_no_others(self):
        for key, (kind, arrays) in OBJECTS.items():
            schema = SCHEMA[key].get("items", SCHEMA[key])["properties"]
            fields = {item.name for item in dataclasses.fields(kind)} - {"_other"}
            self.assertEqual(fields - arrays, set(schema), key)
        scene = {item.name for item in dataclasses.fields(tress.Scene)} - {"_other", "folder"}
        self.assertEqual(scene, set(SCHEMA) - {"$schema"})

    def test_load_every_scene_and_give_back_its_keys(self):
        files = [file for file in (SOURCE / "scenes").glob("*.json") if file.name != "schema.json"]
        self.assertGreater(len(files), 8)
        for file in files:
            self.assertEqual(tress.Scene.load(file).keys(), json.loads(file.read_text()), file.name)

    def test_an_attribute_that_is_no_key_cannot_be_set(self):
        with self.assertRaises(AttributeError):
            tress.Material().colour = [1, 0, 0]

    def test_a_key_that_nobody_knows_is_refused_by_the_reader_with_its_place(self):
        scene = tress.Scene.from_keys({"grooms": [{"generate": "single_fiber", "colour": 1}]})
        error = refusal(self, tress.render, scene)
        self.assertEqual(error.place, "/grooms/0/colour")
        self.assertEqual(str(error), f"scene: /grooms/0/colour: expected {error.expected}, found {error.found}")


class Arrays(unittest.TestCase):
    def test_points_that_are_float32_stay_where_they_are(self):
        points = np.zeros((5, 4, 3), np.float32)
        self.assertTrue(np.shares_memory(tress.Strands(points).points, points))
        self.assertFalse(np.shares_memory(tress.Strands(points[:, ::2]).points, points))
        self.assertEqual(tress.Strands(points.astype(float)).points.dtype, np.float32)

    def test_widths_are_given_for_all_a_strand_or_a_point(self):
        points = np.zeros((2, 3, 3), np.float32)
        for width, expected in ((1, [1] * 6), ([1, 2], [1, 1, 1, 2, 2, 2]), (np.arange(6), [0, 1, 2, 3, 4, 5])):
            np.testing.assert_array_equal(tress.Strands(points, width=width).width, expected)

    def test_what_does_not_fit_names_the_array(self):
        points = two_strands()
        cases = [
            (dict(points=points.reshape(-1, 3), counts=[8, 9]), "strands 1.counts", "2 strands of 17 points"),
            (dict(points=points, width=[1, 2, 3]), "strands 1.width", "3"),
            (dict(points=np.where(points > 4, np.nan, points)), "strands 1.points[", "nan"),
            (dict(points=points, color=[[0, 0, 2], [0, 0, 0]]), "strands 1.color[0]", "2"),
            (dict(points=points, normal=[[0, 0, 1]]), "strands 1.normal", "1"),
            (dict(points=points, basis="bezier"), "strands 1.counts[0]", "8"),
            (dict(points=points, basis="round"), "strands 1.basis", '"round"'),
        ]
        for strands, place, found in cases:
            error = refusal(self, tress.render, tress.Scene(grooms=[tress.Strands(**strands)]))
            self.assertTrue(error.place.startswith(place), error.place)
            self.assertEqual(error.found, found)
        self.assertIn("(strand, point, 3)", str(refusal(self, tress.Strands, points.reshape(-1, 3))))

    def test_triangles_name_positions_that_are_there(self):
        mesh = tress.Mesh(triangles=tress.Triangles(np.eye(3), [[0, 1, 3]]))
        error = refusal(self, tress.render, tress.Scene(grooms=[tress.Strands(two_strands())], meshes=[mesh]))
        self.assertEqual((error.place, error.found), ("mesh 1.triangles[0]", "3"))

    def test_normals_are_read_and_turn_the_fibers(self):
        read = tress.read_groom(SOURCE / "tests/scene/grooms/normals.usda")
        np.testing.assert_allclose(read.normal[:2], [[1, 0, 0], [0.5, 0.75**0.5, 0]], atol=1e-6)
        points = np.linspace(0, 1, 9, dtype=np.float32)[:, None] * [0, 0, -1] + [[[0, 0, 0]], [[0.1, 0, 0]]]
        camera = tress.Camera(eye=[0, -8, -0.5], look_at=[0, 0, -0.5], vertical_fov_deg=9)
        material = tress.Material(eccentricity=0.5, sigma_a=[1, 1, 1])

        def coverage(normal):
            strands = tress.Strands(points, width=0.06, basis="linear", normal=normal)
            picture = tress.render(tress.Scene(grooms=[strands], materials=[material], camera=camera), width=48, height=48,
                                   samples=16, seed=1)
            return float(picture["coverage"].mean())

        # Seen along the minor axis a fiber is twice as wide as along the major one. 37,000 samples: 2.5 % are one sigma.
        wide, narrow = coverage(np.full((2, 9, 3), [0, 2, 0])), coverage(np.full((2, 9, 3), [1, 0, 0]))
        self.assertAlmostEqual(wide / narrow, 2, delta=0.2)

    def test_a_groom_file_is_read_as_it_is(self):
        strands = tress.read_groom(SOURCE / "tests/fuzz/corpus/hair/plain.hair")
        self.assertEqual(len(strands.points), strands.counts.sum())
        self.assertEqual(len(strands), len(strands.counts))
        self.assertIn("no such file", str(refusal(self, tress.read_groom, "none.hair")).lower())


class Options(unittest.TestCase):
    def test_out_of_range_are_refused_by_name(self):
        scene = tress.Scene(grooms=[tress.Strands(two_strands())])
        for name, value in {"samples": 0, "noise": -1.0, "width": 70000, "epsilon": 0.0, "threads": 0}.items():
            self.assertEqual(refusal(self, tress.render, scene, **{name: value}).place, name)
        for name in ("model", "estimator", "learner", "cache_mode"):
            error = refusal(self, tress.render, scene, width=4, height=4, **{name: "none such"})
            self.assertEqual((error.place, error.found), (name, '"none such"'))

    def test_paths_are_strings_or_paths(self):
        for path in ("missing.json", pathlib.Path("missing.json")):
            self.assertEqual(refusal(self, tress.render, path).file, "missing.json")


if __name__ == "__main__":
    unittest.main()
