"""One fiber: rows beside their reference as the program has them, and the BCSDF over arrays."""

import json
import os
import subprocess
import tempfile
import unittest

import numpy as np
import tress
from support import LABORATORY

CLEAR = {"sigma_a": [0, 0, 0]}


class Fit(unittest.TestCase):
    def test_is_what_the_program_prints(self):
        command = [str(LABORATORY), "fit", "--lobe", "TRT", "--e", "0.75", "--theta-d", "20", "--samples", "24", "--json"]
        printed = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        ours = tress.fit("TRT", eccentricity=0.75, theta_d=20, samples=24)
        np.testing.assert_allclose(np.degrees(ours["phi"]), printed["phi_deg"], atol=1e-12)
        for key in ("target", "fit", "energy", "relative_l2", "components", "evaluations"):
            np.testing.assert_array_equal(ours[key], printed[key], key)
        self.assertTrue(ours["converged"])
        self.assertLess(ours["relative_l2"], 0.01)

    def test_refuses_what_is_none(self):
        for place, call in {
            "lobe": lambda: tress.fit("TTT"),
            "eccentricity": lambda: tress.fit("TT", eccentricity=0.1),
            "samples": lambda: tress.fit("TT", samples=0),
        }.items():
            with self.assertRaises(tress.Error) as caught:
                call()
            self.assertEqual(caught.exception.place, place)


class Bcsdf(unittest.TestCase):
    def test_clear_hair_gives_back_what_it_gets(self):
        # S over a grid of directions: 1 in each channel, but for the grid's own error.
        fiber = tress.Bcsdf(tress.Material(roughness=0.3, eccentricity=0.8, **CLEAR))
        theta = (np.arange(96) + 0.5) / 96 * np.pi - np.pi / 2
        phi = (np.arange(96) + 0.5) / 96 * 2 * np.pi - np.pi
        values = fiber.evaluate(0.4, 0.7, theta[:, None], phi)
        self.assertEqual(values.shape, (96, 96, 3))
        np.testing.assert_allclose(values.sum(axis=(0, 1)) * (np.pi / 96) * (2 * np.pi / 96), 1, atol=0.01)

    def test_what_is_drawn_agrees_with_what_is_evaluated(self):
        fiber = tress.Bcsdf(tress.Material(hair="blond"))
        drawn = fiber.sample(np.full((3, 50), 0.2), 1.0)
        self.assertEqual((drawn.theta_i.shape, drawn.weight.shape), ((3, 50), (3, 50, 3)))
        pdf = fiber.pdf(0.2, 1.0, drawn.theta_i, drawn.phi_i)
        s = fiber.evaluate(0.2, 1.0, drawn.theta_i, drawn.phi_i)
        np.testing.assert_allclose(pdf, drawn.pdf, rtol=1e-4)
        np.testing.assert_allclose(s / pdf[..., None], drawn.weight, rtol=1e-3, atol=1e-6)
        lobes = fiber.lobes(0.2, 1.0, drawn.theta_i, drawn.phi_i)
        self.assertEqual(lobes.shape, (3, 50, 6, 3))
        np.testing.assert_allclose(lobes.sum(axis=-2), s, rtol=1e-5)

    def test_the_same_call_gives_the_same_bits_and_another_stream_others(self):
        fiber = tress.Bcsdf(tress.Material(hair="red"))
        first, again, other = (fiber.sample(np.zeros(64), 0.5, stream=stream) for stream in (1, 1, 2))
        np.testing.assert_array_equal(first.theta_i, again.theta_i)
        self.assertFalse(np.array_equal(first.theta_i, other.theta_i))

    def test_rows_are_learned(self):
        fiber = tress.Bcsdf(tress.Material(hair="brown"), estimator="fitted", epsilon=0.05)
        self.assertIsNone(tress.Bcsdf().publish())
        theta = np.full(4000, 0.3)
        for stream in range(12):
            fiber.sample(theta, 0.9, stream=stream)
            report = fiber.publish()
        self.assertGreater(report.rows_converged, 0)
        self.assertGreater(report.converged_queries, 0.9 * report.queries)
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "brown.cache")
            fiber.save(file)
            warm = tress.Bcsdf(tress.Material(hair="brown"), estimator="fitted", epsilon=0.05)
            warm.load(file)
            drawn, again = (one.sample(theta, 0.9, stream=99) for one in (fiber, warm))
            np.testing.assert_array_equal(drawn.theta_i, again.theta_i)
            report = warm.publish()
            self.assertGreater(report.converged_queries, 0.9 * report.queries)
            for wrong, kind in ((folder, OSError), (file + "2", FileNotFoundError)):
                with self.assertRaises(kind):
                    warm.load(wrong)
        with self.assertRaisesRegex(tress.Error, "estimator: expected one that learns"):
            tress.Bcsdf().save("none.cache")

    def test_refuses_what_is_none(self):
        with self.assertRaisesRegex(tress.Error, "/materials/0/eccentricity: expected 0.5..1, found 2"):
            tress.Bcsdf(tress.Material(eccentricity=2))
        with self.assertRaisesRegex(tress.Error, "model: expected one that can be evaluated"):
            tress.Bcsdf(model="fiber3d").evaluate(0, 0, 0, 0)
        with self.assertRaisesRegex(tress.Error, "model: expected one of elliptical"):
            tress.Bcsdf(model="none")


if __name__ == "__main__":
    unittest.main()
