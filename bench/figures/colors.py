#!/usr/bin/env python3
"""One lock from black to white hair, a concentration of melanin each: the picture of scenes/README.md (scenes/colors.png)."""
import figures

COLORS = [
    ("black", "8"),
    ("dark brown", "3,0.3"),
    ("brown", "1.3"),
    ("light brown", "0.6,0.6"),
    ("red", "0.05,0.9"),
    ("blond", "0.25,0.35"),
    ("platinum", "0.05,0.05"),
    ("white", "0"),
]


def main():
    options = figures.parse(__doc__, samples=48, size="104x160")
    cells = []
    for name, melanin in COLORS:
        exr = figures.render(options, "scenes/brown_lock.json", "color_" + name.replace(" ", "_"), "--melanin", melanin)
        cells.append((f"{name} {melanin}", figures.read(exr)))
    figures.sheet(options, "colors", [cells])


if __name__ == "__main__":
    main()
