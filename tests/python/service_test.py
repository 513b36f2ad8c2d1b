"""The learning service with targets written in Python."""

import os
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
        with self.assertRaisesRegex(tress.Error, "expected calls from outside of its target"):
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

    def test_wrong_slices_and_nodes_are_told(self):
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
            made.sample(slice, 0, 0, [0.5, 0.5, 0.5])
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
        for _ in range(40):
            made.look_up(slice, np.zeros(64), 0)
            report = made.publish()
            if report.rows_converged:
                break
        self.assertEqual(report.rows_converged, 1)
        self.assertTrue(made.look_up(slice, [0], [0]).all())
        np.testing.assert_allclose(made.row(slice, 0, 0)["masses"], [0.25, 0.25], atol=0.015)
        # The density of a part over its two normals at their middle.
        peak = 0.25 / (2 * np.pi * 0.3 * 0.4)
        self.assertAlmostEqual(float(made.density(slice, 0, 0, 1, 1.0, 0.5)) / peak, 1, delta=0.35)
        self.assertLess(float(made.density(slice, 0, 0, 1, -2.0, 0.5)), 0.05 * peak)
        # Draws: parts by their masses, about the places of each.
        drawn = made.sample(slice, 0, 0, np.random.default_rng(3).random((4000, 3), np.float32))
        np.testing.assert_allclose(drawn.mass, 0.5, atol=0.02)
        self.assertAlmostEqual(float(drawn.part.mean()), 0.5, delta=0.05)
        for part in (0, 1):
            of_part = drawn.azimuth[drawn.part == part]
            self.assertAlmostEqual(float(np.median(of_part)), part, delta=0.06)
        for call in (made.draw, made.evaluate):
            with self.assertRaisesRegex(tress.Error, "slice: expected one of densities"):
                call(slice, 0, 0, 0.5)


if __name__ == "__main__":
    unittest.main()
