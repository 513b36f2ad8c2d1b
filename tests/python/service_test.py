"""The learning service with targets written in Python."""

import json
import os
import pickle
import signal
import tempfile
import threading
import unittest

import numpy as np
import tress


class Beam(tress.Target):
    """A fan of rays, wider with b."""

    name = "beam-1"

    def __init__(self):
        self.threads = set()

    def trace(self, slice, a, b):
        self.threads.add(threading.get_ident())
        rays = np.arange(32)
        return a + 0.02 * b * rays, np.full(32, b / 32), rays * 0.1


def density(a, b, x, blur):
    """g of Beam, by hand."""
    azimuth = a + 0.02 * b * np.arange(32)
    turns = 2 * np.pi * np.arange(-2, 3)
    off = np.asarray(x)[..., None, None] - azimuth[:, None] - turns
    return (b / 32 * np.exp(-0.5 * (off / blur) ** 2) / (blur * np.sqrt(2 * np.pi))).sum(axis=(-1, -2))


class Dots(tress.SampledTarget):
    """Exits about two places, one a part, as heights and azimuths of normals."""

    name = "dots-1"
    parts = 2

    def draw(self, slice, a, b, stream, first, count):
        azimuth, height, part = [], [], []
        for path in range(first, first + count):
            random = np.random.default_rng([stream % 2**32, stream >> 32, path])
            part.append(path % 2)
            azimuth.append(a + part[-1] + 0.3 * random.standard_normal())
            height.append(b + 0.4 * random.standard_normal())
        return azimuth, height, part, np.full(count, 0.5)


def service(target=None, **options):
    made = tress.Service(target or Beam(), queries_before_creation=1, **options)
    return made, made.add_slice(1, axis_a=[0, 1, 2], axis_b=[0.25, 0.75], blur_rad=0.2)


def learn(made, slice, passes=10):
    a, b = np.meshgrid(np.arange(3), np.arange(2), indexing="ij")
    for number in range(passes):
        u = np.random.default_rng(number).random((64, 3, 2), np.float32)
        drawn = made.draw(slice, a, b, u)
        report = made.publish()
    return drawn, report


