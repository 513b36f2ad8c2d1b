"""Pictures: the bits of the program, arrays without copies, ends that were asked for."""

import gc
import json
import os
import pathlib
import signal
import subprocess
import tempfile
import threading
import time
import unittest
import unittest.mock

import numpy as np
import tress
from support import BINARY, SOURCE, lock

SIZE = {"width": 40, "height": 40}


def scene_of_arrays(**keys):
    keys.setdefault("materials", [tress.Material(hair="auburn")])
    return tress.Scene(grooms=[tress.Strands(lock())], **keys)


class Bits(unittest.TestCase):
    def by_program(self, folder, scene, *options, samples=3):
        file = os.path.join(folder, "program.exr")
        command = [BINARY, "render", scene, "-o", file, "--resolution", "40x40", "--precision", "float", "--quiet"]
        subprocess.run([*map(str, command), "--spp", str(samples), *options], check=True)
        return tress.read_exr(file)

    def assert_same(self, ours, theirs):
        self.assertEqual(set(ours.channels), set(theirs.channels))
        for name in theirs.channels:
            np.testing.assert_array_equal(ours.channel(name), theirs.channel(name), name)

    def test_of_a_scene_file_are_those_of_the_program(self):
        for name in ("demo.json", "portrait.json", "sky.json"):
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                file = SOURCE / "scenes" / name
                theirs = self.by_program(folder, file)
                self.assert_same(tress.render(file, samples=3, threads=1, **SIZE), theirs)
                self.assert_same(tress.render(tress.Scene.load(file), samples=3, **SIZE), theirs)

    def test_of_the_other_options_too(self):
        scene = SOURCE / "scenes/brown_lock.json"
        with tempfile.TemporaryDirectory() as folder:
            options = ("--model", "chiang2016", "--seed", "7", "--max-depth", "5", "--light-samples", "1")
            theirs = self.by_program(folder, scene, *options)
            self.assert_same(
                tress.render(scene, samples=3, model="chiang2016", seed=7, max_depth=5, light_samples=1, **SIZE), theirs
            )

    def test_filtered_ones_too_and_a_png_shows_them(self):
        scene = SOURCE / "scenes/brown_lock.json"
        with tempfile.TemporaryDirectory() as folder:
            theirs = self.by_program(folder, scene, "--denoise", samples=8)
            ours = tress.render(scene, samples=8, denoise=True, **SIZE)
            self.assert_same(ours, theirs)
            self.assertEqual(ours.metadata["denoised_noise"], theirs.metadata["denoised_noise"])
            self.assertLess(ours.stats["denoised_noise"], ours.stats["noise"])
            ours.save(os.path.join(folder, "ours.png"))
            by_program = pathlib.Path(folder, "program.png").read_bytes()
            self.assertEqual(pathlib.Path(folder, "ours.png").read_bytes(), by_program)
            less_noisy = tress.render(scene, noise=0.6 * ours.stats["denoised_noise"], denoise=True, adaptive=False, **SIZE)
            self.assertLessEqual(less_noisy.stats["denoised_noise"], 0.6 * ours.stats["denoised_noise"])
            self.assertGreater(less_noisy.stats["samples_per_pixel"], 8)
        with self.assertRaisesRegex(tress.Error, "denoise: expected 4 samples a pixel at least, found 3"):
            tress.render(scene, samples=3, denoise=True, **SIZE)

    def test_of_strands_in_memory_are_those_of_the_same_strands_in_a_file(self):
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "lock.usda")
            write_usda(file, lock())
            read = tress.read_groom(file)
            np.testing.assert_array_equal(read.points, lock().reshape(-1, 3))
            of_file = {"grooms": [{"file": "lock.usda"}], "materials": [{"hair": "red"}]}
            pathlib.Path(folder, "scene.json").write_text(json.dumps(of_file))
            of_memory = tress.Scene(grooms=[tress.Groom(strands=read, name="lock")], materials=[tress.Material(hair="red")])
            self.assert_same(
                tress.render(of_memory, samples=2, **SIZE), tress.render(os.path.join(folder, "scene.json"), samples=2, **SIZE)
            )

    def test_colors_at_points_and_ramps_of_the_same_colors_are_the_same_picture(self):
        shares = np.linspace(0, 1, 8, dtype=np.float32)[:, None]
        colors = np.tile((1 - shares) * [0.05, 0.03, 0.02] + shares * [0.7, 0.5, 0.3], (300, 1))
        ramp = {"ramp": [[0, [0.05, 0.03, 0.02]], [1, [0.7, 0.5, 0.3]]]}

        def albedo(source, **of_strands):
            groom = tress.Groom(strands=tress.Strands(lock(), width=0.05, basis="linear", **of_strands))
            scene = tress.Scene(grooms=[groom], materials=[tress.Material(color=source)])
            picture = tress.render(scene, samples=16, model="elliptical", **SIZE)
            return np.nanmean(picture["albedo"][:, :, 0], axis=1)

        at_points, along, named = albedo("file", color=colors), albedo(ramp), albedo({"attribute": "color"}, color=colors)
        np.testing.assert_array_equal(at_points, named)
        # Shares are of a length in float32: a few stations are rounded to the other side.
        self.assertLess(np.abs(at_points - along).mean(), 0.02 * along.mean())
        self.assertGreater(at_points[-8:].mean(), 1.05 * at_points[:8].mean())
        with self.assertRaisesRegex(tress.Error, "/materials/0/color/ramp: expected one stop or more"):
            albedo({"ramp": []})

    def test_ids_and_root_uv_are_one_a_strand(self):
        for key, value in (("id", [1, 2, 3]), ("root_uv", [[0, 0]] * 3)):
            strands = tress.Strands(lock(), **{key: value})
            with self.assertRaisesRegex(tress.Error, f"{key}: expected 300 values, one a strand, found 3"):
                tress.render(tress.Scene(grooms=[strands]), samples=1, **SIZE)

    def test_layers_of_data_are_there_if_asked_for(self):
        ids = np.arange(300) + 5
        scene = tress.Scene(grooms=[tress.Strands(lock(), id=ids, root_uv=np.full((300, 2), [0.25, 0.5]))])
        names = ["P", "strand_uv", "strand_place", "strand_id", "CryptoStrand"]
        picture = tress.render(scene, samples=2, layers=names, **SIZE)
        seen = picture["coverage"] > 0
        self.assertTrue(seen.any())
        self.assertTrue(np.isin(picture["strand_id"][seen], ids).all())
        self.assertTrue((picture["strand_uv"][seen] == [0.25, 0.5]).all())
        self.assertIn("CryptoStrand00", picture)
        self.assertFalse(any(name in tress.render(scene, samples=1, **SIZE) for name in [*names, "CryptoStrand00"]))
        with self.assertRaisesRegex(tress.Error, 'layers: expected some of P, strand_uv, .*, found "Q"'):
            tress.render(scene, samples=1, layers=["Q"], **SIZE)

    def test_of_a_mesh_and_a_sky_in_memory_are_those_of_files(self):
        corners = np.array([[-9, 2, -9], [9, 2, -9], [9, 2, 9], [-9, 2, 9]], np.float32)
        triangles = [[0, 1, 2], [0, 2, 3]]
        with tempfile.TemporaryDirectory() as folder:
            lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles]
            pathlib.Path(folder, "wall.obj").write_text("\n".join(lines))
            sky = tress.render(SOURCE / "scenes/sky.json", samples=1, width=16, height=8)
            sky.save(os.path.join(folder, "sky.exr"), precision="float")
            pixels = sky["beauty"][:, :, :3]
            of_files = scene_of_arrays(
                meshes=[tress.Mesh(file="wall.obj", albedo=[0.5, 0.4, 0.3])], environment=tress.Environment(file="sky.exr")
            )
            of_files.folder = folder
            of_memory = scene_of_arrays(
                meshes=[tress.Mesh(triangles=tress.Triangles(corners, triangles), albedo=[0.5, 0.4, 0.3])],
                environment=tress.Environment(pixels=pixels),
            )
            a, b = (tress.render(scene, samples=2, mattes=False, **SIZE) for scene in (of_files, of_memory))
            self.assert_same(a, b)
            self.assertTrue(tress.compare(a, b)["identical"])
            self.assertFalse(tress.compare(a, tress.render(scene_of_arrays(), samples=2, mattes=False, **SIZE))["identical"])


