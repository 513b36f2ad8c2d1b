"""What the figure scripts share: rendering through tress, reading its pictures, labelled sheets of them.

A script is `bench/figures/NAME.py [-o FOLDER] [--tress PROGRAM] ...`; it renders into FOLDER (default build/figures),
one EXR per picture, and writes its PNG there. Pictures that are there already are kept with --reuse, so that a sheet can
be laid out again without rendering. Needs Debian's python3-openimageio, python3-matplotlib and python3-numpy
(/usr/bin/python3).

    options = figures.parse(__doc__)
    picture = figures.read(figures.render(options, "scenes/brown_lock.json", "lock_deon", "--model", "deon2011"))
    figures.sheet(options, "figure", [[("d'Eon 2011", picture)]])
"""
import argparse
import json
import os
import subprocess
import sys

import matplotlib
import numpy
import OpenImageIO

matplotlib.use("Agg")
import matplotlib.pyplot as pyplot  # noqa: E402

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def parse(doc, samples=64, size=None, add=None):
    """Options of every figure script: doc is its text of help, samples and size ("WxH", None: the scene's) its defaults,
    add(parser) its own. Makes the output folder."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", default=os.path.join(ROOT, "build", "figures"), help="folder")
    parser.add_argument("--tress", default=os.path.join(ROOT, "build", "release", "tress"), help="the program")
    parser.add_argument("--samples", type=int, default=samples, help="per pixel (%(default)s)")
    parser.add_argument("--size", default=size, help="WxH (the scene's)" if size is None else "WxH (%(default)s)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--exposure", type=float, default=0.0, help="stops, of the PNG alone")
    parser.add_argument("--reuse", action="store_true", help="keep pictures that are there")
    if add:
        add(parser)
    options = parser.parse_args()
    options.build = os.path.dirname(os.path.abspath(options.tress))
    options.tress = os.path.join(options.build, "bench", "tress-lab")  # tress with the rivals
    os.makedirs(options.output, exist_ok=True)
    return options


def path(options, name):
    return os.path.join(options.output, name)


def scene_path(scene):
    """A scene as scripts name it: from the top of the source tree, wherever they are run."""
    return scene if os.path.isabs(scene) else os.path.join(ROOT, scene)


def run(command):
    """Runs it; its standard output. What it says on stderr is shown if it fails, and the script ends."""
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}\n{done.stderr}")
    return done.stdout


def bench(options, name):
    """The program bench_NAME that was built with options.tress."""
    return os.path.join(options.build, "bench", "bench_" + name)


def render(options, scene, name, *flags):
    """Renders scene with tress's `flags` into FOLDER/name.exr and returns that path."""
    out = path(options, name + ".exr")
    if options.reuse and os.path.exists(out):
        return out
    print(f"rendering {name}", file=sys.stderr, flush=True)
    command = [options.tress, "render", scene_path(scene), "-o", out, "--quiet"]
    if "--seed" not in flags:
        command += ["--seed", str(options.seed)]
    if not {"--spp", "--time", "--noise"} & set(flags):
        command += ["--spp", str(options.samples)]
    if options.size and "--resolution" not in flags:
        command += ["--resolution", options.size]
    run(command + [str(flag) for flag in flags])
    return out


def variant(options, scene, name, change):
    """FOLDER/name.json: the scene after change(its JSON), which works in place. Files it names stay where they are."""
    source = scene_path(scene)
    with open(source) as file:
        content = json.load(file)
    content.pop("$schema", None)

    def absolute(value):
        if isinstance(value, list):
            return [absolute(entry) for entry in value]
        if not isinstance(value, dict):
            return value
        return {key: os.path.join(os.path.dirname(source), entry) if key == "file" else absolute(entry)
                for key, entry in value.items()}

    content = absolute(content)
    change(content)
    out = path(options, name + ".json")
    with open(out, "w") as file:
        json.dump(content, file, indent=1)
    return out


def materials(**changes):
    """A change for variant(): sets these keys of every material."""
    def change(scene):
        for material in scene["materials"]:
            material.update(changes)
    return change


