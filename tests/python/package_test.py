"""The wheel as pip installs it, without a network; the five lines of the README and every example, from there."""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

from support import PACKAGE, SOURCE

README = (SOURCE / "src/python/README.md").read_text()


def run(arguments, folder, package):
    environment = {**os.environ, "PYTHONPATH": str(package), "TRESS_EXAMPLE_SMALL": "1"}
    return subprocess.run([sys.executable, *map(str, arguments)], cwd=folder, env=environment, capture_output=True, text=True)


class Package(unittest.TestCase):
    def test_the_wheel_is_installed_and_runs_the_five_lines(self):
        with tempfile.TemporaryDirectory() as folder:
            maker = [SOURCE / "src/python/make_wheel.py", PACKAGE / "tress", folder, "--version", "1.2.3"]
            made = run(maker, folder, "")
            self.assertEqual(made.returncode, 0, made.stderr)
            wheel = made.stdout.strip()
            first = pathlib.Path(wheel).read_bytes()
            run(maker, folder, "")
            self.assertEqual(pathlib.Path(wheel).read_bytes(), first)
            site = pathlib.Path(folder, "site")
            pip = ["-m", "pip", "install", "--no-index", "--no-deps", "--disable-pip-version-check", "--target", site, wheel]
            installed = run(pip, folder, "")
            self.assertEqual(installed.returncode, 0, installed.stderr)
            lines = re.search(r"```python\n(.*?)```", README, re.S)[1]
            self.assertEqual(len([line for line in lines.splitlines() if line.strip()]), 5)
            small = lines.replace("20000", "500").replace("samples=16", "samples=1, width=48, height=48")
            self.assertNotEqual(small, lines)
            script = small + "\nimport sys; print(sys.modules['tress'].__file__)"
            done = run(["-c", script], folder, site)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertTrue(done.stdout.strip().startswith(str(site)), done.stdout)
            for name in ("groom.exr", "groom.png"):
                self.assertGreater(pathlib.Path(folder, name).stat().st_size, 1000)

    def test_every_example_runs(self):
        examples = sorted((SOURCE / "src/python/examples").glob("*.py"))
        self.assertGreaterEqual(len(examples), 3)
        for example in examples:
            with self.subTest(example.name), tempfile.TemporaryDirectory() as folder:
                done = run([example], folder, PACKAGE)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertIn("# %%", example.read_text())


if __name__ == "__main__":
    unittest.main()