def write_usda(file, strands):
    counts = ", ".join(str(len(strand)) for strand in strands)
    points = ", ".join("(%r, %r, %r)" % tuple(map(float, point)) for point in strands.reshape(-1, 3))
    pathlib.Path(file).write_text(
        '#usda 1.0\n(\n  metersPerUnit = 0.01\n  upAxis = "Z"\n)\ndef BasisCurves "hair"\n{\n'
        '  uniform token type = "linear"\n  uniform token wrap = "nonperiodic"\n'
        f"  int[] curveVertexCounts = [{counts}]\n  point3f[] points = [{points}]\n"
        '  float[] widths = [0.01] (interpolation = "constant")\n}\n'
    )


class Layers(unittest.TestCase):
    def setUp(self):
        self.picture = tress.render(scene_of_arrays(), samples=2, width=24, height=16)

    def test_are_arrays_over_the_picture_that_keep_it(self):
        red = self.picture.channel("R")
        self.assertEqual((red.shape, red.dtype), ((16, 24), np.float32))
        self.assertTrue(np.shares_memory(red, self.picture.channel("R")))
        mean = float(red.mean())
        del self.picture
        gc.collect()
        self.assertEqual(float(red.mean()), mean)

    def test_add_up_to_beauty_in_the_order_of_the_colors(self):
        beauty = self.picture["beauty"]
        self.assertEqual(beauty.shape, (16, 24, 4))
        for c, name in enumerate("RGBA"):
            np.testing.assert_array_equal(beauty[:, :, c], self.picture.channel(name))
        parts = ("R", "TT", "TRT", "TRRT", "residual", "surface", "background")
        total = sum(np.stack([self.picture.channel(f"{part}.{c}") for c in "RGB"], -1) for part in parts)
        np.testing.assert_allclose(total, beauty[:, :, :3], atol=2e-6)
        np.testing.assert_array_equal(self.picture["N"][:, :, 2], self.picture.channel("N.Z"))
        self.assertIn("coverage", self.picture)
        with self.assertRaisesRegex(tress.Error, "expected one of .*background.*, found 'depth'"):
            self.picture["depth"]

    def test_are_saved_and_read_again(self):
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "a.exr")
            self.picture.save(file, precision="float")
            self.assertTrue(os.path.exists(os.path.join(folder, "a.png")))
            again = tress.read_exr(file)
            np.testing.assert_array_equal(again["TRT"], self.picture["TRT"])
            self.assertEqual(again.metadata["model"], "rough")
        self.assertTrue(self.picture._repr_png_().startswith(b"\x89PNG"))
        with self.assertRaisesRegex(tress.Error, "expected a name that ends"):
            self.picture.save("a.jpg")


