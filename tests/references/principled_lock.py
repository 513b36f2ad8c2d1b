"""Principled Hair against the node's own model: principled_lock.py TRESS FOLDER

A lock of 300 wavy strands under a card, a sun behind it and a grey sky, in four looks: the material `principled` and `--model chiang2016` at the
node's own widths. Fails where the means of all pixels differ by more than LIMIT and 4 standard errors of both (false-alarm rate 6e-5 each; the
seed is fixed), or where the widths that bench/principled/mapping.py states, fitted and published ones, are not the
program's, by one hit of every path.
"""

import json
import math
import pathlib
import sys

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "bench" / "principled"), str(ROOT / "scenes" / "blender" / "tress_render")]
import files  # noqa: E402
import mapping  # noqa: E402

TRESS, FOLDER = sys.argv[1], pathlib.Path(sys.argv[2])
LIMIT = 0.05  # of what the widths were fitted to (scenes/blender/README.md); black hair, which is R, is further off
NODE = {"roughness": 0.3, "radial_roughness": 0.3, "coat": 0.0, "eta": 1.55, "offset_deg": 2.0}
LOOKS = {
    "brown": {**NODE, "melanin": 0.6, "redness": 0.3},
    "blond": {**NODE, "melanin": 0.2, "redness": 0.3},
    "red": {**NODE, "color": [0.6, 0.15, 0.05]},
    "rough": {**NODE, "melanin": 0.4, "redness": 0.5, "roughness": 0.5, "radial_roughness": 0.5},
}


def write_strands(path, count=300, points=13):
    random = np.random.default_rng(5)
    angle, away = random.uniform(0, 2 * math.pi, count), 6 * np.sqrt(random.uniform(0, 1, count))
    t, phase = np.linspace(0, 1, points)[None, :], random.uniform(0, 2 * math.pi, (count, 1))
    x = (away * np.cos(angle))[:, None] * (1 - 0.4 * t) + 0.8 * t * np.sin(9 * t + phase)
    y = (away * np.sin(angle))[:, None] * (1 - 0.4 * t) + 0.8 * t * np.cos(9 * t + phase)
    strands = np.stack([x, y, 30 * (0.5 - t) + 0 * x], 2)
    files.write_hair(path, [points] * count, strands, np.full(count * points, 0.1))


def scene_of(look):
    return {
        "camera": {"eye": [0, -100, 5], "look_at": [0, 0, 0], "vertical_fov_deg": 21},
        "image": {"width": 32, "height": 32, "samples": 64, "transparent": True},
        "lights": [{"rectangle": {"center": [50, -80, 60], "look_at": [0, 0, 0], "width_cm": 40, "height_cm": 40, "radiance": [23, 23, 23]}},
                   {"distant": {"direction": [-1, 1.5, 1], "angle_deg": 0.526, "irradiance": [1.5, 1.5, 1.5]}}],
        "materials": [{"name": "hair", "principled": look}],
        "environment": {"constant": [0.35, 0.35, 0.35]},
        "grooms": [{"file": "strands.hair", "up": "z", "cm_per_unit": 1, "basis": "linear", "material": "hair"}],
    }


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    write_strands(FOLDER / "strands.hair")
    failed = False
    for name, look in LOOKS.items():
        (FOLDER / "scene.json").write_text(json.dumps(scene_of(look)))
        usual = ["--model", "elliptical", "--estimator", "exact"]
        once, _ = mapping.render(TRESS, FOLDER, 4, 1, None, usual, 1)
        stated, _ = mapping.render(TRESS, FOLDER, 4, 1, mapping.factors_of_the_program(), usual, 1)
        parts = abs(stated - once).max() / once.max()
        ours, of_ours = mapping.render(TRESS, FOLDER, 256, 1, None, ["--model", "elliptical"])
        node, of_node = mapping.render(TRESS, FOLDER, 256, 1, mapping.NODES_OWN, ["--model", "chiang2016"])
        stated, _ = mapping.render(TRESS, FOLDER, 4, 1, mapping.NODES_OWN, ["--model", "chiang2016"], 1)
        (FOLDER / "scene.json").write_text(json.dumps(scene_of({**look, "widths": "published"})))
        once, _ = mapping.render(TRESS, FOLDER, 4, 1, None, ["--model", "chiang2016"], 1)
        parts = max(parts, abs(stated - once).max() / once.max())
        ratio, error = ours.mean() / node.mean(), math.hypot(of_ours / ours.mean(), of_node / node.mean())
        print(f"{name}: {ratio:.3f} +- {error:.3f} of chiang2016; widths as stated to {parts:.1e}")
        failed = failed or not abs(ratio - 1) < LIMIT + 4 * error or not parts < 1e-4
    return failed


if __name__ == "__main__":
    sys.exit(main())