def channels_of(exr):
    """Names of the channels, and their values, float32 of height x width x channels, as the file is now. An ImageBuf would not do:
    it hands out what it has read before of a file that was written again within the same second."""
    opened = OpenImageIO.ImageInput.open(exr)
    if opened is None:
        sys.exit(f"{exr}: {OpenImageIO.geterror()}")
    names, pixels = list(opened.spec().channelnames), opened.read_image(OpenImageIO.FLOAT)
    opened.close()
    if pixels is None:
        sys.exit(f"{exr}: {opened.geterror()}")
    return names, pixels


def read(exr, layer="", behind=0.0):
    """Linear RGB of a picture or of one of its layers ("TRT"), float32 of height x width x 3. behind: radiance that is
    put behind what does not cover a pixel (beauty with an alpha only)."""
    names, pixels = channels_of(exr)
    wanted = [(layer + "." if layer else "") + c for c in "RGB"]
    if any(name not in names for name in wanted):
        sys.exit(f"{exr}: expected channels {wanted}, found {list(names)}")
    rgb = pixels[:, :, [names.index(name) for name in wanted]]
    if behind and not layer and "A" in names:
        rgb = rgb + behind * (1 - numpy.clip(pixels[:, :, [names.index("A")]], 0, 1))
    return rgb


def coverage(exr):
    """The coverage of a picture (A in those from before it had a layer of its own), in [0, 1], height x width."""
    names, pixels = channels_of(exr)
    return numpy.clip(pixels[:, :, names.index("coverage" if "coverage" in names else "A")], 0, 1)


def blocks(pixels, side=8):
    """Means of side x side pixels: noise falls by `side`, what a model makes brighter or darker stays."""
    height, width = (size // side * side for size in pixels.shape[:2])
    shape = (height // side, side, width // side, side) + pixels.shape[2:]
    return pixels[:height, :width].reshape(shape).mean(axis=(1, 3))


def tone_map(linear, exposure=0.0):
    """sRGB in [0, 1] of linear RGB, clipped: no curve, so that pictures of one sheet can be compared."""
    x = numpy.clip(numpy.nan_to_num(linear) * 2.0**exposure, 0, 1)
    return numpy.where(x <= 0.0031308, 12.92 * x, 1.055 * numpy.power(x, 1 / 2.4) - 0.055)


def diff(options, picture, truth):
    """What `tress diff --json` says of two EXR: relMSE, MAE, bias, ... of picture against truth."""
    return json.loads(run([options.tress, "diff", truth, picture, "--json"]))


def sheet(options, name, rows, title=None, gap=6):
    """FOLDER/name.png: rows of (label, linear RGB or None for an empty place), a picture's pixel being the sheet's.
    Pictures of a row may differ in size; labels stand above them. Returns the path."""
    dpi, line = 100, 20
    heights = [max((cell[1].shape[0] for cell in row if cell[1] is not None), default=0) for row in rows]
    widths = [sum((0 if cell[1] is None else cell[1].shape[1]) + gap for cell in row) for row in rows]
    top = line if title else 0
    width, height = max(widths) + gap, top + sum(h + line + gap for h in heights)
    figure = pyplot.figure(figsize=(width / dpi, height / dpi), dpi=dpi, facecolor="white")
    if title:
        figure.text(0.5, 1 - 0.5 * line / height, title, ha="center", va="center", fontsize=9, weight="bold")
    y = top
    for row, row_height in zip(rows, heights):
        x, y = gap, y + line
        for label, pixels in row:
            shape = (0, 0) if pixels is None else pixels.shape
            if pixels is not None:
                figure.figimage(tone_map(pixels, options.exposure), x, height - y - shape[0], origin="upper")
            figure.text((x + shape[1] / 2) / width, 1 - (y - line / 2) / height, label, ha="center", va="center",
                        fontsize=8)
            x += shape[1] + gap
        y += row_height + gap
    out = path(options, name + ".png")
    figure.savefig(out, dpi=dpi)
    pyplot.close(figure)
    print(out)
    return out


def save_plot(options, name, figure):
    """A matplotlib figure as FOLDER/name.png and .svg, beside each other."""
    figure.savefig(path(options, name + ".svg"))
    figure.savefig(path(options, name + ".png"), dpi=120)
    pyplot.close(figure)
    print(path(options, name + ".png"))