class Models(unittest.TestCase):
    def model_of(self, material=None, **options):
        keys = {} if material is None else {"materials": [material]}
        return tress.render(scene_of_arrays(**keys), samples=1, width=16, height=16, **options).metadata["model"]

    def test_are_those_of_the_materials_whatever_is_asked_of_accuracy(self):
        with tempfile.TemporaryDirectory() as folder:
            cache = os.path.join(folder, "a.cache")
            tress.render(scene_of_arrays(), samples=1, model="elliptical", warm_cache=cache, width=16, height=16)
            for options in (
                {},
                {"epsilon": 0.3},
                {"estimator": "exact"},
                {"picture_error": 0.3},
                {"table_memory": 64},
                {"warm_cache": cache},
            ):
                with self.subTest(options):
                    self.assertEqual(self.model_of(**options), "rough")
        principled = tress.Material(principled={"melanin": 0.5})
        self.assertEqual(self.model_of(principled), "chiang2016")
        self.assertEqual(self.model_of(tress.Material(azimuthal_sigma_deg={"TT": 12})), "elliptical")

    def test_refuse_what_they_have_not_by_name(self):
        with self.assertRaisesRegex(tress.Error, r"estimator corrected: expected .*\(elliptical\), found rough"):
            self.model_of(estimator="corrected")
        with self.assertRaisesRegex(tress.Error, "learner: expected a model whose rows a learner fits .*elliptical"):
            self.model_of(learner="sketch")
        with self.assertRaisesRegex(tress.Error, 'learner: expected one of sketch, found "eager", which only tress-lab has'):
            self.model_of(learner="eager")
        with self.assertRaisesRegex(tress.Error, 'found "ou2012", which only tress-lab has'):
            self.model_of(model="ou2012")
        with self.assertRaisesRegex(tress.Error, "epsilon: expected a model with rows .*found chiang2016"):
            self.model_of(tress.Material(principled={"melanin": 0.5}), epsilon=0.1)

    def test_without_rows_leave_a_cache_alone(self):
        with tempfile.TemporaryDirectory() as folder:
            cache = os.path.join(folder, "a.cache")
            with self.assertWarnsRegex(UserWarning, "not used and left as it is, model chiang2016 has no rows"):
                self.model_of(tress.Material(principled={"melanin": 0.5}), warm_cache=cache)
            self.assertFalse(os.path.exists(cache))