class Densities(unittest.TestCase):
    def test_a_row_is_the_density_that_was_traced(self):
        made, slice = service()
        x = np.linspace(-3, 3, 50)
        np.testing.assert_allclose(made.evaluate(slice, 1, 1, x), density(1, 0.75, x, 0.2), rtol=2e-3, atol=1e-4)

    def test_rows_converge_to_epsilon(self):
        made, slice = service(epsilon=0.01)
        drawn, report = learn(made, slice)
        self.assertEqual((report.rows_converged, report.misuse), (6, None))
        self.assertIn("6", repr(report))
        x = np.linspace(-np.pi, np.pi, 720, endpoint=False)
        truth, fit = density(1, 0.75, x, 0.2), made.evaluate(slice, 1, 1, x)
        self.assertLess(((truth - fit) ** 2).sum() / ((truth - truth.mean()) ** 2).sum(), 0.01)
        # Weights of what is drawn have the mass of the row as their mean, up to the fit's error.
        self.assertAlmostEqual(float((drawn.value / drawn.q)[:, 1, 1].mean()), 0.75, delta=0.05)
        row = made.row(slice, 1, 1)
        self.assertEqual(row["state"], "converged")
        self.assertGreater(len(row["components"]), 0)
        self.assertAlmostEqual(row["energy"], 0.75, delta=0.01)

    def test_tables_are_equal_to_the_bit_and_are_saved(self):
        one, other = service(), service()
        for made, slice in (one, other):
            learn(made, slice)
        self.assertEqual(one[0].hash, other[0].hash)
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "beam.cache")
            self.assertEqual(one[0].save(file)["converged_rows"], 6)
            again, slice = service()
            again.load(file)
            self.assertEqual(again.row(slice, 0, 0)["state"], "converged")
            named = Beam()
            named.name = "beam-2"
            with self.assertRaisesRegex(tress.Error, "beam.cache"):
                service(named)[0].load(file)

    def test_what_the_target_raises_comes_out_and_ends_the_service(self):
        class Broken(Beam):
            def trace(self, slice, a, b):
                raise LookupError(f"no node {a} {b} of {slice.lobe}")

        made, slice = service(Broken())
        with self.assertRaisesRegex(LookupError, "no node 1.0 0.75 of 1"):
            made.evaluate(slice, 1, 1, 0.5)
        with self.assertRaisesRegex(tress.Error, "expected a target that has answered always"):
            made.publish()

    def test_what_the_target_gives_is_checked(self):
        cases = {
            "azimuths, weights": 3,
            "arrays of one length": ([1, 2], [1]),
            "finite numbers >= 0": ([1, 2], [1, -1]),
            "finite numbers, found nan": ([1, np.nan], [1, 1]),
        }
        for message, given in cases.items():
            target = Beam()
            target.trace = lambda slice, a, b: given
            made, slice = service(target)
            with self.assertRaisesRegex(tress.Error, message):
                made.evaluate(slice, 0, 0, 0.5)

    def test_a_target_may_not_call_its_service(self):
        target = Beam()
        made, slice = service(target)
        target.trace = lambda *_: made.publish()
        with self.assertRaisesRegex(RuntimeError, "expected calls from outside of its target"):
            made.evaluate(slice, 0, 0, 0.5)

    def test_many_threads_may_ask(self):
        made, slice = service()
        failures = []

        def ask(number):
            try:
                for _ in range(5):
                    made.evaluate(slice, number % 3, 0, np.linspace(-3, 3, 2000))
                    made.publish()
            except Exception as error:
                failures.append(error)

        threads = [threading.Thread(target=ask, args=(number,)) for number in range(4)]
        [thread.start() for thread in threads]
        [thread.join() for thread in threads]
        self.assertEqual(failures, [])

    def test_ctrl_c_ends_it(self):
        class Slow(Beam):
            def trace(self, slice, a, b):
                threading.Event().wait(0.2)
                return super().trace(slice, a, b)

        made = tress.Service(Slow(), queries_before_creation=1)
        slice = made.add_slice(axis_a=np.arange(200), axis_b=[0.5])
        threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        with self.assertRaises(KeyboardInterrupt):
            made.evaluate(slice, np.arange(200), 0, 0.5)

    def test_values_of_the_callers_own_are_learned(self):
        x, other = np.linspace(-3, 3, 64), np.linspace(-0.5, 2.5, 64)
        (queried, slice), (observed, _), (neither, _) = services = service(), service(), service()
        for made, _ in services:
            made.evaluate(slice, 1, 1, x)
            made.publish()
        given = queried.answer(slice, 1, 1, other)
        self.assertEqual(tress.STATES[int(given.state[0])], "open")
        for made in (observed, neither):
            made.answer(slice, 1, 1, other[:8])  # from 8 queries on, a row is tested
        observed.observe(slice, 1, 1, given.x[8:], given.value[8:])
        for made, _ in services:
            made.publish()
        self.assertEqual(observed.hash, queried.hash)
        self.assertNotEqual(neither.hash, queried.hash)
        # A draw of the proposal with its density scores the fit, so that rows converge by it alone.
        for _ in range(12):
            u = np.random.default_rng(1).random(64, np.float32)
            drawn = observed.draw(slice, 1, 1, u)
            observed.observe(slice, 1, 1, drawn.x, drawn.value, drawn.q)
            observed.publish()
        self.assertEqual(observed.row(slice, 1, 1)["state"], "converged")

    def test_means_are_between_the_nodes(self):
        made, slice = service()
        learn(made, slice)
        x = np.linspace(-3, 3, 9)
        corners = {(a, b): made.answer(slice, a, b, x) for a in (1, 2) for b in (0, 1)}
        mean = made.mean(slice, 1.25, 0.625, x)
        for name in ("value", "q"):
            by_hand = sum(
                getattr(one, name) * (0.75 if a == 1 else 0.25) * (0.25 if b == 0 else 0.75) for (a, b), one in corners.items()
            )
            np.testing.assert_allclose(getattr(mean, name), by_hand, rtol=1e-5)
        drawn = made.draw_mean(slice, 1.25, 0.625, np.random.default_rng(2).random((7, 5), np.float32))
        np.testing.assert_array_equal(made.mean(slice, 1.25, 0.625, drawn.x).q, drawn.q)
        a, b = made.choose(slice, 1.25, 0.625, [[0.2, 0.7], [0.3, 0.8]])
        np.testing.assert_array_equal([a, b], [[2, 1], [1, 0]])

    def test_what_a_pass_was_is_reported(self):
        made, slice = service()
        self.assertFalse(made.publish_pays())
        drawn = made.draw(slice, 1, [0, 1], np.full((50, 2), 0.5, np.float32))
        self.assertTrue(made.publish_pays())
        made.credit(slice, 1, 1, np.full(50, 0.5))
        report = made.publish(paths=100)
        self.assertEqual(drawn.value.shape, (50, 2))
        rows = made.rows(slice)
        np.testing.assert_array_equal(rows["queries"], [[0, 0], [50, 50], [0, 0]])
        np.testing.assert_allclose(rows["light"], [[0, 0], [0, 0.25], [0, 0]], rtol=1e-6)
        self.assertEqual([(row["node"], row["state"]) for row in made.changed], [(2, "open"), (3, "open")])
        self.assertEqual(json.loads(report.json)["rows"]["open"], 2)

    def test_learning_may_be_off(self):
        made, slice = service()
        made.set_learning(False)
        learn(made, slice, passes=3)
        self.assertEqual(set(made.rows(slice)["state"].flat), {0})

    def test_progress_may_end_a_publish(self):
        shares = []
        made, slice = service(progress=lambda done: shares.append(done) or len(shares) < 2)
        made.evaluate(slice, [0, 1, 2], 1, 0.5)
        made.publish()
        made.evaluate(slice, [0, 1, 2], 1, 0.5)
        self.assertTrue(made.publish().cancelled)
        self.assertTrue(all(0 <= share < 1 for share in shares))

        def broken(done):
            raise LookupError("no progress")

        made, slice = service(progress=broken)
        made.evaluate(slice, 1, 1, 0.5)
        with self.assertRaisesRegex(LookupError, "no progress"):
            made.publish()
        made.evaluate(slice, 1, 1, 0.5)  # the target is whole, so the service goes on

    def test_errors_are_those_of_python_as_well(self):
        made, slice = service()
        for kind, call in {
            IndexError: lambda: made.row(slice, 3, 0),
            ValueError: lambda: made.evaluate(slice, 0, 0, np.nan),
            FileNotFoundError: lambda: made.load("none.cache"),
        }.items():
            with self.assertRaises(kind) as caught:
                call()
            self.assertIsInstance(caught.exception, tress.Error)
            self.assertEqual(str(caught.exception), str(pickle.loads(pickle.dumps(caught.exception))))
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaises(OSError) as caught:
                made.save(os.path.join(folder, "none", "beam.cache"))
            self.assertEqual(caught.exception.filename, os.path.join(folder, "none", "beam.cache"))
            self.assertEqual(caught.exception.errno, 2)
            damaged = os.path.join(folder, "damaged.cache")
            with open(damaged, "wb") as file:
                file.write(b"no cache")
            with self.assertRaises(ValueError) as caught:
                made.load(damaged)
            self.assertEqual(caught.exception.file, damaged)
        with self.assertRaises(FileNotFoundError) as caught:
            tress.render("none.json")
        self.assertEqual(caught.exception.filename, "none.json")

    def test_wrong_slices_and_nodes_are_reported(self):
        made, slice = service()
        with self.assertRaisesRegex(tress.Error, "axis_a: expected"):
            made.add_slice(axis_a=[1, 0], axis_b=[0])
        with self.assertRaisesRegex(tress.Error, r"node: expected a below 3 and b below 2, found \(3, 0\)"):
            made.row(slice, 3, 0)
        for call in (made.evaluate, made.draw, made.credit):
            with self.assertRaisesRegex(tress.Error, r"node: expected a below 3 and b below 2, found \(7, 0\)"):
                call(slice, 7, 0, 0.5)
            with self.assertRaisesRegex(tress.Error, "slice: expected one of 1, found 4"):
                call(4, 0, 0, 0.5)
        with self.assertRaisesRegex(tress.Error, "slice: expected one of samples"):
            made.hear(slice, 0, 0, 0.5, 0.5, 0, 1)
        self.assertIsNone(made.publish().misuse)

    def test_a_state_goes_on_where_it_was(self):
        made, slice = service()
        learn(made, slice, passes=2)
        other, slice = service()
        other.restore(made.state())
        for one in (made, other):
            one.credit(slice, [0, 1], 0, [0.5, 0.25])
            learn(one, slice, passes=2)
        self.assertEqual(made.hash, other.hash)


