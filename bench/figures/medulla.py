#!/usr/bin/env python3
"""Fur with and without a medulla, by `rough`, by the traced truth, and by `elliptical`, which has none.

The fox of scenes/fur_medulla.json; without: scenes/fur_ball.json.
"""
import figures

MODELS = ("rough", "fiber3d", "elliptical")


def main():
    options = figures.parse(__doc__, samples=64, size="200x200")
    rows = []
    for scene, name in (("scenes/fur_ball.json", "without"), ("scenes/fur_medulla.json", "with a medulla")):
        row = []
        for model in MODELS:
            exr = figures.render(options, scene, f"medulla_{name.split()[0]}_{model}", "--model", model)
            row.append((f"{model}, {name}", figures.read(exr, behind=0.5)))
        rows.append(row)
    figures.sheet(options, "medulla", rows, "a core of 0.7 that scatters, without pigment")


if __name__ == "__main__":
    main()