class DefaultCache(unittest.TestCase):
    def test_is_a_folder_of_the_user_within_a_limit(self):
        with tempfile.TemporaryDirectory() as folder, unittest.mock.patch.dict(os.environ, XDG_CACHE_HOME=folder):
            caches = pathlib.Path(folder, "tress")
            cold = tress.render(scene_of_arrays(), samples=4, warm_cache="default", **SIZE)
            self.assertEqual(cold.stats["cache"], "merged")
            self.assertEqual(len(list(caches.glob("*.cache"))), 1)
            warm = tress.render(scene_of_arrays(), samples=1, warm_cache="default", cache_mode="frozen", **SIZE)
            self.assertEqual(warm.stats["cache"], "loaded")
            self.assertEqual(warm.stats["cache_hash"], cold.stats["cache_hash"])
            tress.render(scene_of_arrays(), samples=1, warm_cache="default", cache_limit=0, **SIZE)
            self.assertEqual(list(caches.glob("*.cache")), [])
        with self.assertRaisesRegex(tress.Error, 'cache_limit: expected warm_cache "default"'):
            tress.render(scene_of_arrays(), samples=1, cache_limit=10, **SIZE)


class Ends(unittest.TestCase):
    def test_progress_is_reported_on_the_calling_thread_and_may_end_it(self):
        seen = []

        def progress(done):
            seen.append((done.number, done.share, threading.get_ident()))
            return done.number < 5

        picture = tress.render(scene_of_arrays(), samples=50, progress=progress, **SIZE)
        self.assertEqual([number for number, _, _ in seen], [0, 1, 2, 3, 4, 5])
        self.assertEqual({thread for _, _, thread in seen}, {threading.get_ident()})
        self.assertEqual(sorted(share for _, share, _ in seen), [share for _, share, _ in seen])
        self.assertEqual(picture.stats["stopped_by"], "caller")
        np.testing.assert_array_equal(picture["beauty"], tress.render(scene_of_arrays(), samples=3, **SIZE)["beauty"])

    def test_what_a_callback_raises_comes_out(self):
        def progress(done):
            raise LookupError(f"pass {done.number}")

        with self.assertRaisesRegex(LookupError, "^'?pass 0'?$"):
            tress.render(scene_of_arrays(), samples=50, progress=progress, **SIZE)

    def test_by_noise_has_less_of_it(self):
        picture = tress.render(scene_of_arrays(), noise=0.3, **SIZE)
        self.assertEqual(picture.stats["stopped_by"], "noise")
        self.assertLessEqual(picture.stats["noise"], 0.3)

    def test_by_time(self):
        self.assertEqual(tress.render(scene_of_arrays(), seconds=0.5, **SIZE).stats["stopped_by"], "time")

    def test_ctrl_c_is_an_exception_and_the_cache_is_saved(self):
        with tempfile.TemporaryDirectory() as folder:
            cache = os.path.join(folder, "a.cache")
            learned = threading.Event()  # after passes, not after seconds: a busy machine learns less in one

            def interrupt():
                learned.wait()
                os.kill(os.getpid(), signal.SIGINT)

            def progress(done):
                if done.number == 8:
                    learned.set()

            threading.Thread(target=interrupt, daemon=True).start()
            start = time.monotonic()
            with self.assertRaises(KeyboardInterrupt):
                tress.render(
                    scene_of_arrays(),
                    samples=100000,
                    model="elliptical",
                    warm_cache=cache,
                    progress=progress,
                    **SIZE,
                )
            self.assertLess(time.monotonic() - start, 20)
            warm = tress.render(
                scene_of_arrays(), samples=1, model="elliptical", warm_cache=cache, cache_mode="frozen", **SIZE
            )
            self.assertEqual(warm.stats["cache"], "loaded")
            self.assertLess(warm.stats["exact_queries"], 0.1 * warm.stats["queries"])

    def test_other_threads_run_meanwhile(self):
        count, done = 0, threading.Event()

        def spin():
            nonlocal count
            while not done.is_set():
                count += 1
                time.sleep(0.001)

        thread = threading.Thread(target=spin)
        thread.start()
        start = time.monotonic()
        tress.render(scene_of_arrays(), seconds=1.0, **SIZE)
        took = time.monotonic() - start
        done.set()
        thread.join()
        self.assertGreater(count, 50 * took)

    def test_a_cache_that_is_required_is_there(self):
        with self.assertRaisesRegex(tress.Error, "none.cache: expected a warm cache, found no such file"):
            tress.render(scene_of_arrays(), warm_cache="none.cache", cache_mode="require", **SIZE)

    def test_what_the_reader_warns_of_is_a_warning(self):
        points = lock()
        points[0] = points[0, 0]
        with self.assertWarnsRegex(UserWarning, "1 of 300 strands are degenerate"):
            tress.render(tress.Scene(grooms=[tress.Strands(points)]), samples=1, **SIZE)


if __name__ == "__main__":
    unittest.main()