class Samples(unittest.TestCase):
    def test_rows_are_learned_from_draws(self):
        made = tress.Service(Dots(), queries_before_creation=1, epsilon=0.5)
        slice = made.add_slice(2, axis_a=[0.0], axis_b=[0.5])
        u = np.random.default_rng(3).random((4000, 3), np.float32)
        self.assertFalse(made.draw(slice, 0, 0, u[:1]).answered.any())
        for _ in range(40):
            made.draw(slice, 0, 0, u[:64])
            report = made.publish()
            if report.rows_converged:
                break
        self.assertEqual(report.rows_converged, 1)
        np.testing.assert_allclose(made.row(slice, 0, 0)["masses"], [0.25, 0.25], atol=0.015)
        # The density of a part over its two normals at their middle.
        peak = 0.25 / (2 * np.pi * 0.3 * 0.4)
        self.assertAlmostEqual(float(made.density(slice, 0, 0, 1, 1.0, 0.5)) / peak, 1, delta=0.35)
        self.assertLess(float(made.density(slice, 0, 0, 1, -2.0, 0.5)), 0.05 * peak)
        # Draws: the values of the row at their places, the weight its mass, the places about those of the parts.
        drawn = made.draw(slice, 0, 0, u)
        self.assertTrue(drawn.answered.all())
        for part in (0, 1):
            density = made.density(slice, 0, 0, part, drawn.x, drawn.height)
            np.testing.assert_array_equal(drawn.parts[:, part], density)
        np.testing.assert_allclose(drawn.parts.sum(axis=-1), drawn.value, rtol=1e-6)
        np.testing.assert_allclose(drawn.value / drawn.q, made.rows(slice)["energy"][0, 0], rtol=1e-5)
        again = made.answer(slice, 0, 0, drawn.x, drawn.height)
        np.testing.assert_array_equal([again.value, again.q], [drawn.value, drawn.q])
        # 4,000 draws of two normals of 0.3: five standard errors of the mean are 0.046; 0.03 is for the fit.
        self.assertAlmostEqual(float(drawn.x.mean()), 0.5, delta=0.08)
        self.assertAlmostEqual(float(drawn.height.mean()), 0.5, delta=0.08)
        with self.assertRaisesRegex(tress.Error, "slice: expected one of densities"):
            made.observe(slice, 0, 0, 0.5, 1.0)
        with self.assertRaises(IndexError):
            made.density(slice, 0, 0, 2, 0.0, 0.0)

    def test_coarse_rows_answer_at_once_and_are_compared_with_heard_paths(self):
        class Both(Dots, Beam):
            name = "both-1"

        dots = Both()
        made = tress.Service(dots)
        beam = made.add_slice(1, axis_a=[0, 1, 2], axis_b=[0.25], samples=False)
        axes = {"axis_a": [0.0, 0.1, 0.2], "axis_b": [0.5, 0.6, 0.7], "samples": True}
        slice = made.add_slice(2, **axes, coarse=[([0, 2], [0, 2])])
        with self.assertRaisesRegex(ValueError, "coarse: expected ascending indices"):
            made.add_slice(3, **axes, coarse=[([0, 1], [0, 2])])
        near = made.add_slice(2, [0.001], **axes, coarse=[([0, 2], [0, 2])], coarse_rows_of=slice)
        made.prepare()
        for number in (slice, near):
            self.assertTrue(made.draw(number, 1, [0, 1, 2], [0.5, 0.5, 0.5]).answered.all())
        self.assertFalse(made.draw(beam, 1, 0, 0.5).state.any())
        exits = dots.draw(None, 0.1, 0.6, 77, 0, 256)
        made.hear(slice, 1, 1, *exits)
        made.publish()
        self.assertEqual(made.heard_test["paths"], 256)
        self.assertLess(made.heard_test["chi2"], 1)
        self.assertEqual(made.refusals, [])


if __name__ == "__main__":
    unittest.main()
